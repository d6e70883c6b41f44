"""Units of a configuration, the suffixes of its keys, in SI and back."""

import math
from decimal import Decimal
from functools import lru_cache

from jointclosure.inputs import InputError, check_number
from jointclosure.parameters.properties import SI_FACTORS


@lru_cache(maxsize=None)
def name_and_unit(key: str) -> tuple[str, str]:
    """Return name and unit of a key: ("displacement_step", "um") of displacement_step_um; or ""."""
    name, _, unit = key.rpartition("_")
    return (name, unit) if name and unit in SI_FACTORS else (key, "")


def to_si(settings: dict) -> dict:
    """Convert settings with unit suffixes in their keys to SI under names without suffixes.

    ``{"youngs_modulus_GPa": 78}`` becomes ``{"youngs_modulus": 78e9}``. A key without a known unit
    is kept; lists and nested settings are converted too.

    Raises
    ------
    InputError
        If the value of a key with a unit is not a number (nested settings are not checked before).
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
            converted[name] = [_in_si(key, item, unit) for item in value]
        else:
            converted[name] = _in_si(key, value, unit)
    return converted


def _in_si(key: str, value: float, unit: str) -> float:
    """Return a value of a key in SI; raise `InputError` unless it fits in double precision."""
    check_number(key, value)
    number = _scaled(value, _power(unit))
    if math.isfinite(value) and (math.isinf(number) or (value != 0.0 and number == 0.0)):
        raise InputError(f"{key} = {value!r}: must be a number that fits in double precision in SI")
    return number


def in_unit(value: float, unit: str) -> float | int:
    """Return a value in SI in a unit ("1" for none), in short form: 78 for 78e9 in GPa."""
    shown = _scaled(value, -_power(unit)) if unit in SI_FACTORS else float(value)
    return int(shown) if shown.is_integer() else shown


def _power(unit: str) -> int:
    return round(math.log10(SI_FACTORS[unit]))


def _scaled(value: float, power: int) -> float:
    """Return a value times a power of ten, rounded like the decimal number in the file."""
    return float(Decimal(f"{float(value):.15g}").scaleb(power))
