"""Tables and numbers of docs/misalignment.md."""

import numpy as np
import pandas as pd
from stored import stored

from content.markdown import MOST, rows_of, titled
from jointclosure.engine.quantities import titles_of_cycles

SHOWN = titles_of_cycles(
    ("max_closure", 1),
    ("max_closure", 2),
    ("max_closure_seated_net", 1),
    ("residual_closure_seated_net", 1),
    ("stiffness_net", 1),
    ("stiffness_net", 2),
)
MOTIONS = ("tilt", "rotation")
LEVEL = 1.96
"""Standard errors of a 95 % interval."""


def _shown(table: pd.DataFrame, motion: str = "") -> pd.DataFrame:
    """Choose rows of tables in which walls were moved so, and not otherwise."""
    for name in MOTIONS:
        table = table[(table[f"{name}_degrees"] > 0.0) == (name == motion)]
    return titled(table, SHOWN, "response", "cycle").sort_values(["wavelength_mm", "title"])


def _moved(motion: str, walls: str) -> pd.DataFrame:
    """Choose rows of tables by the motion and the walls, "independent" or "mated"."""
    table = _shown(stored("misalignment", "misalignment"), motion)
    return table[np.isinf(table.wavelength_mm) == (walls == "independent")]


def change(motion: str, angle: float | str, walls: str, response: str, cycle: int) -> str:
    """Give changes [%] of a response at an angle, or at `MOST`, least to largest of the rocks."""
    where = {f"{motion}_degrees": angle, "response": response, "cycle": cycle}
    values = rows_of(_moved(motion, walls), **where).change_percent
    return f"{values.min():+.0f} to {values.max():+.0f}"


def angle(motion: str, of: str = "max") -> str:
    """Give the largest angle [degrees] of a motion, or ("min") the least."""
    return f"{getattr(_moved(motion, 'independent')[f'{motion}_degrees'], of)():g}"


def significant_rotations() -> str:
    """Count changes of independent walls by rotations that are beyond their 95 % interval."""
    table = _moved("rotation", "independent")
    return f"{(table.change_percent.abs() > LEVEL * table.change_error).sum()} of {len(table)}"


def mean_rotation() -> str:
    """Average what rotations change [%] of the first closure of independent walls.

    Rocks are independent; angles of a rock are on the same surfaces, and taken as one.
    """
    table = rows_of(_moved("rotation", "independent"), response="max_closure", cycle=1)
    of_rocks = table.groupby("rock")[["change_percent", "change_error"]].mean()
    error = float(np.sqrt((of_rocks.change_error**2).sum())) / len(of_rocks)
    return f"{of_rocks.change_percent.mean():+.1f} ± {error:.1f}"


def left_out(walls: str) -> int:
    """Count joints without a first cycle's stiffness at the largest tilt, of the case with most."""
    table = rows_of(_moved("tilt", walls), tilt_degrees=MOST)
    return table.samples.max() - rows_of(table, response="stiffness_net", cycle=1).samples.min()


def samples() -> int:
    """Count the joints of a case."""
    return stored("misalignment", "misalignment").samples.max()


def largest_change() -> str:
    """Give the largest change [%] of a maximum closure of independent walls, rounded up."""
    table = pd.concat(_moved(motion, "independent") for motion in MOTIONS)
    return f"{np.ceil(rows_of(table, response='max_closure').change_percent.abs().max()):.0f}"
