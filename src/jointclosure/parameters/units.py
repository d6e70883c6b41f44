"""Properties with unit, range, title and symbol; units of a configuration in SI and back."""

import math
import operator
from decimal import Decimal
from functools import cache
from typing import Any, NamedTuple, get_type_hints

from jointclosure.inputs import InputError, check_number, check_positive

SI_FACTORS = {"GPa": 1e9, "MPa": 1e6, "mm": 1e-3, "um": 1e-6, "m": 1.0, "Pa": 1.0}
"""Units that a configuration may use, each in SI."""
_LIKELY = ("MPa", "GPa", "mm", "um", "Pa", "m")
"""Units in which values outside their usual range were probably given, the likeliest first."""


def unit_meant(value: float, low: float, high: float, unit: str) -> str:
    """Return the question which unit was meant by a value outside of its usual range.

    ``value`` and the range from ``low`` to ``high`` are in a ``unit`` of `SI_FACTORS`, or have no
    unit. The question, such as "is 78 GPa meant?", names a unit in which the value would be usual,
    if there is one.
    """
    size = SI_FACTORS.get(unit, 1.0)
    for name in _LIKELY if unit in SI_FACTORS else ():
        if name[-1] != unit[-1]:  # a stress is no length
            continue
        factor = SI_FACTORS[name] / size
        if low <= value * factor <= high:
            if size == 1.0:
                return f"is {value:g} {name} meant, {value * factor:g} {unit}?"
            return f"is {value * factor:g} {unit} meant?"
        if low <= value / factor <= high:
            return f"is {value / factor:g} {unit} meant?"
    return "is the unit right?"


class Property(NamedTuple):
    """Unit, title and allowed values of a field, for ``Annotated[float, Property(...)]``.

    ``unit`` is that of tables and configurations ("1" for none), ``symbol`` in ASCII ("sigma_c").
    ``interval`` contains the allowed values [SI], such as "[0, 0.5]". If it is None, any positive
    number is allowed, and infinity if ``may_be_infinite``. A value outside of ``usual`` [SI] is
    probably in a wrong unit.
    """

    long_name: str
    unit: str
    symbol: str
    interval: str | None = None
    may_be_infinite: bool = False
    usual: tuple[float, float] | None = None

    @property
    def size(self) -> float:
        """Factor by which a value in the unit of the property is multiplied to be in SI."""
        return SI_FACTORS.get(self.unit, 1.0)

    @property
    def si_unit(self) -> str:
        """Unit of the property in a dataset, which has SI units: "Pa" for GPa."""
        return {"GPa": "Pa", "MPa": "Pa", "mm": "m", "um": "m"}.get(self.unit, self.unit)

    @property
    def in_brackets(self) -> str:
        """Unit in brackets behind a title, such as " (GPa)"; empty for a number without unit."""
        return "" if self.unit == "1" else f" ({self.unit})"

    @property
    def title(self) -> str:
        """Name of the property as the heading of a column."""
        return self.long_name[0].upper() + self.long_name[1:]

    @property
    def bounds(self) -> dict[str, float]:
        """Bounds of a configuration key in its own unit, as keywords of `pydantic.Field`."""
        ends = bounds_of(self.interval or "(0, inf)")
        return {sign: end / self.size for sign, end in ends.items()}

    def check(self, name: str, value: Any) -> None:
        """Raise `InputError` unless a value [SI] is allowed for the property."""
        if self.interval is None:
            unit = "" if self.unit == "1" else self.si_unit
            check_positive(name, value, unit, may_be_infinite=self.may_be_infinite)
        else:
            check_inside(name, value, self.interval)


def properties_of(fields: type) -> dict[str, Property]:
    """Return the `Property` of each field of a named tuple, from its annotation, by name.

    Raise `ValueError` for a unit that is not in `SI_FACTORS`.
    """
    hints = get_type_hints(fields, include_extras=True)
    properties = {name: hint.__metadata__[0] for name, hint in hints.items()}
    for name, about in properties.items():
        if about.unit not in ("1", *SI_FACTORS):
            raise ValueError(f"{name}: unit {about.unit!r}: must be 1 or in SI_FACTORS")
    return properties


def bounds_of(interval: str) -> dict[str, float]:
    """Return the finite ends of an interval such as "(0, 1]", as keywords of `pydantic.Field`.

    They are {"gt": 0.0, "le": 1.0} for this one.
    """
    signs = "ge" if interval[0] == "[" else "gt", "le" if interval[-1] == "]" else "lt"
    ends = zip(signs, map(float, interval[1:-1].split(",")), strict=True)
    return {sign: end for sign, end in ends if math.isfinite(end)}


def check_inside(name: str, value: Any, interval: str, reason: str = "") -> None:
    """Raise `InputError` unless a value is a number in an interval, such as "(0, 1]".

    ``reason`` is appended to the message.
    """
    check_number(name, value)
    if not all(getattr(operator, sign)(value, end) for sign, end in bounds_of(interval).items()):
        raise InputError(f"{name} = {value!r}: must lie in {interval}{reason}")


@cache
def name_and_unit(key: str) -> tuple[str, str]:
    """Return the name and the unit of a configuration key.

    They are ("displacement_step", "um") for displacement_step_um. The unit of a key that does not
    end in one of `SI_FACTORS` is "".
    """
    name, _, unit = key.rpartition("_")
    return (name, unit) if name and unit in SI_FACTORS else (key, "")


def to_si(settings: dict) -> dict:
    """Convert settings whose keys end in units to SI, under names without units.

    Sequences and nested settings are converted too; values without a unit, and None, stay. Raise
    `InputError` if a value with a unit is no number, or does not fit in double precision.
    """
    converted: dict = {}
    for key, value in settings.items():
        name, unit = name_and_unit(key)
        if isinstance(value, dict):
            converted[key] = to_si(value)
        elif not unit or value is None:
            converted[name] = value
        elif isinstance(value, list | tuple):
            converted[name] = [_si_value(key, item, unit) for item in value]
        else:
            converted[name] = _si_value(key, value, unit)
    return converted


def _si_value(key: str, value: float, unit: str) -> float:
    """Return the value of a configuration key, in a ``unit``, in SI.

    Raise `InputError` unless it is a number that fits in double precision.
    """
    check_number(key, value)
    number = _times_power_of_ten(value, _power_of_unit(unit))
    if math.isfinite(value) and (math.isinf(number) or (value != 0.0 and number == 0.0)):
        raise InputError(f"{key} = {value!r}: must be a number that fits in double precision in SI")
    return number


def in_unit(value: float, unit: str) -> float | int:
    """Convert a value in SI to a unit: 78 for 78e9 in GPa.

    A whole number is returned as int. With a unit that is not in `SI_FACTORS`, such as "1", the
    value is not converted.
    """
    shown = (
        _times_power_of_ten(value, -_power_of_unit(unit)) if unit in SI_FACTORS else float(value)
    )
    return int(shown) if shown.is_integer() else shown


def _power_of_unit(unit: str) -> int:
    """Return the power of ten by which a value in a unit is multiplied to be in SI."""
    return round(math.log10(SI_FACTORS[unit]))


def _times_power_of_ten(value: float, power: int) -> float:
    """Return a value times a power of ten, rounded as the decimal number that a user wrote."""
    return float(Decimal(f"{float(value):.15g}").scaleb(power))
