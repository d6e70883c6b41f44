"""Tables and numbers of docs/mismatch.md."""

import math

from stored import stored

from content.markdown import Form, Group, Table, chosen, rows_of

NAMES = {
    "closure_net_since_seating_mm": "net closure since 0.5 MPa (mm)",
    "normal_stiffness_net_MPa_per_mm": "net stiffness above 5 MPa (MPa/mm)",
    "residual_net_at_seating_mm": "residual at seating (mm)",
    "hysteresis": "hysteresis (share of work)",
    "aperture_at_seating_mm": "aperture at seating (mm)",
}


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


def _shift(column: str) -> Form:
    """Write a shift; where none is enough, the largest that was tried."""

    def cell(group: Group) -> str:
        largest = stored("mismatch", "mismatch").shift_mm.max()
        return f"{group[column]:.2g}" if math.isfinite(group[column]) else f"over {largest:g}"

    return cell


mismatched = Table(
    "mismatch/mismatch",
    {"mismatch wavelength (mm)": _walls, "cycle": "{cycle}"}
    | {title: _two_digits(column) for column, title in NAMES.items()},
    prepare=chosen(shift_mm=0.0),
)
unmated = Table(
    "mismatch/mismatch_shifts",
    {
        "mismatch wavelength (mm)": _walls,
        "shift (mm)": _shift("shift_mm"),
        "low": _shift("low"),
        "high": _shift("high"),
        "in apertures": "{apertures:.1f}",
    },
    prepare=lambda table: table.replace({"apertures": {math.inf: math.nan}}),
)


def first(column: str, walls: str, digits: str = ".0f", scale: float = 1.0) -> str:
    """Give a mean of first cycles: of independent walls, or ("mated") of the best mated ones.

    These are the ones with the shortest wavelength whose residual closure is positive, so that
    steps resolve them. ``digits`` is a format.
    """
    table = rows_of(stored("mismatch", "mismatch"), shift_mm=0.0, cycle=1)
    mated = table[(table.residual_net_at_seating_mm > 0.0) & (table.wavelength_mm < math.inf)]
    row = Group(mated if walls == "mated" else rows_of(table, wavelength_mm=math.inf))
    return f"{scale * row[column]:{digits}}"
