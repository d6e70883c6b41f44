"""Tables and numbers of docs/mismatch.md."""

import math

from stored import stored

from content.markdown import listed, rows_of

COLUMNS = {
    "closure_net_since_seating_mm": "net closure since 0.5 MPa (mm)",
    "normal_stiffness_net_MPa_per_mm": "net stiffness above 5 MPa (MPa/mm)",
    "residual_net_at_seating_mm": "residual at seating (mm)",
    "hysteresis": "hysteresis (share of work)",
    "aperture_at_seating_mm": "aperture at seating (mm)",
}
WAVELENGTH = "mismatch wavelength (mm)"


def _walls(row: dict) -> str:
    wavelength = row["wavelength_mm"]
    return {0.0: "0 (mates)", math.inf: "independent"}.get(wavelength, f"{wavelength:g}")


def _two_digits(column: str):
    """Write a value with its standard error, to two digits of this."""

    def cell(row: dict) -> str:
        value, error = row[column], row[f"{column}_error"]
        if not math.isfinite(value):
            return ""
        digits = min(max(1 - math.floor(math.log10(error)), 0), 5) if error > 0.0 else 5
        value = round(value, digits) + 0.0  # no negative zero
        return f"{value:.{digits}f} ± {error:.{digits}f}"

    return cell


def mismatched() -> str:
    """Tabulate closure, stiffness, what stays and hysteresis against mismatch, without a shift."""
    columns = {WAVELENGTH: _walls, "cycle": "{cycle}"}
    columns |= {title: _two_digits(column) for column, title in COLUMNS.items()}
    return listed(rows_of(stored("mismatch", "mismatch"), shift_mm=0.0), columns)


def unmated() -> str:
    """Tabulate the shift from which on walls behave as independent ones."""
    largest = stored("mismatch", "mismatch").shift_mm.max()

    def shift(column: str):
        return lambda row: (
            f"{row[column]:.2g}" if math.isfinite(row[column]) else f"over {largest:g}"
        )

    def apertures(row: dict) -> str:
        return f"{row['apertures']:.1f}" if math.isfinite(row["apertures"]) else ""

    columns = {WAVELENGTH: _walls, "shift (mm)": shift("shift_mm"), "low": shift("low")}
    columns |= {"high": shift("high"), "in apertures": apertures}
    return listed(stored("mismatch", "mismatch_shifts"), columns)


def first(column: str, walls: str, digits: str = ".0f", scale: float = 1.0) -> str:
    """Give a mean of first cycles: of independent walls, or ("mated") of the best mated ones.

    These are the ones with the shortest wavelength whose residual closure is positive, so that
    steps resolve them. ``digits`` is a format.
    """
    table = rows_of(stored("mismatch", "mismatch"), shift_mm=0.0, cycle=1)
    resolved = table[(table.residual_net_at_seating_mm > 0.0) & (table.wavelength_mm < math.inf)]
    row = resolved.iloc[0] if walls == "mated" else rows_of(table, wavelength_mm=math.inf).iloc[0]
    return f"{scale * row[column]:{digits}}"
