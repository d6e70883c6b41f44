"""The cases of a study: every rock at its base, and with one parameter changed.

A case's label names files only. It is never taken apart: rock, parameter,
level and value are fields of `Case`, and coordinates of every dataset.
"""

from typing import NamedTuple

from jointclosure.config.units import SI_FACTORS, to_si
from jointclosure.randomness import seed_of

PARAMETERS = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
"""In the order of the paper's Table 3."""

SHOWN_UNITS = {
    "poisson_ratio": ("1", 1.0),
    "youngs_modulus": ("GPa", 1e9),
    "compressive_strength": ("MPa", 1e6),
    "jrc": ("1", 1.0),
}
"""Unit of each parameter in tables, and its size in SI."""


_NOT_PHYSICAL = (
    "title",
    "levels",
    "effects",
    "measured",
    "walls",
    "max_normal_stress_is_assumed",
)


class Case(NamedTuple):
    """One rock with at most one parameter changed; values in SI.

    ``surface`` is the label of the case whose surfaces this one closes: its
    own, or with common draws and an unchanged JRC its rock's base case. ``jrc`` is
    NaN where walls are measured ones.
    """

    label: str
    rock: str
    parameter: str
    level: str
    value: float
    youngs_modulus: float
    poisson_ratio: float
    compressive_strength: float
    jrc: float
    max_normal_stress: float
    surface: str


def level_names(levels: list[float], base: float) -> list[str]:
    """Names of ascending levels: low, base, high, or level_1 to level_k and base."""
    if len(levels) == 3 and levels[1] == base:
        return ["low", "base", "high"]
    return ["base" if level == base else f"level_{i + 1}" for i, level in enumerate(levels)]


def levels_of(rock: dict, key: str) -> list[float]:
    """All levels of a parameter in the configuration's unit, the rock's own among them."""
    return sorted([*rock["levels"][key], rock[key]])


def cases_of(configuration: dict) -> list[Case]:
    """All cases, by rock in the study's order, the base case of each first."""
    common = configuration["study"]["draws"] == "common"
    cases = []
    for name in configuration["study"]["rocks"]:
        rock = configuration["rocks"][name]
        properties = to_si({key: rock[key] for key in rock if key not in _NOT_PHYSICAL})
        if rock.get("walls"):
            properties["jrc"] = float("nan")
        base_label = f"{name}-base"
        cases.append(
            Case(base_label, name, "base", "base", float("nan"), **properties, surface=base_label)
        )
        for parameter in PARAMETERS:
            key = configuration_key(parameter, rock["levels"])
            if key is None:
                continue
            levels = levels_of(rock, key)
            for level, shown in zip(level_names(levels, rock[key]), levels, strict=True):
                if level == "base":
                    continue
                value = to_si({key: shown})[parameter]
                label = f"{name}-{parameter}-{level}"
                shared = common and parameter != "jrc"
                cases.append(
                    Case(
                        label,
                        name,
                        parameter,
                        level,
                        value,
                        **(properties | {parameter: value}),
                        surface=base_label if shared else label,
                    )
                )
    return cases


def configuration_key(parameter: str, settings: dict) -> str | None:
    """The key of a parameter in a configuration (with its unit), None if absent or null."""
    for key in (key for key, value in settings.items() if value is not None):
        if key == parameter or any(key == f"{parameter}_{unit}" for unit in SI_FACTORS):
            return key
    return None


def wall_seed(configuration: dict, case: Case, realization: int) -> int:
    """Seed of a surface pair: what it is named by never includes an index of cases."""
    name = wall_name(configuration, case)
    return seed_of(configuration["study"]["root_seed"], *name, realization)


def wall_name(configuration: dict, case: Case) -> list[str]:
    """What the seeds of a case's surface pairs are named by, but for the realisation."""
    study = configuration["study"]
    name = [study["surfaces_of"] or study["name"], case.rock]
    if study["draws"] == "independent":
        name += [case.parameter, case.level]
    return name


def blocks_of(configuration: dict) -> list[range]:
    """The realisations of every case, split over jobs."""
    study = configuration["study"]
    last, step = study["realizations"], study["realizations_per_job"] or study["realizations"]
    return [range(first, min(first + step, last)) for first in range(0, last, step)]
