"""Rocks by name: those of the default study, and those that are in no study."""

from pathlib import Path

from jointclosure.config.files import DEFAULT, read_plain
from jointclosure.config.properties import PROPERTIES, key_of
from jointclosure.config.units import to_si
from jointclosure.inputs import InputError
from jointclosure.parameters import Rock, both_walls, rock_of

OTHERS = Path(__file__).with_name("rocks.yaml")
"""Rocks that are in no study, with the sources of their properties."""


def other_rocks() -> dict[str, dict]:
    """Return the keys of the rocks that are in no study, by name, as in a configuration."""
    return read_plain(OTHERS)


def named_rock(name: str) -> Rock:
    """Return the properties of a rock of the package.

    Parameters
    ----------
    name : str
        A rock of ``config/default.yaml`` (the paper's), or of ``rocks.yaml`` beside it in the
        package, which states the source of each number.

    Raises
    ------
    InputError
        If there is no rock of that name.
    """
    rocks = read_plain(DEFAULT)["rocks"] | other_rocks()
    if name not in rocks:
        raise InputError(f"rock = {name!r}: must be a Rock or one of {', '.join(rocks)}")
    return rock_of(to_si(rocks[name]))


def given_rock(rock: str | Rock | tuple[Rock, Rock]) -> Rock | tuple[Rock, Rock]:
    """Return the properties of a rock that is given by its name or by its properties."""
    return named_rock(rock) if isinstance(rock, str) else rock


def rock_text(rock: Rock | tuple[Rock, Rock], name: str) -> str:
    """Format a rock's name and properties in a line; for both walls if they differ."""
    texts = [
        ", ".join(
            f"{PROPERTIES[field].long_name} {number:g}{unit}"
            for field, (number, unit) in _in_units(wall).items()
        )
        for wall in both_walls(rock)
    ]
    upper, lower = texts
    return f"{name} ({upper if upper == lower else f'upper wall: {upper}; lower wall: {lower}'})"


def rock_record(rock: Rock | tuple[Rock, Rock], name: str) -> dict:
    """Return a rock's name, and the properties of both walls by their keys, for JSON."""
    walls = {
        wall: {key_of(field): number for field, (number, _) in _in_units(intact).items()}
        for wall, intact in zip(("upper", "lower"), both_walls(rock), strict=True)
    }
    return {"name": name} | walls


def _in_units(rock: Rock) -> dict[str, tuple[float, str]]:
    """Return each property in the unit of its key, and that unit after a space, by field."""
    units = {field: PROPERTIES[field].unit for field in Rock._fields}
    return {
        # twelve digits: 73e9/1e9 and similar values are shown as they were given
        field: (
            float(f"{getattr(rock, field) / PROPERTIES[field].size:.12g}"),
            "" if unit == "1" else f" {unit}",
        )
        for field, unit in units.items()
    }
