"""Units of length that files and users write, and what follows from both."""

import re

from jointclosure.inputs import SPELT, UNITS, InputError, size_of
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import USUAL


def is_unit(word: str) -> bool:
    """Whether a word is a unit of length that is known here."""
    return word.strip() in SPELT


def plausible(sides: tuple[float, float] | None) -> str:
    """Which units make a wall of sides in the file's units one of a laboratory or an outcrop."""
    if sides is None:
        return ""
    fitting = [
        f"{name} ({1e3 * size * sides[0]:.4g} x {1e3 * size * sides[1]:.4g} mm)"
        for name, size in UNITS.items()
        if _is_plausible(size, sides)
    ]
    spans = f"; it spans {sides[0]:.4g} x {sides[1]:.4g}"
    return f"{spans}, plausible in {' or '.join(fitting)}" if fitting else spans


def doubted(units: str, sides: tuple[float, float] | None) -> tuple[str, ...]:
    """A warning where units of its sides make a wall that no laboratory or outcrop has."""
    if sides is None or _is_plausible(size_of(units), sides):
        return ()
    return (caution(f"unusual in {units}{plausible(sides)}"),)


def _is_plausible(size: float, sides: tuple[float, float]) -> bool:
    smallest, largest, _ = USUAL["side_of_scan"]
    return size * min(sides) >= smallest and size * max(sides) <= largest


def settled(what: str, own: str | None, stated: str | None, sides=None) -> str:
    """The units of heights or distances, from the file's own and those stated by the user.

    ``sides`` of the wall in the file's units tell which ones would be plausible where none are
    known; they are never assumed.

    Raises
    ------
    InputError
        Neither are there, or they contradict each other.
    """
    if stated is not None:
        size_of(stated)
    if own is None:
        if stated is None:
            raise InputError(
                f"does not say the units of its {what}: give them (units; --units "
                f"on the command line){plausible(sides)}"
            )
        return stated
    if stated is not None and size_of(own) != size_of(stated):
        raise InputError(f"units = {stated!r}: the file says that its {what} are in {own!r}")
    return own


def split_name(name: str) -> tuple[str, str | None]:
    """("Z", "mm") of "Z_mm", "Z (mm)" or "Z [mm]"; ("Z", None) of a name without units."""
    found = re.fullmatch(r"\s*(.*?)(?:_|\s*[(\[])([a-zµμ]+)[)\]]?\s*", name)
    if found and found[2] in SPELT:
        return found[1], found[2]
    return name.strip(), None
