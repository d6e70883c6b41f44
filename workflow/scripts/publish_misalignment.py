"""Renew docs/misalignment.md from results/misalignment. Run by hand after `make misalignment`."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results/misalignment"
TILT, ROTATION = "tilt_degrees", "rotation_degrees"
SHOWN = (
    ("closure", 1, "maximum closure, cycle 1"),
    ("closure", 2, "maximum closure, cycle 2"),
    ("closure_seated_net", 1, "net closure since seating, cycle 1"),
    ("residual_seated_net", 1, "residual closure"),
    ("stiffness_net", 1, "net normal stiffness, cycle 1"),
    ("stiffness_net", 2, "net normal stiffness, cycle 2"),
)
LEVEL = 1.96
"""Standard errors of a 95 % interval."""


def changes_by(along: str) -> str:
    """Changes of each response in percent, least to largest of the rocks, against one motion."""
    other = ROTATION if along == TILT else TILT
    table = read_csv(RESULTS / "tables/misalignment.csv")
    table = table[(table[other] == 0.0) & (table[along] > 0.0)]
    rows = []
    for wavelength, part in table.groupby("wavelength_mm", sort=False):
        for response, cycle, title in SHOWN:
            own = part[(part.response == response) & (part.cycle == cycle)]
            row = {"walls": _named(wavelength), "change (%) of": title}
            for angle, at in own.groupby(along):
                row[f"{angle:g}°"] = (
                    f"{at.change_percent.min():+.1f} to {at.change_percent.max():+.1f} "
                    f"(± {at.change_error.max():.1f})"
                )
            rows.append(row)
    return markdown(pd.DataFrame(rows))


def aligned() -> str:
    """Closure, residual closure and stiffness of aligned walls, by rock."""
    table = read_csv(RESULTS / "tables/misalignment.csv")
    table = table[(table[TILT] == 0.0) & (table[ROTATION] == 0.0)]
    units = {"stiffness_net": "MPa/mm"}
    rows = []
    for wavelength, part in table.groupby("wavelength_mm", sort=False):
        for response, cycle, title in SHOWN:
            own = part[(part.response == response) & (part.cycle == cycle)]
            row = {"walls": _named(wavelength), "": f"{title} ({units.get(response, 'mm')})"}
            for each in own.itertuples():
                row[each.rock] = rounded(each.value, each.error)
            rows.append(row)
    return markdown(pd.DataFrame(rows))


def finding() -> str:
    """What is found, in sentences whose numbers are those of the tables."""
    table = read_csv(RESULTS / "tables/misalignment.csv")
    tilts = table[table[ROTATION] == 0.0]
    tilt = tilts[tilts[TILT] == tilts[TILT].max()]
    free, mated = (
        tilt[np.isinf(tilt.wavelength_mm) == independent] for independent in (True, False)
    )
    turned = table[table[ROTATION] > 0.0]
    null = turned[np.isinf(turned.wavelength_mm)]
    far = turned[(turned[ROTATION] == turned[ROTATION].max()) & np.isfinite(turned.wavelength_mm)]
    near = turned[(turned[ROTATION] == turned[ROTATION].min()) & np.isfinite(turned.wavelength_mm)]
    mean, error = _pooled(null)
    return (
        f"- **Tilt.** Of independent walls {tilt[TILT].iloc[0]:g} degrees change the closure by "
        f"{_span(free, 'closure', 1)} % on the first cycle and {_span(free, 'closure', 2)} % on "
        f"the second, the net stiffness by {_span(free, 'stiffness_net', 1)} and "
        f"{_span(free, 'stiffness_net', 2)} %. Of walls whose long waves mate they change the "
        f"closure by {_span(mated, 'closure', 1)} and {_span(mated, 'closure', 2)} %, the "
        f"stiffness by {_span(mated, 'stiffness_net', 1)} and "
        f"{_span(mated, 'stiffness_net', 2)} %.\n"
        f"- **Rotation of independent walls does nothing**, as it must: over all rocks and angles "
        f"{_significant(null)} of {len(_shown(null))} changes are beyond their 95 % interval, and "
        f"the first cycle's closure changes by {mean:+.1f} ± {error:.1f} % on average.\n"
        f"- **Rotation of walls whose long waves mate unmates them**: {near[ROTATION].iloc[0]:g} "
        f"degree changes the first cycle's closure by {_span(near, 'closure', 1)} %, "
        f"{far[ROTATION].iloc[0]:g} degrees by {_span(far, 'closure', 1)} % (stiffness "
        f"{_span(far, 'stiffness_net', 1)} %), the second cycle's by {_span(far, 'closure', 2)} % "
        f"(stiffness {_span(far, 'stiffness_net', 2)} %).\n"
        f"- First-cycle stiffness leaves out joints whose last, ever smaller steps begin below "
        f"half the maximum stress: {_left_out(free)} of {table.samples.max()} independent "
        f"ones, up to {_left_out(mated)} of those that mate. These are the stiffest.\n"
        f"- So neither moves closures of non-mated walls, which are the paper's, by more than "
        f"{np.ceil(_closures_of_paper(table).change_percent.abs().max()):.0f} %.\n"
    )


def _left_out(table: pd.DataFrame) -> int:
    """Joints without a first cycle's stiffness, of the case with the most."""
    read = table[(table.response == "stiffness_net") & (table.cycle == 1)].samples
    return int(table.samples.max() - read.min())


def _closures_of_paper(table: pd.DataFrame) -> pd.DataFrame:
    """Maximum closures of independent walls that are tilted or rotated."""
    moved = (table[TILT] > 0.0) | (table[ROTATION] > 0.0)
    return table[moved & np.isinf(table.wavelength_mm) & (table.response == "closure")]


def _shown(table: pd.DataFrame) -> pd.DataFrame:
    """The rows that the tables show."""
    kept = [
        table[(table.response == response) & (table.cycle == cycle)] for response, cycle, _ in SHOWN
    ]
    return pd.concat(kept)


def _significant(table: pd.DataFrame) -> int:
    shown = _shown(table)
    return int((shown.change_percent.abs() > LEVEL * shown.change_error).sum())


def _pooled(table: pd.DataFrame) -> tuple[float, float]:
    """Mean change of the first cycle's closure over rocks and angles, and its error.

    Rocks are independent; angles of a rock are on the same surfaces, and taken as one.
    """
    own = table[(table.response == "closure") & (table.cycle == 1)]
    by_rock = own.groupby("rock")[["change_percent", "change_error"]].mean()
    error = float(np.sqrt((by_rock.change_error**2).sum())) / len(by_rock)
    return float(by_rock.change_percent.mean()), error


def _span(table: pd.DataFrame, response: str, cycle: int) -> str:
    own = table[(table.response == response) & (table.cycle == cycle)].change_percent
    return f"{own.min():+.0f} to {own.max():+.0f}"


def _named(wavelength: float) -> str:
    return "independent" if np.isinf(wavelength) else f"mated beyond {wavelength:g} mm"


def main() -> None:
    """Fill the document, and copy its figure."""
    parts = {"finding": finding(), "tilt": changes_by(TILT), "rotation": changes_by(ROTATION)}
    fill(ROOT / "docs/misalignment.md", parts | {"aligned": aligned()})
    shutil.copy(RESULTS / "figures/misalignment.png", ROOT / "docs/images/misalignment.png")


if __name__ == "__main__":
    main()
