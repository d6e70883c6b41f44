"""The configuration of a study: merged, checked and in SI, once and in one place."""

import functools
import math
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple, Self, TypeVar

from pydantic import create_model, model_validator

from jointclosure.engine.assess import FINEST
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import LARGEST_SEATING, usual_seating
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    Choices,
    Effects,
    Numerics,
    check_choices,
    check_numerics,
    check_scene,
)
from jointclosure.parameters import USUAL as _OF_ROCK
from jointclosure.parameters.units import SI_FACTORS, in_unit, name_and_unit, unit_meant
from jointclosure.walls.roughness import relation_of
from jointclosure.walls.synthesis import check_mismatch, spectrum_of
from studies.frame.files import DEFAULT, folder_of, merged, read_plain, refuse
from studies.frame.keys import (
    OR_NULL,
    ChoiceKeys,
    Grid,
    Name,
    NumericsKeys,
    Output,
    Section,
    Statistics,
    Study,
    StudyEffects,
    Surface,
    did_you_mean,
    entry,
    made_of,
    validated,
)
from studies.frame.rocks import CurveSettings, StudyRock

_Section = TypeVar("_Section", bound="StudySection")


class StudySection(Section):
    """Section of one experiment, in the module ``section`` of its folder, whose name it has."""

    mates: ClassVar[bool] = False
    """Whether it sets how far walls mate, so that the study must not."""
    of_scans: ClassVar[bool] = False
    """Whether walls may be scanned; others draw walls of given JRC."""

    def problems(self, configuration: "Configuration") -> Iterator[str]:
        """Generate contradictions within the section, and with the study; one line each."""
        yield from ()


class Configuration(Section):
    """Configuration of a study."""

    study: Study
    rocks: dict[Name, StudyRock] = entry(
        "Rocks by name; a study's own file may add some.", min_length=1
    )
    grid: Grid
    surface: Surface
    seating_stress: Annotated[float, OR_NULL] = entry(
        "Stress from which seated closures count [MPa]; it changes what is read, never what "
        "happens. null: 0.5, or a tenth of the rocks' smallest maximum if 0.5 is above 0.9 of it.",
        None,
        alias="seating_stress_MPa",
        ge=0,
    )
    effects: StudyEffects
    flow: bool = entry(
        "Whether hydraulic apertures are found too, by Reynolds' equation at every step "
        "(docs/export.md#flow); it changes nothing else.",
        False,
    )
    choices: Annotated[Choices, made_of(ChoiceKeys)]
    numerics: Annotated[Numerics, made_of(NumericsKeys)]
    statistics: Statistics
    output: Output

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        """Take the rocks of the study in its order, and what other sections leave open."""
        if unknown := [name for name in self.study.rocks if name not in self.rocks]:
            allowed = f"must be one of rocks ({', '.join(self.rocks)})"
            meant = (f"{name!r}: {allowed}{did_you_mean(name, self.rocks)}" for name in unknown)
            raise ValueError("\n".join(f"study.rocks = {line}" for line in meant))
        usual = self.effects.acting
        rocks = {name: self.rocks[name].with_effects(usual) for name in self.study.rocks}
        output, numerics, seating = self.output, self.numerics, self.seating_stress
        maxima = [rock.max_normal_stress for rock in rocks.values()]
        if output.largest_stress is None:
            output = output._replace(largest_stress=max(maxima))
        if seating is None:
            seating = usual_seating(min(maxima))
        if numerics.idle_interaction is None:
            numerics = numerics._replace(idle_interaction=self.effects.auto or 0.0)
        return self._replace(rocks=rocks, output=output, numerics=numerics, seating_stress=seating)

    @property
    def pooled(self) -> bool:
        """Whether the study has a pool, by which the model is judged."""
        return self.study.pool is not None

    @property
    def varied(self) -> bool:
        """Whether a property is varied."""
        return any(rock.levels for rock in self.rocks.values())

    @property
    def variates(self) -> bool:
        """Whether means are adjusted by covariates; those of scanned walls are not known."""
        synthetic = any(rock.walls is None for rock in self.rocks.values())
        return self.statistics.control_variates is not None and synthetic

    def file(self, name: str) -> str:
        """Return the path of a file of the study."""
        return f"results/{self.study.name}/{name}"

    @property
    def curves(self) -> dict[str, CurveSettings]:
        """Settings of the measured curves by rock, for rocks of the study that have one."""
        cycles, seating = self.study.cycles, self.seating_stress
        return {
            name: CurveSettings(rock.measured, rock.max_normal_stress, cycles, seating)
            for name, rock in self.rocks.items()
            if rock.measured
        }

    @property
    def study_sections(self) -> dict[str, StudySection]:
        """Sections of experiments that are given, by name."""
        given = {name: getattr(self, name, None) for name in sections()}
        return {name: section for name, section in given.items() if section is not None}

    def section(self, kind: type[_Section]) -> _Section:
        """Return the section of an experiment; raise `InputError` if it is left out."""
        section = getattr(self, folder_of(kind))
        if section is None:
            raise InputError(f"{folder_of(kind)} = null: must be given for this study")
        return section


@functools.cache
def sections() -> dict[str, type[StudySection]]:
    """Return the sections of experiments by the folder of the experiment."""
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
        **{name: (section | None, None) for name, section in sections().items()},  # type: ignore
    )


OTHER_TARGETS = ("hard_cases",)
"""Folders of results of targets that are no studies."""
USUAL = _OF_ROCK | {"stress": _OF_ROCK["max_normal_stress"]}
"""Least and largest values that are usual, and their unit, by name of a key without its unit."""


