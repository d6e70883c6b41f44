"""The configuration of a study: its sections are checked here, and converted to SI."""

import functools
import math
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Annotated, ClassVar, Self, TypeVar

from pydantic import PrivateAttr, create_model, model_validator

from jointclosure import parameters
from jointclosure.assessment.numerical_settings import FINEST
from jointclosure.inputs import InputError, did_you_mean
from jointclosure.joint.load import LARGEST_SEATING, usual_seating
from jointclosure.parameters.units import SI_FACTORS, in_unit, name_and_unit, unit_meant
from jointclosure.walls.jrc import relation_of
from jointclosure.walls.synthesis import check_mismatch, spectrum_of
from studies.frame import keys
from studies.frame.keys import entry
from studies.frame.rocks import StudyRock
from studies.frame.yaml_files import DEFAULT, folder_of, merged, read_plain, refuse

_Section = TypeVar("_Section", bound="StudySection")


class StudySection(keys.Section):
    """Section of an experiment in a configuration.

    It is defined in ``section.py`` of the experiment's folder, and has the name of the folder.
    """

    mates: ClassVar[bool] = False
    """Whether the experiment sets how far walls mate, so that the study's own keys must not."""
    by_default: ClassVar[bool] = False
    """Whether the section has its default keys if a file leaves it out; otherwise it is null."""
    of_scans: ClassVar[bool] = False
    """Whether the experiment also takes scanned walls; otherwise it needs walls of a given JRC."""

    def problems(self, configuration: "Configuration") -> Iterator[str]:
        """Generate a line for each contradiction within the section or with the study."""
        yield from ()


class Configuration(keys.Section):
    """Configuration of a study."""

    study: keys.Study
    rocks: dict[keys.Name, StudyRock] = entry(
        "Rocks by name; a study's own file may add some.", min_length=1
    )
    grid: keys.Grid
    surface: keys.SurfaceSynthesis
    seating_stress: Annotated[float, keys.OR_NULL] = entry(
        "Stress from which seated closures count [MPa]; it changes what is read, never what "
        "happens. null: 0.5, or a tenth of the rocks' smallest maximum if 0.5 is above 0.9 of it. "
        "A changed value simulates all joints again, because the results that are stored of a "
        "joint count from it, and not all of its steps are stored.",
        None,
        alias="seating_stress_MPa",
        ge=0,
    )
    effects: keys.StudyEffects
    flow: bool = entry(
        "Whether hydraulic apertures are found too, by Reynolds' equation at every step "
        "(docs/export.md#flow); it changes nothing else.",
        False,
    )
    choices: Annotated[parameters.Choices, keys.made_of(keys.ChoiceKeys)]
    numerics: Annotated[parameters.Numerics, keys.made_of(keys.NumericsKeys)]
    statistics: keys.Statistics
    output: keys.Output
    _stated: dict = PrivateAttr(default_factory=dict)

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        """Return the configuration with the study's rocks only, in the study's order.

        Values that follow from other keys are filled in where these are null. Raise `ValueError`
        for unknown rocks.
        """
        if unknown := [name for name in self.study.rocks if name not in self.rocks]:
            allowed = f"must be one of rocks ({', '.join(self.rocks)})"
            meant = {name: did_you_mean(name, self.rocks) for name in unknown}
            lines = (f"study.rocks = {name!r}: {allowed}{word}" for name, word in meant.items())
            raise ValueError("\n".join(lines))
        usual = self.effects.acting
        rocks = {
            name: self.rocks[name].titled(name).with_effects(usual) for name in self.study.rocks
        }
        output = self.output
        numerics = self.numerics
        seating = self.seating_stress
        maxima = [rock.max_normal_stress for rock in rocks.values()]
        if output.largest_stress is None:
            output = output._replace(largest_stress=max(maxima))
        if seating is None:
            seating = usual_seating(min(maxima))
        if numerics.idle_interaction is None:
            numerics = numerics._replace(idle_interaction=self.effects.auto or 0.0)
        return self._replace(rocks=rocks, output=output, numerics=numerics, seating_stress=seating)

    @property
    def stated(self) -> dict:
        """Merged keys, in the units of files, from which the configuration was read."""
        return self._stated

    @property
    def titles(self) -> dict[str, str]:
        """Titles of the rocks by their names, in the order of the study."""
        return {name: rock.title for name, rock in self.rocks.items()}

    def file(self, name: str) -> str:
        """Return the path of a file in the study's folder of results."""
        return f"results/{self.study.name}/{name}"

    @property
    def study_sections(self) -> dict[str, StudySection]:
        """Sections of experiments that a file states and that are not null, by name."""
        return {
            name: getattr(self, name) for name in sections() if self.stated.get(name) is not None
        }

    def section_or_none(self, kind: type[_Section]) -> _Section | None:
        """Return the section of an experiment by its class; None if it is null."""
        section: _Section | None = getattr(self, folder_of(kind))
        return section

    def section(self, kind: type[_Section]) -> _Section:
        """Return the section of an experiment by its class; raise `InputError` if it is null."""
        section = self.section_or_none(kind)
        if section is None:
            raise InputError(f"{folder_of(kind)} = null: must be given for this study")
        return section


