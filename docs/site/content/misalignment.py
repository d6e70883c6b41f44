"""Tables and findings of docs/misalignment.md."""

import numpy as np
import pandas as pd
from stored import stored

from content.markdown import MOST, first_row, grouped, rows_of, titled
from jointclosure.statistics.standard_errors import rounded

TILT, ROTATION = "tilt_degrees", "rotation_degrees"
SHOWN = {
    ("closure", 1): "maximum closure, cycle 1",
    ("closure", 2): "maximum closure, cycle 2",
    ("closure_seated_net", 1): "net closure since seating, cycle 1",
    ("residual_seated_net", 1): "residual closure",
    ("stiffness_net", 1): "net normal stiffness, cycle 1",
    ("stiffness_net", 2): "net normal stiffness, cycle 2",
}
LEVEL = 1.96
"""Standard errors of a 95 % interval."""


def _shown(table: pd.DataFrame) -> pd.DataFrame:
    """Choose the rows that tables have, and name their walls and responses."""
    table = titled(table, SHOWN, "response", "cycle").sort_values(["wavelength_mm", "title"])
    return table.assign(walls=table.wavelength_mm.map(_walls))


def _walls(wavelength: float) -> str:
    return "independent" if np.isinf(wavelength) else f"mated beyond {wavelength:g} mm"


def changes_by(along: str) -> str:
    """Tabulate changes [%] of responses, least to largest of the rocks, against one motion."""
    other = ROTATION if along == TILT else TILT
    table = stored("misalignment", "misalignment")
    table = _shown(table[(table[other] == 0.0) & (table[along] > 0.0)])

    def change(part: pd.DataFrame) -> str:
        low, high = part.change_percent.min(), part.change_percent.max()
        return f"{low:+.1f} to {high:+.1f} (± {part.change_error.max():.1f})"

    return grouped(
        table.assign(angle=table[along].map("{:g}°".format)),
        {"walls": "walls", "change (%) of": "title"},
        across="angle",
        cell=change,
    )


def tilt() -> str:
    """Tabulate what tilts change."""
    return changes_by(TILT)


def rotation() -> str:
    """Tabulate what rotations about the normal change."""
    return changes_by(ROTATION)


def change(motion: str, angle: float | str, walls: str, response: str, cycle: int) -> str:
    """Give changes [%] of a response at an angle, or at `MOST`, least to largest of the rocks.

    ``walls`` are "independent" or "mated".
    """
    table = _moved(motion, walls)
    table = rows_of(table, **{f"{motion}_degrees": angle, "response": response, "cycle": cycle})
    return f"{table.change_percent.min():+.0f} to {table.change_percent.max():+.0f}"


def angle(motion: str, of: str = "max") -> str:
    """Give the largest angle [degrees] of a motion, or ("min") the least."""
    return f"{getattr(_moved(motion, 'independent')[f'{motion}_degrees'], of)():g}"


def _moved(motion: str, walls: str) -> pd.DataFrame:
    """Choose rows in which walls were tilted, or rotated, and not both."""
    table = stored("misalignment", "misalignment")
    other = ROTATION if motion == "tilt" else TILT
    table = table[(table[f"{motion}_degrees"] > 0.0) & (table[other] == 0.0)]
    return table[np.isinf(table.wavelength_mm) == (walls == "independent")]


def significant_rotations() -> str:
    """Count changes of independent walls by rotations that are beyond their 95 % interval."""
    table = _shown(_moved("rotation", "independent"))
    return f"{(table.change_percent.abs() > LEVEL * table.change_error).sum()} of {len(table)}"


def mean_rotation() -> str:
    """Average what rotations change [%] of the first closure of independent walls.

    Rocks are independent; angles of a rock are on the same surfaces, and taken as one.
    """
    table = rows_of(_moved("rotation", "independent"), response="closure", cycle=1)
    of_rocks = table.groupby("rock")[["change_percent", "change_error"]].mean()
    error = float(np.sqrt((of_rocks.change_error**2).sum())) / len(of_rocks)
    return f"{of_rocks.change_percent.mean():+.1f} ± {error:.1f}"


def left_out(walls: str) -> int:
    """Count joints without a first cycle's stiffness at the largest tilt, of the case with most."""
    table = rows_of(_moved("tilt", walls), tilt_degrees=MOST)
    read = rows_of(table, response="stiffness_net", cycle=1).samples
    return int(table.samples.max() - read.min())


def samples() -> int:
    """Count the joints of a case."""
    return int(stored("misalignment", "misalignment").samples.max())


def largest_change() -> str:
    """Give the largest change [%] of a maximum closure of independent walls, rounded up."""
    table = pd.concat(_moved(motion, "independent") for motion in ("tilt", "rotation"))
    return f"{np.ceil(rows_of(table, response='closure').change_percent.abs().max()):.0f}"


def aligned() -> str:
    """Tabulate closure, residual closure and stiffness of aligned walls, by rock."""
    table = _shown(rows_of(stored("misalignment", "misalignment"), **{TILT: 0.0, ROTATION: 0.0}))

    def value(part: pd.DataFrame) -> str:
        row = first_row(part)
        return rounded(row.value, row.error)

    units = table.response.map({"stiffness_net": "MPa/mm"}).fillna("mm")
    return grouped(
        table.assign(title=table.title.astype(str) + " (" + units + ")"),
        {"walls": "walls", "": "title"},
        across="rock",
        cell=value,
    )
