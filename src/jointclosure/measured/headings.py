"""Headings of the columns of a measured curve, and the units that they state."""

import re
from typing import NamedTuple

from jointclosure.inputs import SPELT

STRESS_UNITS = {
    "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/m2": 1.0, "kN/m2": 1e3, "MN/m2": 1e6,
    "N/cm2": 1e4, "kN/cm2": 1e7, "N/mm2": 1e6, "bar": 1e5, "kbar": 1e8, "atm": 101_325.0,
    "psi": 4.4482216152605 / 0.0254**2, "ksi": 4448.2216152605 / 0.0254**2, "kgf/cm2": 98_066.5,
}  # fmt: skip
"""Known units of stress [Pa]."""
FORCE_UNITS = {
    "N": 1.0, "kN": 1e3, "MN": 1e6, "kgf": 9.80665, "tf": 9806.65,
    "lbf": 4.4482216152605, "kip": 4448.2216152605,
}  # fmt: skip
"""Known units of force [N], which an area makes a stress."""
CLOSURE_UNITS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 25.4e-3, "mil": 25.4e-6,
}  # fmt: skip
"""Known units of length [m]."""
KNOWN = STRESS_UNITS | FORCE_UNITS | CLOSURE_UNITS
"""All known units, in SI."""
_SPELT = SPELT | {
    "inch": "in", "inches": "in", '"': "in", "mils": "mil", "thou": "mil", "micrometre": "um",
    "pascal": "Pa", "kilopascal": "kPa", "megapascal": "MPa", "gigapascal": "GPa",
    "newton": "N", "kilonewton": "kN", "meganewton": "MN", "bars": "bar", "kips": "kip",
    "lb/in2": "psi", "lbf/in2": "psi", "lbs/in2": "psi", "lb/sqin": "psi", "kp/cm2": "kgf/cm2",
    "kg/cm2": "kgf/cm2", "kp": "kgf",
}  # fmt: skip
"""Other spellings of known units."""
_NOT_LENIENT = ("mPa", "mN", "Mm", "Nm", "NM", "mn", "Nn")
"""Spellings that differ from a known unit in the case of letters, and mean another unit."""
_REFUSED = {
    *("%", "strain", "ustrain", "microstrain", "V", "mV", "kg", "g", "t", "lb", "lbs", "psf"),
    *("psig", "psia", "tsf", "ksf", "mPa", "mN", "Mm", "Nm", "hPa", "mbar", "torr", "ft", "yd"),
    *("N/m", "kN/m", "N/mm", "kN/mm", "deg", "percent", "pct", "volt", "volts", "counts", "uin"),
}
"""Units that columns of laboratories have, and that are none of stress, force or closure."""
_ANYWHERE = {name for name in KNOWN if len(name) > 1 and name not in ("in", "mil", "bar", "atm")}
"""Units that a heading may also have before its end, as in "kN load"."""
_BRACKETS = re.compile(r"[(\[{<]([^()\[\]{}<>]*)[)\]}>]")
"""Text in brackets of any form, in which headings have units."""
_MULTIPLIER = re.compile(r"[x×*·]\s*10|10\s*(?:\^|\*\*|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹+-])|(?<![\d.])1[eE][+-]?\d")
"""A power of ten, by which values of a column would have to be multiplied."""


class Heading(NamedTuple):
    """What the heading of a column states: its name and unit; empty texts for nothing."""

    name: str  # of the quantity, in small letters
    unit: str  # in its usual spelling, as in `KNOWN`
    unknown: str  # text in the place of a unit that is not a known unit


def unit_of(text: str) -> str:
    """Return the known unit that a text spells, as in `KNOWN`; an empty text if there is none.

    Brackets, blanks, plurals and other spellings are accepted, and other cases of letters unless
    they mean another unit.
    """
    bare = re.sub(r"[\s()\[\]{}]", "", text).replace("µ", "u").replace("μ", "u")
    bare = bare.replace("²", "2").replace("**", "^").replace("^", "")
    per = re.fullmatch(r"([A-Za-z]+)[·*.]?(mm|cm|m)(?:[-−]2|⁻2)", bare)
    bare = f"{per[1]}/{per[2]}2" if per else bare
    for spelling in (bare, bare.removesuffix("s") if len(bare) > 3 else bare):
        if spelling in KNOWN:
            return spelling
        if spelling in _SPELT:
            return _SPELT[spelling]
        if len(spelling) > 1 and spelling not in _NOT_LENIENT:
            lenient = {name.casefold(): name for name in KNOWN if len(name) > 1} | _SPELT
            if spelling.casefold() in lenient:
                return lenient[spelling.casefold()]
    return ""


def heading_of(cell: str) -> Heading:
    """Return what the heading of a column states.

    Its unit stands at its end or in brackets. A heading with several units, or with a power of ten,
    has no unit, and these are what is ``unknown`` of it.
    """
    in_brackets = [part.strip() for part in _BRACKETS.findall(cell)]
    parts = [re.sub(r"^in\s+", "", part) for whole in in_brackets for part in whole.split(",")]
    known = [unit for part in parts if (unit := unit_of(part))]
    name, unit, unknown = _name_and_end(_BRACKETS.sub(" ", cell).strip())
    known += [unit] * bool(unit)
    if _MULTIPLIER.search(cell):
        return Heading(name, "", cell.strip())
    if len(set(known)) > 1:
        return Heading(name, "", ", ".join(dict.fromkeys(known)))
    if known:
        return Heading(name, known[0], "")
    nothing = ("", "-", "--", "1")
    others = [part for part in in_brackets if part not in nothing]
    return Heading(name, "", others[0] if others else unknown)


def _name_and_end(text: str) -> tuple[str, str, str]:
    """Split the text of a heading, without brackets, into its name and what stands at its end.

    Return the name in small letters, the known unit at the end, and the text at the end that is a
    unit, but none of stress, force or closure. Two of the three may be empty.
    """
    words = re.findall(r"[^\s_,;:]+", text)
    if len(words) == 1:
        before, slash, behind = words[0].partition("/")
        if unit := unit_of(words[0]) or unit_of(behind):
            return (before if slash else words[0]).lower(), unit, ""
        return words[0].lower(), "", ""
    for start in range(1, len(words)):
        tail = "".join(words[start:]).removeprefix("/")
        # a subscript of a stress, such as sigma_N, is no newton
        normal = tail == "N" and re.match(r"(?i)sigma|stress|σ|s\b|s_", text)
        unit = "" if normal else unit_of(tail)
        if unit or tail in _REFUSED or tail.lower() in _REFUSED:
            kept = [word for word in words[:start] if word not in ("/", "in")]
            return "_".join(kept).lower(), unit, "" if unit else tail
        before, slash, behind = tail.partition("/")
        if slash and start == len(words) - 1 and (unit := unit_of(behind)):
            return "_".join([*words[:start], before]).lower(), unit, ""
    within = [word for word in words if word in _ANYWHERE]
    return "_".join(words).lower(), within[0] if len(within) == 1 else "", ", ".join(within[1:])
