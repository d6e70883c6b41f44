"""Tables and numbers of docs/mismatch.md."""

import math

from stored import stored

from content.markdown import Form, Group, Table, chosen, rows_of, value_of
from jointclosure.engine.quantities import HEADINGS
from jointclosure.measured.fit import DOUBTFUL

SHOWN = (
    "max_closure_seated_net_mm",
    "stiffness_net_MPa_per_mm",
    "residual_closure_seated_net_mm",
    "hysteresis",
    "mean_aperture_at_seating_mm",
)


def _walls(group: Group) -> str:
    wavelength = group["wavelength_mm"]
    return {0.0: "0 (mates)", math.inf: "independent"}.get(wavelength, f"{wavelength:g}")


def _two_digits(column: str) -> Form:
    """Write a value with its standard error, to two digits of this and at most five places."""

    def cell(group: Group) -> str:
        value, error = group[column], group[f"{column}_error"]
        if not math.isfinite(value):
            return ""
        digits = min(max(1 - math.floor(math.log10(error)), 0), 5) if error > 0.0 else 5
        value = round(value, digits) + 0.0  # no negative zero
        return f"{value:.{digits}f} ± {error:.{digits}f}"

    return cell


mismatched = Table(
    "mismatch/mismatch",
    {"mismatch wavelength (mm)": _walls}
    | {HEADINGS[column]: _two_digits(column) for column in SHOWN},
    prepare=chosen(shift_mm=0.0, cycle=1),
)


def _length(value: float) -> str:
    return "none" if math.isinf(value) else "mated" if value == 0.0 else f"{value:.2g}"


def _fitted(group: Group) -> str:
    if group["p_value"] < DOUBTFUL:
        return "not explained"
    value, low, high = (group[f"{name}_mm"] for name in ("wavelength", "low", "high"))
    return f"{_length(value)} ({_length(low)} to {_length(high)})"


measured_fits = Table(
    "measured_fit/measured_fit",
    {
        "joint": "{joint}",
        "side simulated (mm)": "{side_mm:g}",
        "mismatch wavelength (95 % interval, mm)": _fitted,
        "joints as far from their mean (%)": lambda group: f"{100.0 * group['p_value']:.2g}",
    },
)
known_wavelengths = Table(
    "measured_fit/measured_fit_known",
    {
        "mismatch wavelength (mm)": _walls,
        "fits": "{fits}",
        "intervals that contain it": "{contain}",
        "median estimate (mm)": lambda group: _length(group["median_mm"]),
        "not explained": "{unexplained}",
    },
)
example_joint = Table(
    "measured_fit/measured_fit_example",
    {
        "simulated walls": lambda group: (
            "waves of all lengths"
            if math.isinf(group["roll_off_mm"])
            else f"roll-off at {group['roll_off_mm']:g} mm"
        ),
        "mismatch wavelength (95 % interval, mm)": _fitted,
        "joints as far from their mean (%)": lambda group: f"{100.0 * group['p_value']:.2g}",
    },
)


def first(column: str, walls: str, digits: str = ".0f", scale: float = 1.0) -> str:
    """Give a mean of first cycles: of independent walls, or ("mated") of the best mated ones.

    These are the ones with the shortest wavelength whose residual closure is positive, so that
    steps resolve them. ``digits`` is a format.
    """
    table = rows_of(stored("mismatch", "mismatch"), shift_mm=0.0, cycle=1)
    mated = table[(table.residual_closure_seated_net_mm > 0.0) & (table.wavelength_mm < math.inf)]
    row = Group(mated if walls == "mated" else rows_of(table, wavelength_mm=math.inf))
    return f"{scale * row[column]:{digits}}"


def least_shift() -> str:
    """Give the least lower limit [mm] of the shift from which walls count as independent."""
    return value_of("mismatch/mismatch_shifts", "{low min:.1f}")
