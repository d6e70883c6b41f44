"""Units of a configuration, the suffix of a key's name, as SI and back."""

import math
from decimal import Decimal

from jointclosure.properties import SI_FACTORS


def name_and_unit(key: str) -> tuple[str, str]:
    """Name and unit of a key: ("displacement_step", "um") of displacement_step_um; "" for none."""
    name, _, unit = key.rpartition("_")
    return (name, unit) if name and unit in SI_FACTORS else (key, "")


def to_si(settings: dict) -> dict:
    """Settings with unit suffixes in their keys, as SI under the bare names.

    ``{"youngs_modulus_GPa": 78}`` becomes ``{"youngs_modulus": 78e9}``; a key
    without a known unit is kept, lists and nested settings are converted too.
    """
    converted: dict = {}
    for key, value in settings.items():
        name, unit = name_and_unit(key)
        if isinstance(value, dict):
            converted[key] = to_si(value)
        elif not unit:
            converted[key] = value
        elif value is None:
            converted[name] = None
        elif isinstance(value, list | tuple):
            converted[name] = [_scaled(item, _power(unit)) for item in value]
        else:
            converted[name] = _scaled(value, _power(unit))
    return converted


def in_unit(value: float, unit: str) -> float | int:
    """A value in SI in a unit ("1" for none), as short as it was written: 78 for 78e9 in GPa."""
    shown = _scaled(value, -_power(unit)) if unit in SI_FACTORS else float(value)
    return int(shown) if shown.is_integer() else shown


def _power(unit: str) -> int:
    return round(math.log10(SI_FACTORS[unit]))


def _scaled(value: float, power: int) -> float:
    """Value times a power of ten, rounded as the decimal number that was written."""
    return float(Decimal(f"{float(value):.15g}").scaleb(power))