@functools.cache
def sections() -> dict[str, type[StudySection]]:
    """Return the classes of the sections of all experiments, by the names of their folders.

    All modules ``section.py`` are imported.
    """
    for path in Path(__file__).parents[1].glob("*/section.py"):
        import_module(f"studies.{path.parent.name}.section")
    found = sorted(StudySection.__subclasses__(), key=folder_of)
    return {folder_of(section): section for section in found}


@functools.cache
def model() -> type[Configuration]:
    """Return the model of a whole configuration, with the sections of all experiments."""
    return create_model(
        "Configuration",
        __base__=Configuration,
        __doc__=Configuration.__doc__,
        **{  # type: ignore[call-overload]
            name: (section | None, section() if section.by_default else None)
            for name, section in sections().items()
        },
    )


OTHER_TARGETS = ("hard_cases",)
"""Folders of results that belong to targets other than studies, so that no study may have them."""
USUAL = parameters.USUAL | {"stress": parameters.USUAL["max_normal_stress"]}
"""Least and largest usual value [SI] and the unit, by the name of a key without its unit."""


def merged_study(*paths: Path) -> dict:
    """Return the keys of configuration files, merged over the default one, in their units.

    Later files replace keys of earlier ones. The result is not checked yet.
    """
    return merged(*(written_out(read_plain(path)) for path in (DEFAULT, *paths)))


def written_out(stated: dict) -> dict:
    """Return keys in which ``effects: auto`` is replaced by all effects and `AUTO_TOLERANCE`."""
    if stated.get("effects") != "auto":
        return stated
    effects = parameters.Effects()._asdict() | {"auto": parameters.AUTO_TOLERANCE}
    return stated | {"effects": effects}


def configured(stated: dict) -> Configuration:
    """Return the configuration [SI] of merged keys, with all checks.

    Raise `ConfigurationError` that lists each wrong key and each contradiction.
    """
    study = read_stored(written_out(stated))
    refuse(contradictions(study))
    return study


def read_stored(stated: dict) -> Configuration:
    """Return the configuration [SI] of merged keys that are stored with a finished study.

    Values that follow from other keys are filled in. Raise `ConfigurationError` for wrong keys.
    Contradictions between keys are not looked for, as `configured` did so when the study was made.
    """
    study = keys.validated(model(), stated)
    study._stated = stated
    return study


