"""Physical properties: units, ranges, titles and symbols, stated once beside their fields."""

import unicodedata
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from jointclosure.inputs import InputError, check_number, check_positive

SI_FACTORS = {"GPa": 1e9, "MPa": 1e6, "mm": 1e-3, "um": 1e-6, "m": 1.0, "Pa": 1.0}
"""Units that a configuration writes, in SI."""


class Property(NamedTuple):
    """A property that a configuration gives and a study can vary.

    ``Annotated[float, Property(...)]`` states it with its field. ``long_name`` is its name within a
    sentence; ``unit`` the one in which it is shown and configured ("1" for none); ``symbol`` its
    ASCII spelling ("sigma_c"); ``interval`` the closed range [SI] in which it must lie, None for
    any positive number, infinity too if ``may_be_infinite``; ``usual`` the range [SI] beyond which
    a value is more often a slip of units; ``heading`` the title of its row in tables, where this
    is not title and symbol.
    """

    long_name: str
    unit: str
    symbol: str
    interval: tuple[float, float] | None = None
    may_be_infinite: bool = False
    usual: tuple[float, float] | None = None
    heading: str = ""

    @property
    def size(self) -> float:
        """The unit in SI."""
        return SI_FACTORS.get(self.unit, 1.0)

    @property
    def si_unit(self) -> str:
        """The unit that it has in a dataset."""
        return {"GPa": "Pa", "MPa": "Pa", "mm": "m", "um": "m"}.get(self.unit, self.unit)

    @property
    def in_brackets(self) -> str:
        """The unit behind a title: " (GPa)", or nothing."""
        return "" if self.unit == "1" else f" ({self.unit})"

    @property
    def title(self) -> str:
        """Its name at the head of a column."""
        return self.long_name[0].upper() + self.long_name[1:]

    @property
    def shown_symbol(self) -> str:
        """The symbol in Unicode, such as σc."""
        letter, _, index = self.symbol.partition("_")
        return (_greek(letter) or letter) + index

    @property
    def label(self) -> str:
        """The head of its row in a table, with symbol and unit."""
        return self.heading or f"{self.title} {self.shown_symbol}{self.in_brackets}"

    @property
    def latex(self) -> str:
        """`label` with the symbol as LaTeX."""
        letter = self.symbol.partition("_")[0]
        symbol = f"${chr(92) if _greek(letter) else ''}{self.symbol}$"
        return self.heading or f"{self.title} {symbol}{self.in_brackets}"

    @property
    def bounds(self) -> dict[str, float]:
        """Bounds of a key in its unit, as `pydantic.Field` takes them."""
        if self.interval is None:
            return {"gt": 0}
        named = zip(("ge", "le"), self.interval, strict=True)
        return {name: end / self.size for name, end in named if np.isfinite(end)}

    def check(self, name: str, value: Any) -> None:
        """Raise `InputError` unless a value [SI] is one that the property may have."""
        if self.interval is None:
            unit = "" if self.unit == "1" else self.si_unit
            check_positive(name, value, unit, may_be_infinite=self.may_be_infinite)
            return
        check_number(name, value)
        low, high = self.interval
        if not low <= value <= high:
            raise InputError(f"{name} = {value!r}: must lie in [{low:g}, {high:g}]")


def properties_of(fields: type) -> dict[str, Property]:
    """Properties of the fields of a named tuple, by name.

    Raises
    ------
    TypeError
        A field without one.
    """
    found = {}
    for name, hint in get_type_hints(fields, include_extras=True).items():
        known = [each for each in getattr(hint, "__metadata__", ()) if isinstance(each, Property)]
        if len(known) != 1:
            raise TypeError(f"{fields.__name__}.{name}: must be annotated by one Property")
        found[name] = known[0]
    return found


def _greek(letter: str) -> str:
    """The Greek letter of a name, "" where it is none."""
    try:
        return unicodedata.lookup(f"GREEK SMALL LETTER {letter.upper()}")
    except KeyError:
        return ""