class Configured(NamedTuple):
    """A configuration as keys of a file, and in SI."""

    keys: dict
    typed: Configuration


def merged_study(*paths: Path) -> dict:
    """The default configuration and files over it, not yet checked."""
    return merged(*(written_out(read_plain(path)) for path in (DEFAULT, *paths)))


def written_out(keys: dict) -> dict:
    """Keys whose ``effects: auto`` is written out: those of the full model, chosen to 2 %."""
    if keys.get("effects") != "auto":
        return keys
    return keys | {"effects": Effects()._asdict() | {"auto": AUTO_TOLERANCE}}


def configured(keys: dict) -> Configured:
    """Check merged keys, and read them in SI; `ConfigurationError` names each that is wrong."""
    keys = written_out(keys)
    configuration = resolved(keys)
    refuse(contradictions(configuration, keys))
    return Configured(keys, configuration)


def resolved(keys: dict) -> Configuration:
    """The configuration of keys without contradictions, as those in the file of a study."""
    return validated(model(), keys)


def contradictions(configuration: Configuration, keys: dict) -> Iterator[str]:
    """Generate contradictions between keys that are each valid, one line each."""
    yield from _study_problems(configuration)
    if configuration.study.unusual_values == "refuse":
        rocks = {name: keys["rocks"][name] for name in configuration.rocks}
        yield from _unusual(keys | {"rocks": rocks}, "")
    surface, spacing = configuration.surface, configuration.grid.spacing
    effects = (rock.effects for rock in configuration.rocks.values())
    scenes = dict.fromkeys([configuration.effects.acting, *effects])
    checks: list[tuple] = [(check_scene, scene) for scene in scenes]
    checks += [
        (spectrum_of, surface.hurst, surface.rule, surface.roll_off, spacing),
        (check_mismatch, surface.mismatch_wavelength, surface.correlation),
        (check_choices, configuration.choices, spacing),
        (check_numerics, configuration.numerics),
    ]
    for check, *arguments in checks:
        try:
            check(*arguments)
        except InputError as error:
            yield str(error)
    share = keys["numerics"].get("idle_interaction")
    if share and not any(rock.effects.interaction for rock in configuration.rocks.values()):
        yield (
            f"numerics.idle_interaction = {share:g}: must be null or 0, because "
            "effects.interaction is false for every rock"
        )
    mating = surface.mismatch_wavelength, surface.correlation, surface.shift_in_cells
    for name, section in configuration.study_sections.items():
        yield from section.problems(configuration)
        if section.mates and mating != (None, 0.0, 0):
            yield (
                f"{name}: the study sets surface.mismatch_wavelength_mm; it, correlation and "
                "shift_in_cells must be null, 0 and 0"
            )
    for name, rock in configuration.rocks.items():
        yield from rock.problems(name)
        yield from _rock_problems(f"rocks.{name}", rock, configuration)


def _study_problems(configuration: Configuration) -> Iterator[str]:
    study, surfaces = configuration.study, configuration.statistics.control_variates
    most = study.accuracy.most if study.accuracy else 0
    closed = max(study.realizations, study.pool or 0, most)
    if surfaces is not None and surfaces <= closed:
        yield (
            f"statistics.control_variates = {surfaces}: must be more than the {closed} surfaces of "
            "a case, whose means they adjust (or null: no adjustment)"
        )
    finest, numerics = FINEST.tolerance, configuration.numerics
    if study.accuracy and numerics.breakage == "resolved" and numerics.tolerance < finest:
        yield (
            f"numerics.tolerance = {numerics.tolerance:g}: must be at least {finest:g} with "
            "study.accuracy, that of the finest numerics"
        )
    if study.name in {*OTHER_TARGETS, *sections()} - configuration.study_sections.keys():
        yield (
            f"study.name = {study.name!r}: results/{study.name} belongs to another target; "
            "must be another name"
        )


def _rock_problems(where: str, rock: StudyRock, configuration: Configuration) -> Iterator[str]:
    """Generate contradictions of a rock with the study, one line each."""
    seating, end = configuration.seating_stress, configuration.output.largest_stress
    stress = f"{where}.max_normal_stress_MPa = {in_unit(rock.max_normal_stress, 'MPa'):g}"
    if seating > LARGEST_SEATING * rock.max_normal_stress:
        yield (
            f"seating_stress_MPa = {in_unit(seating, 'MPa'):g}: must be at most "
            f"{LARGEST_SEATING:g} of {stress}"
        )
    if end < rock.max_normal_stress:
        yield f"output.largest_stress_MPa = {in_unit(end, 'MPa'):g}: must be at least {stress}"
    relation = relation_of(configuration.surface.jrc_relation)
    for jrc in (rock.jrc, *(rock.other_levels.jrc or ())):
        if not relation.smallest_jrc <= jrc <= relation.largest_jrc and not math.isnan(jrc):
            yield (
                f"{where}: jrc = {jrc:g}: {configuration.surface.jrc_relation} holds from "
                f"{relation.smallest_jrc:g} to {relation.largest_jrc:g}"
            )
    for name, section in configuration.study_sections.items() if rock.walls else ():
        if not section.of_scans:
            yield f"{name}: not with {where}.walls; it draws walls of given JRC"


def _unusual(keys: dict, where: str) -> Iterator[str]:
    """Generate messages on values that are unusual for rock and its joints."""
    for key, value in keys.items():
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
