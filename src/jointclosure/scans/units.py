"""Units of length that files and users write, and what follows from both."""

import re

from jointclosure.inputs import InputError
from jointclosure.parameters import USUAL
from jointclosure.remarks import caution

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
"""Those that a user may state."""
_SPELT = {
    **{name: name for name in UNITS},
    **dict.fromkeys(("µm", "μm", "micron", "microns", "micrometer", "micrometers"), "um"),
    **dict.fromkeys(("micrometre", "micrometres"), "um"),
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("millimetre", "millimetres", "millimeter", "millimeters"), "mm"),
    **dict.fromkeys(("nanometre", "nanometres", "nanometer", "nanometers"), "nm"),
}


def size_of(units: str) -> float:
    """Metres of a unit; `InputError` names those that are known."""
    name = _SPELT.get(units.strip())
    if name is None:
        raise InputError(f"units = {units!r}: must be one of {', '.join(UNITS)}")
    return UNITS[name]


def is_unit(word: str) -> bool:
    """Whether a word is a unit of length that is known here."""
    return word.strip() in _SPELT


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


def doubted(stated: str | None, sides: tuple[float, float] | None) -> tuple[str, ...]:
    """A warning where the units that a user states make a wall no laboratory or outcrop has."""
    if stated is None or sides is None or _is_plausible(size_of(stated), sides):
        return ()
    return (caution(f"unusual in {stated}{plausible(sides)}"),)


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
    if found and found[2] in _SPELT:
        return found[1], found[2]
    return name.strip(), None