def contradictions(whole: Configuration) -> Iterator[str]:
    """Generate a line for each contradiction between keys that are valid on their own."""
    stated = whole.stated
    study = whole.study
    surface = whole.surface
    spacing = whole.grid.spacing
    numerics = whole.numerics
    surfaces = whole.statistics.control_variates
    closed = max(study.realizations, study.pool or 0, study.accuracy.most if study.accuracy else 0)
    if surfaces is not None and surfaces <= closed:
        yield (
            f"statistics.control_variates = {surfaces}: must be more than the {closed} surfaces of "
            "a case, whose means they adjust (or null: no adjustment)"
        )
    finest = FINEST.tolerance
    if study.accuracy and numerics.breakage == "resolved" and numerics.tolerance < finest:
        yield (
            f"numerics.tolerance = {numerics.tolerance:g}: must be at least {finest:g} with "
            "study.accuracy, that of the finest numerics"
        )
    if study.name in {*OTHER_TARGETS, *sections()} - whole.study_sections.keys():
        yield (
            f"study.name = {study.name!r}: results/{study.name} belongs to another target; "
            "must be another name"
        )
    if study.unusual_values == "refuse":
        rocks = {name: stated["rocks"][name] for name in whole.rocks}
        yield from _unusual(stated | {"rocks": rocks})
    scenes = dict.fromkeys([whole.effects.acting, *(rock.effects for rock in whole.rocks.values())])
    checks: list[tuple] = [(parameters.check_scene, scene) for scene in scenes]
    checks += [
        (spectrum_of, surface.hurst, surface.rule, surface.roll_off, spacing),
        (check_mismatch, surface.mismatch_wavelength, surface.correlation),
        (parameters.check_choices, whole.choices),
        (parameters.check_radius, whole.choices, spacing),
        (parameters.check_numerics, numerics),
    ]
    refused = list(_refused(checks))
    if not refused:  # only settings that are allowed can be without an effect
        acting = parameters.Effects(*map(any, zip(*scenes, strict=True)))  # in any rock
        stated_numerics = numerics._replace(
            idle_interaction=stated["numerics"].get("idle_interaction") or 0.0
        )
        model = acting, whole.choices, stated_numerics, parameters.Numerics(), True
        refused = list(_refused([(parameters.check_effective, *model)]))
    yield from refused
    mating = surface.mismatch_wavelength, surface.correlation, surface.shift_in_cells
    for name, section in whole.study_sections.items():
        yield from section.problems(whole)
        if section.mates and mating != (None, 0.0, 0):
            yield (
                f"{name}: the study sets surface.mismatch_wavelength_mm; it, correlation and "
                "shift_in_cells must be null, 0 and 0"
            )
    titles: dict[str, str] = {}
    for name, rock in whole.rocks.items():
        title = " ".join(rock.title.split())
        if (other := titles.setdefault(title, name)) != name:
            yield (
                f"rocks.{name}.title = {rock.title!r}: must differ from that of rocks.{other}; "
                "tables and figures name rocks by their titles"
            )
        yield from rock.problems(f"rocks.{name}")
        yield from _rock_problems(f"rocks.{name}", rock, whole)


def _refused(checks: Iterable[tuple]) -> Iterator[str]:
    """Call checks, given as (function, arguments); generate the messages of their `InputError`."""
    for check, *arguments in checks:
        try:
            check(*arguments)
        except InputError as error:
            yield str(error)


def _rock_problems(where: str, rock: StudyRock, whole: Configuration) -> Iterator[str]:
    """Generate a line for each contradiction of a rock with the study; ``where`` is its key."""
    seating = whole.seating_stress
    end = whole.output.largest_stress
    stress = f"{where}.max_normal_stress_MPa = {in_unit(rock.max_normal_stress, 'MPa'):g}"
    if seating > LARGEST_SEATING * rock.max_normal_stress:
        least = f"must be at most {LARGEST_SEATING:g} of {stress}"
        yield f"seating_stress_MPa = {in_unit(seating, 'MPa'):g}: {least}"
    if end < rock.max_normal_stress:
        yield f"output.largest_stress_MPa = {in_unit(end, 'MPa'):g}: must be at least {stress}"
    relation = relation_of(whole.surface.jrc_relation)
    for jrc in (rock.jrc, *(rock.other_levels.jrc or ())):
        if not relation.smallest_jrc <= jrc <= relation.largest_jrc and not math.isnan(jrc):
            yield (
                f"{where}: jrc = {jrc:g}: {whole.surface.jrc_relation} holds from "
                f"{relation.smallest_jrc:g} to {relation.largest_jrc:g}"
            )
    yield from _beyond_strength(where, rock, whole)
    for name, section in whole.study_sections.items() if rock.walls else ():
        if not section.of_scans:
            yield f"{name}: not with {where}.walls; it draws walls of given JRC"


