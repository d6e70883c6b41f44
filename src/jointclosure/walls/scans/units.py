"""Units of length stated by files and by users, and their combination."""

import re

from jointclosure.inputs import SPELT, UNITS, InputError, size_of
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import USUAL


def is_unit(word: str) -> bool:
    """Return whether a word is a known unit of length."""
    return word.strip() in SPELT


def plausible(sides: tuple[float, float] | None) -> str:
    """Describe which units give a wall with sides in the file's units a plausible size."""
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
    """Return a warning if units of the sides give an implausible size of the wall."""
    if sides is None or _is_plausible(size_of(units), sides):
        return ()
    return (caution(f"unusual in {units}{plausible(sides)}"),)


def _is_plausible(size: float, sides: tuple[float, float]) -> bool:
    smallest, largest, _ = USUAL["side_of_scan"]
    return size * min(sides) >= smallest and size * max(sides) <= largest


def settled(what: str, of_file: str | None, stated: str | None, sides=None) -> str:
    """Return the units of heights or distances, from the file's units and those of the user.

    ``sides`` of the wall in the file's units are used to name plausible units in the message if
    none are known; units are never assumed.

    Raises
    ------
    InputError
        If neither states units, or if they contradict each other.
    """
    if stated is not None:
        size_of(stated)
    if of_file is None:
        if stated is None:
            raise InputError(
                f"does not state the units of its {what}: give units (--units on the command "
                f"line){plausible(sides)}"
            )
        return stated
    if stated is not None and size_of(of_file) != size_of(stated):
        raise InputError(f"units = {stated!r}: the {what} of the file are in {of_file!r}")
    return of_file


def split_name(name: str) -> tuple[str, str | None]:
    """Return ("Z", "mm") for names such as "Z_mm", "Z [mm]", "Z/mm", "Z, mm" and "Z in mm".

    For a name without units it is ("Z", None).
    """
    match = re.fullmatch(_NAME_AND_UNIT, name)
    if match:
        unit = match[2] if match[2] in SPELT else match[2].lower()  # MM for mm
        if unit in SPELT:
            return match[1], unit
    return name.strip(), None


def axis_name(name: str) -> str:
    """Return "x", "y" or "z" for the name of a column of points, else the name in lower case.

    Units, and words such as position, are left out; height and elevation are z.
    """
    bare = split_name(name)[0].lower()
    if bare in ("height", "elevation"):
        return "z"
    match = re.fullmatch(r"([xyz])[ _-]?(?:pos(?:ition)?|coord(?:inate)?|axis|value)", bare)
    return match[1] if match else bare


_NAME_AND_UNIT = r"\s*(.*?)(?:_|\s*/\s*|\s*,\s*|\s+in\s+|[_\s]*[(\[])\s*([A-Za-zµμ]+)\s*[)\]]?\s*"
