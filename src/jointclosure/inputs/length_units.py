"""Units of length that a user may state."""

from jointclosure.inputs.checks import InputError

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "inch": 25.4e-3}
"""Units of length that a user may state, in metres."""
SPELT = {
    **{name: name for name in UNITS},
    "inches": "inch",
    **dict.fromkeys(("µm", "μm", "micron", "microns"), "um"),
    **{
        f"{prefix}met{ending}": unit
        for prefix, unit in (("", "m"), ("milli", "mm"), ("micro", "um"), ("nano", "nm"))
        for ending in ("re", "res", "er", "ers")
    },
}
"""Spellings of units of length in files, and the unit that each means."""


def size_of(units: str) -> float:
    """Return the size of a unit of length [m], by any of its spellings in `SPELT`.

    Raise `InputError`, which lists the known units, for others.
    """
    name = SPELT.get(units.strip())
    if name is None:
        known = ", ".join(UNITS)
        raise InputError(f"units = {units!r}: must be one of {known}; convert others, such as cm")
    return UNITS[name]
