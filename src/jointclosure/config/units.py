"""Units of a configuration, the suffix of a key's name, as SI."""

import math
from decimal import Decimal

SI_FACTORS = {"GPa": 1e9, "MPa": 1e6, "mm": 1e-3, "um": 1e-6, "m": 1.0, "Pa": 1.0}


def to_si(settings: dict) -> dict:
    """Settings with unit suffixes in their keys, as SI under the bare names.

    ``{"youngs_modulus_GPa": 78}`` becomes ``{"youngs_modulus": 78e9}``; a key
    without a known unit is kept, lists and nested settings are converted too.
    """
    converted = {}
    for key, value in settings.items():
        name, _, unit = key.rpartition("_")
        factor = SI_FACTORS.get(unit) if name else None
        if isinstance(value, dict):
            converted[key] = to_si(value)
        elif factor is None:
            converted[key] = value
        elif value is None:
            converted[name] = None
        elif isinstance(value, list | tuple):
            converted[name] = [_scaled(item, unit) for item in value]
        else:
            converted[name] = _scaled(value, unit)
    return converted


def _scaled(value: float, unit: str) -> float:
    """Value times its unit, rounded as the decimal number that was written."""
    written = Decimal(f"{float(value):.15g}")
    return float(written.scaleb(round(math.log10(SI_FACTORS[unit]))))
