"""Contradictions between keys, and values unusual for rock, which no single key can reveal."""

from collections.abc import Callable, Iterator

from jointclosure.inputs import InputError
from jointclosure.parameters import USUAL as _OF_ROCK
from jointclosure.parameters import check_choices, check_numerics, check_scene
from jointclosure.parameters.units import in_unit, name_and_unit
from jointclosure.walls.synthesis import check_mismatch, spectrum_of
from studies.frame.config.model import Configuration, sections

OTHER_TARGETS = ("hard_cases",)
"""Folders of results of targets that are no studies."""
USUAL = _OF_ROCK | {"stress": _OF_ROCK["max_normal_stress"]}
"""Least and largest values that are usual, and their unit, by name of a key without its unit."""


def contradictions(configuration: Configuration, keys: dict) -> Iterator[str]:
    """Generate contradictions between keys that are each valid, one line each."""
    yield from _study_problems(configuration)
    if configuration.study.unusual_values == "refuse":
        rocks = {name: keys["rocks"][name] for name in configuration.rocks}
        separate = {n for n, section in configuration.study_sections.items() if section.separate}
        checked = {name: value for name, value in keys.items() if name not in separate}
        yield from _unusual(checked | {"rocks": rocks}, "")
    surface, spacing = configuration.surface, configuration.grid.spacing
    effects = (rock.effects for rock in configuration.rocks.values())
    checks: tuple[Callable[[], object], ...] = (
        *(
            lambda effects=scene: check_scene(effects)
            for scene in dict.fromkeys([configuration.effects.acting, *effects])
        ),
        lambda: spectrum_of(surface.hurst, surface.rule, surface.roll_off, spacing),
        lambda: check_mismatch(surface.mismatch_wavelength, surface.correlation),
        lambda: check_choices(configuration.choices, spacing),
        lambda: check_numerics(configuration.numerics),
    )
    for check in checks:
        try:
            check()
        except InputError as error:
            yield str(error)
    share = keys["numerics"].get("idle_interaction")
    if share and not any(rock.effects.interaction for rock in configuration.rocks.values()):
        yield (
            f"numerics.idle_interaction = {share:g}: must be null or 0, because "
            "effects.interaction is false for every rock"
        )
    for section in configuration.study_sections.values():
        yield from section.problems(configuration)
    for name, rock in configuration.rocks.items():
        yield from rock.problems(name, configuration)


def _study_problems(configuration: Configuration) -> Iterator[str]:
    study, surfaces = configuration.study, configuration.statistics.control_variates
    if len(set(study.rocks)) < len(study.rocks):
        yield f"study.rocks = {list(study.rocks)!r}: must not have a rock twice"
    closed = max(study.realizations, study.pool or 0)
    if surfaces is not None and surfaces <= closed:
        yield (
            f"statistics.control_variates = {surfaces}: must be more than the {closed} surfaces of "
            "a case, whose means they adjust (or null: no adjustment)"
        )
    of_target = sections().get(study.name)
    belongs = of_target is not None and of_target.name in configuration.study_sections
    if study.name in (*OTHER_TARGETS, *sections()) and not belongs:
        yield (
            f"study.name = {study.name!r}: results/{study.name} belongs to another target; "
            "must be another name"
        )


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
                        "; is the unit right? study.unusual_values: allow takes it as it is"
                    )
