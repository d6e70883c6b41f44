"""Numbers as text: rounded to their errors, with significant digits, in percent, and grids."""

import math
from collections.abc import Sequence

import numpy as np

ABSENT = "–"  # in a table, in place of a number
_MOST_POWERS = 4
"""Largest number of powers of ten that numbers with equal decimals may span."""


def rounded(value: float, standard_error: float) -> str:
    """Format a number rounded to its standard error, such as "0.083 ± 0.004".

    Without a positive and finite error it has four significant digits and no error. NaN is
    `ABSENT`.
    """
    if np.isnan(value):
        return ABSENT
    if not np.isfinite(value) or not 0.0 < standard_error < np.inf:
        return f"{value:.4g}"
    digits = _places_of_error(standard_error)
    places = max(digits, 0)
    value = round(value, digits)
    standard_error = round(standard_error, digits)
    return f"{value + 0.0:.{places}f} ± {standard_error:.{places}f}"


def _places_of_error(error: float) -> int:
    """Return to how many decimals a number with a standard ``error`` is rounded.

    The error keeps two digits if they are below 36, else one (rule of the Particle Data Group). The
    result is negative for errors of 36 and more.
    """
    exponent = int(f"{error:.2e}".partition("e")[2])
    leading = round(error / 10.0**exponent, 2)
    return 1 - exponent if leading < 3.55 else -exponent


def significant(value: float, figures: int) -> str:
    """Format a finite number with ``figures`` significant digits, without an exponent."""
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{figures - 1}e}")
    exponent = int(f"{abs(rounded):e}".split("e")[1])
    return f"{rounded:.{max(figures - 1 - exponent, 0)}f}"


def number_text(value: float, figures: int = 4) -> str:
    """Format a number for reading, with ``figures`` significant digits.

    It has an exponent unless it is 0 or from 1e-3 to 1e6. NaN is `ABSENT`.
    """
    if math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0.0 else "−∞"
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        return significant(value, figures)
    return f"{value:.{figures - 1}e}"


def with_equal_decimals(values: Sequence[float], figures: int = 2) -> list[str]:
    """Format a number and the ends of its range with the same number of decimals.

    The first number has ``figures`` significant digits, unless the range contains 0. There are more
    decimals if the width of the range needs them, as an error does (`rounded`), or if an end of at
    least a hundredth of the first number would read as 0. If the largest in magnitude is not from
    1e-3 to 1e6, or if positive numbers span more than `_MOST_POWERS` powers of ten, each is written
    for itself (`number_text`).

    >>> with_equal_decimals([0.0974, 0.0908, 0.0996])
    ['0.097', '0.091', '0.100']
    """
    known = [abs(value) for value in values if math.isfinite(value) and value != 0.0]
    largest = max(known, default=0.0)
    if known and not 1e-3 <= largest < 1e6:
        return [number_text(value, figures) if value else "0" for value in values]
    if min(values, default=0.0) > 0.0 and largest > 10.0**_MOST_POWERS * min(known):
        return [number_text(value, figures) for value in values]
    finite = [value for value in values if math.isfinite(value)]
    low, high = min(finite, default=0.0), max(finite, default=0.0)
    if not high > low and not known:
        return ["0" if math.isfinite(value) else number_text(value) for value in values]
    places = []
    if low * high > 0.0:
        first = next(abs(value) for value in finite)
        places = [figures - 1 - _power(first, figures)]
        places += [-_power(least, 1) for least in [min(known)] if least >= 1e-2 * first]
    if high > low:  # of an interval about 0 a quarter is about a standard error
        places.append(_places_of_error((high - low) / (1.0 if places else 4.0)))
    return [_with_places(value, max(places)) for value in values]


def _power(value: float, figures: int) -> int:
    """Return the power of ten of the first digit of a number rounded to ``figures`` digits."""
    return int(f"{abs(value):.{figures - 1}e}".partition("e")[2])


def _with_places(value: float, places: int) -> str:
    """Format a number with ``places`` decimals; if negative, it is rounded to a power of ten."""
    if not math.isfinite(value):
        return number_text(value)
    return f"{round(value, places) + 0.0:.{max(places, 0)}f}"


LEAST_SHARE = 1e-6
"""Share below which `percent` says only that it is less."""


def percent(share: float) -> str:
    """Format a share in percent, without an exponent: two digits below 10 %, whole percent above.

    >>> percent(0.034), percent(2.0), percent(3e-12)
    ('3.4 %', '200 %', 'less than 0.0001 %')
    """
    if 0.0 < abs(share) < LEAST_SHARE:
        return f"less than {percent_number(100.0 * LEAST_SHARE)} %"
    return f"{percent_number(100.0 * share)} %"


def percent_number(value: float) -> str:
    """Format a number that is in percent already like `percent`, but without the sign "%"."""
    if not math.isfinite(value):
        return number_text(value)
    if abs(value) >= 9.95:
        return f"{value:.0f}"
    return np.format_float_positional(float(f"{value:.2g}"), trim="-")


def grid_text(shape: tuple[int, ...], spacing: float) -> str:
    """Describe a grid of (ny, nx) cells with a spacing [m], such as "96 x 80 cells of 0.25 mm".

    The number of cells along x comes first.
    """
    ny, nx = shape
    return f"{nx} x {ny} cells of {1e3 * spacing:.4g} mm"
