"""Rocks by name: those of the default study, and those that are in no study."""

from pathlib import Path

from jointclosure.config.files import DEFAULT, read_plain
from jointclosure.config.units import to_si
from jointclosure.inputs import InputError
from jointclosure.parameters import Rock, rock_of

OTHERS = Path(__file__).with_name("rocks.yaml")
"""Rocks that are in no study, with the sources of their properties."""


def other_rocks() -> dict[str, dict]:
    """Keys of the rocks that are in no study, by name, as in a configuration."""
    return read_plain(OTHERS)


def named_rock(name: str) -> Rock:
    """The properties of a rock that comes with the package.

    Parameters
    ----------
    name : str
        One of ``config/default.yaml`` (the paper's), or of ``rocks.yaml`` beside it in the
        package, where the source of each number stands.

    Raises
    ------
    InputError
        There is no rock of that name.
    """
    rocks = read_plain(DEFAULT)["rocks"] | other_rocks()
    if name not in rocks:
        raise InputError(f"rock = {name!r}: must be a Rock or one of {', '.join(rocks)}")
    return rock_of(to_si(rocks[name]))
