"""The configuration of a study: merged, checked and in SI, once and in one place."""

import copy
import functools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from pydantic import ValidationError

from jointclosure.engine.assess import FINEST
from jointclosure.inputs import InputError
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    Effects,
    check_choices,
    check_numerics,
    check_scene,
)
from jointclosure.parameters import USUAL as _OF_ROCK
from jointclosure.parameters.units import in_unit, name_and_unit
from jointclosure.walls.synthesis import check_mismatch, spectrum_of
from studies.frame.config.files import DEFAULT, ConfigurationError, read_plain
from studies.frame.config.model import Configuration, model, sections
from studies.frame.config.schema import explained

OTHER_TARGETS = ("hard_cases",)
"""Folders of results of targets that are no studies."""
USUAL = _OF_ROCK | {"stress": _OF_ROCK["max_normal_stress"]}
"""Least and largest values that are usual, and their unit, by name of a key without its unit."""


class Configured(NamedTuple):
    """A configuration as keys of a file, and in SI."""

    keys: dict
    typed: Configuration


def overlaid(keys: dict, changes: dict) -> dict:
    """Nested keys with others over them; what does not change is not copied."""
    return keys | {
        name: overlaid(keys[name], value)
        if isinstance(value, dict) and isinstance(keys.get(name), dict)
        else value
        for name, value in changes.items()
    }


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones, as a copy."""
    return copy.deepcopy(functools.reduce(overlaid, settings, {}))


def merged_study(*paths: Path) -> dict:
    """The default configuration and files over it, not yet checked."""
    return merged(*(written_out(read_plain(path)) for path in (DEFAULT, *paths)))


def written_out(keys: dict) -> dict:
    """Keys whose ``effects: auto`` is written out: those of the full model, chosen to 2 %."""
    if keys.get("effects") != "auto":
        return keys
    return keys | {"effects": Effects()._asdict() | {"auto": AUTO_TOLERANCE}}


def configured(keys: dict) -> Configured:
    """A configuration from merged keys, checked, and in SI.

    `ConfigurationError` names every key that is wrong, its value, and what is allowed.
    """
    keys = written_out(keys)
    configuration = resolved(keys)
    refuse(contradictions(configuration, keys))
    return Configured(keys, configuration)


def resolved(keys: dict) -> Configuration:
    """The configuration of keys without contradictions, as those in the file of a study."""
    try:
        return model().model_validate(keys)
    except ValidationError as error:
        raise refusal(explained(model(), keys, error)) from None


def refuse(problems: Iterable[str]) -> None:
    """Raise `ConfigurationError` where there are problems, one line each."""
    if lines := list(dict.fromkeys(problems)):
        raise refusal(lines)


def refusal(problems: Iterable[str]) -> ConfigurationError:
    """Return the error that lists problems, one line each."""
    return ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in problems))


def problem_lines(error: InputError) -> list[str]:
    """The lines of an error of `refuse`, or of another one."""
    lines = str(error).removeprefix("configuration:").split("\n")
    return [line.strip() for line in lines if line.strip()]


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
    for section in configuration.study_sections.values():
        yield from section.problems(configuration)
    for name, rock in configuration.rocks.items():
        yield from rock.problems(name, configuration)


def _study_problems(configuration: Configuration) -> Iterator[str]:
    study, surfaces = configuration.study, configuration.statistics.control_variates
    if len(set(study.rocks)) < len(study.rocks):
        yield f"study.rocks = {list(study.rocks)!r}: must not have a rock twice"
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
