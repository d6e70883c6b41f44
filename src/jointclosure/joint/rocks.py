"""Rocks of the package by name, and rocks in words.

Those of the paper are Table 1 (after Bandis et al. 1983); their maximum stress is an assumption.
"""

from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

from jointclosure.inputs import InputError, did_you_mean
from jointclosure.parameters import PROPERTIES, Rock, acting, check_rock, in_double, key_of


class KnownRock(NamedTuple):
    """Title and properties of a rock of the package, with data of its joints.

    ``jrc`` is the JRC of the paper's joints, None if unknown. ``max_normal_stress`` [Pa] is the
    largest stress of its joints, an assumption.
    """

    title: str
    intact: Rock
    jrc: float | None = None
    max_normal_stress: float = 30e6


ROCKS = {
    "dolerite": KnownRock("Dolerite", Rock(78e9, 0.2, 165e6), 8.0),
    "siltstone": KnownRock("Siltstone", Rock(28.5e9, 0.25, 84e6), 7.0),
    "limestone": KnownRock("Limestone", Rock(49e9, 0.2, 152e6), 8.0),
    "slate": KnownRock("Slate", Rock(66e9, 0.25, 159e6), 6.5),
    # middles of 57 to 89 GPa, 0.18 to 0.32 and 133 to 213 MPa, 50 tests of Moragy granite:
    # doi 10.1007/s10706-020-01218-4; 10 MPa: as far as joints are usually loaded in a laboratory
    "granite": KnownRock("Granite", Rock(73e9, 0.25, 173e6), max_normal_stress=10e6),
}
"""Rocks by the names that all functions with an argument ``rock`` take."""


def named_rock(rock: str | Rock) -> Rock:
    """Return the properties of a rock, which may be a name of `ROCKS` in any case.

    Raise `InputError` for any other name.
    """
    if isinstance(rock, Rock):
        return rock
    known = matching(rock, ROCKS) if isinstance(rock, str) else None
    if known is None:
        meant = did_you_mean(rock, ROCKS)
        raise InputError(f"rock = {rock!r}: must be a Rock or one of {', '.join(ROCKS)}{meant}")
    return ROCKS[known].intact


def matching(name: str, known: Collection[str]) -> str | None:
    """Return the known name that equals ``name``, if need be without regard to case.

    Return None if there is none.
    """
    alike = (other for other in known if other.casefold() == name.casefold())
    return name if name in known else next(alike, None)


def both_walls(rock: str | Rock | Sequence[str | Rock]) -> tuple[Rock, Rock]:
    """Return the rocks (upper, lower) of one rock or a pair, by names or properties.

    Numbers of numpy types become Python's. Raise `InputError` for an unknown name, a property that
    is not allowed, or a sequence of other than two rocks.
    """
    several = isinstance(rock, tuple | list) and not isinstance(rock, Rock)
    given: Any = rock if several else (rock, rock)
    pair = [named_rock(wall) for wall in given]
    if len(pair) != 2:
        raise InputError(f"rock = {rock!r}: must be one rock or a pair (upper, lower)")
    for wall in pair:
        check_rock(wall)
    return in_double(pair[0]), in_double(pair[1])


def rock_text(rock: Rock | tuple[Rock, Rock], name: str) -> str:
    """Format a rock's name and properties in a line; for both walls if they differ."""
    upper, lower = (
        ", ".join(f"{PROPERTIES[p].long_name} {n:g}{unit}" for p, (n, unit) in shown.items())
        for shown in map(_in_units, both_walls(rock))
    )
    return f"{name} ({upper if upper == lower else f'upper wall: {upper}; lower wall: {lower}'})"


def rock_record(rock: Rock | tuple[Rock, Rock], name: str) -> dict:
    """Return a rock's name, and the properties of both walls by their keys, for JSON."""
    walls = {
        wall: {key_of(field): number for field, (number, _) in _in_units(intact).items()}
        for wall, intact in zip(("upper", "lower"), both_walls(rock), strict=True)
    }
    return {"name": name} | walls


def _in_units(rock: Rock) -> dict[str, tuple[float, str]]:
    """Return each property of a rock that acts, by name, in the unit of its key, and this unit.

    The unit follows a space, or is empty for a number without unit.
    """
    shown = {}
    for field in acting(rock):
        value = getattr(rock, field)
        unit = PROPERTIES[field].unit
        size = PROPERTIES[field].size
        # twelve digits: 73e9/1e9 and similar values are shown as they were given
        shown[field] = float(f"{value / size:.12g}"), "" if unit == "1" else f" {unit}"
    return shown
