"""Numbers as text: rounded to their errors, with significant digits, and in percent."""

import math

import numpy as np

ABSENT = "–"  # in a table, in place of a number


def rounded(value: float, standard_error: float) -> str:
    """Format a number rounded to its error, such as "0.083 ± 0.004"."""
    if np.isnan(value):
        return ABSENT
    if not np.isfinite(value) or not 0.0 < standard_error < np.inf:
        return f"{value:.4g}"
    exponent = int(f"{standard_error:.2e}".partition("e")[2])
    leading = round(standard_error / 10.0**exponent, 2)
    digits = 1 - exponent if leading < 3.55 else -exponent
    if leading >= 9.5:  # rounds to 10 of the next power: two digits
        digits = -exponent
    places = max(digits, 0)
    value = round(value, digits)
    standard_error = round(standard_error, digits)
    return f"{value + 0.0:.{places}f} ± {standard_error:.{places}f}"


def significant(value: float, figures: int) -> str:
    """Format a number with the given number of significant digits, without an exponent."""
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{figures - 1}e}")
    exponent = int(f"{abs(rounded):e}".split("e")[1])
    return f"{rounded:.{max(figures - 1 - exponent, 0)}f}"


def number_text(value: float, figures: int = 4) -> str:
    """Format a number with significant digits for reading; `ABSENT` if it is missing."""
    if math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0.0 else "−∞"
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        return significant(value, figures)
    return f"{value:.{figures - 1}e}"


def percent(share: float) -> str:
    """Format a share in percent: two digits below 10 %, whole percent above."""
    return f"{100.0 * share:.{0 if share >= 0.0995 else 2}{'f' if share >= 0.0995 else 'g'}} %"
