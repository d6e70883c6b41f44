"""Input of a user: checks of arguments, units of length, keywords, extras, and remarks."""

from jointclosure.inputs.checks import (
    LENGTHS,
    SIZES,
    InputError,
    check_below,
    check_count,
    check_length,
    check_number,
    check_one_of,
    check_positive,
    check_sizes,
    did_you_mean,
    naming,
    real_array,
)
from jointclosure.inputs.length_units import (
    SPELT,
    UNITS,
    size_of,
)

__all__ = [
    "LENGTHS",
    "SIZES",
    "SPELT",
    "UNITS",
    "InputError",
    "check_below",
    "check_count",
    "check_length",
    "check_number",
    "check_one_of",
    "check_positive",
    "check_sizes",
    "did_you_mean",
    "naming",
    "real_array",
    "size_of",
]