def _beyond_strength(where: str, rock: StudyRock, whole: Configuration) -> Iterator[str]:
    """Generate a line if no walls can carry the maximum stress of a rock.

    The rock is tried with its own properties, and with each level of them. ``where`` is its key.
    """
    cases = [("", "", rock)]
    for name in (name for name in parameters.OF_ROCK if name in rock.levels):
        key = f"{where}.levels.{parameters.key_of(name)} ="
        for level in getattr(rock.other_levels, name):
            value = f"{in_unit(level, parameters.OF_ROCK[name].unit):g}"
            changed = rock.intact._replace(**{name: level})
            cases.append((key, value, rock._replace(**changed._asdict())))
    key = f"{where}.max_normal_stress_MPa"
    yield from stress_problems(key, rock.max_normal_stress, cases, whole)


def stress_problems(
    key: str,
    stress: float,
    cases: Iterable[tuple[str, str, StudyRock]],
    whole: Configuration,
    more: Iterable[parameters.Numerics] = (),
) -> Iterator[str]:
    """Generate one line if no walls of some cases can carry a maximum stress [Pa].

    ``key`` is where the stress is stated. Each of the ``cases`` is (what is changed, its value, the
    rock with this change); both texts are "" for an unchanged rock. ``more`` are numerics with
    which joints are simulated besides those of the study. The line lists each case that cannot
    carry the stress, with the stress that it carries. If the unchanged rock is among them, cases
    that carry the same stress as it are left out.
    """
    from jointclosure.joint.feasibility import largest_stress  # loads the solvers

    # a requested accuracy also simulates joints by the finest numerics
    settings = [whole.numerics, *more, *([FINEST] if whole.study.accuracy else [])]
    refused = dict[str, dict[str, str]]()
    for changed, value, rock in cases:
        model = (rock.intact, rock.intact), rock.effects, whole.choices
        most = min(largest_stress(*model, numerics, whole.grid.spacing) for numerics in settings)
        carried = f"{in_unit(most, 'MPa'):.3g} MPa"
        if most < stress and carried != refused.get("", {}).get(""):
            refused.setdefault(changed, {})[value] = carried
    if not refused:
        return
    bound = "choices.strength_bound: base"
    radius = whole.choices.largest_radius
    if radius is not None and whole.choices.strength_bound != "base":
        bound = f"choices.largest_radius_mm = {in_unit(radius, 'mm'):g}"
    carries = f"all cells of the walls carry together with {bound}"
    stated = f"{key} = {in_unit(stress, 'MPa'):g}: must be less than"
    if sum(map(len, refused.values())) == 1:
        ((changed, of_value),) = refused.items()
        ((value, carried),) = of_value.items()
        yield f"{stated} {carried}, which {carries}" + (f" and {changed} {value}" * bool(changed))
        return
    of_rock = refused.pop("", {}).get("")
    listed = "; ".join(
        f"with {changed} " + ", ".join(f"{value}: {most}" for value, most in of_value.items())
        for changed, of_value in refused.items()
    )
    yield f"{stated} {f'{of_rock}, which' if of_rock else 'the stress that'} {carries} ({listed})"


def _unusual(stated: dict, where: str = "") -> Iterator[str]:
    """Generate a line for each value of nested keys, in their units, that is unusual for rock.

    ``where`` is the path of the section, which precedes the key. A value of 0 is accepted.
    """
    for key, value in stated.items():
        name, unit = name_and_unit(key)
        if isinstance(value, dict):
            yield from _unusual(value, f"{where}{key}.")
        elif name in USUAL and value is not None:
            low, high = (in_unit(bound, unit) for bound in USUAL[name][:2])
            for number in value if isinstance(value, list) else [value]:
                if not (low <= number <= high or number == 0.0):
                    yield (
                        f"{where}{key} = {number!r}: not usual of rock ({low:g} to {high:g} {unit})"
                        f"; {unit_meant(number * SI_FACTORS.get(unit, 1.0), *USUAL[name])} "
                        "study.unusual_values: allow takes it as it is"
                    )
