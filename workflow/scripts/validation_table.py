"""Write what the model gives beside three measured joints into docs/validation.md.

    .venv/bin/python workflow/scripts/validation_table.py

A few minutes. The page keeps its text; the lines between its marks are made anew.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.config.rocks import named_rock
from jointclosure.engineering.curves import cycle_table
from jointclosure.engineering.laws import fitted_laws
from jointclosure.engineering.stiffness import secant_stiffness
from jointclosure.history import GROSS

PAGE = Path(__file__).parents[2] / "docs/validation.md"
START, END = "<!-- model -->", "<!-- end -->"
SPACING, STRESS, SEATING = 0.25e-3, 10e6, 0.5e6
WALLS: dict[str, dict] = {
    "independent": {},
    "independent, waves up to 3 mm": {"roll_off": 3e-3},
    "correlated by 0.9": {"correlation": 0.9},
    "mating beyond 6 mm": {"mismatch_wavelength": 6e-3},
    "mating beyond 3 mm": {"mismatch_wavelength": 3e-3},
    "mating beyond 1.5 mm": {"mismatch_wavelength": 1.5e-3},
}
"""Walls of JRC 8 that are closed, and what `jointclosure.wall_pair` is told of them."""
COLUMNS: dict[str, str] = {
    "closure": "closure at 10 MPa (mm)",
    "seated": "since 0.5 MPa (mm)",
    "stays": "of it stays (%)",
    "kn": "kn, 5 to 10 MPa (MPa/mm)",
    "stiffer": "kn of cycle 2 over cycle 1",
    "semilog": "rms miss of the semi-logarithmic law (%)",
    "hyperbola": "of the hyperbola (%)",
    "loop": "loop of cycle 2 (MPa)",
}


def numbers_of(history) -> dict[str, float]:
    """What is compared, of one joint."""
    first = cycle_table(history).iloc[0]
    kn = [1e-9 * secant_stiffness(history, cycle, 0.5 * STRESS, STRESS, GROSS) for cycle in (1, 2)]
    fits = fitted_laws(history, GROSS)
    fits = fits[(fits.cycle == 1) & (fits.branch == "loading")].drop_duplicates("law")
    miss = 100.0 * fits.set_index("law").rms_mm / first.closure_gross_since_seating_mm
    return {
        "closure": first.max_closure_gross_mm,
        "seated": first.closure_gross_since_seating_mm,
        "stays": 100.0 * first.residual_share_gross,
        "kn": kn[0],
        "stiffer": kn[1] / kn[0],
        "semilog": float(miss["semi_logarithmic"]),
        "hyperbola": float(miss["hyperbolic"]),
        "loop": 1e-6 * float(history.unloading_excess[1]),
    }


def model_table(
    cells: int, seeds: range, report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Means and standard deviations over joints of granite: columns (name, statistic)."""
    rock, rows = named_rock("granite"), {}
    for name, told in WALLS.items():
        found = []
        for seed in seeds:
            pair = jc.wall_pair(8.0, (cells, cells), SPACING, seed, **told)
            history = jc.simulate(
                *pair, spacing=SPACING, rock=rock, max_normal_stress=STRESS, seating_stress=SEATING
            )
            found.append(numbers_of(history))
        joints = pd.DataFrame(found)
        rows[name] = {
            (key, statistic): getattr(joints[key], statistic)()
            for key in joints
            for statistic in ("mean", "std")
        }
        report(name)
    return pd.DataFrame(rows).T


def as_markdown(table: pd.DataFrame, cells: int, joints: int) -> str:
    """The table between the marks of the page."""
    size = 1e3 * cells * SPACING
    lines = [
        f"Means over {joints} joints of granite, JRC 8, {size:g} x {size:g} mm, with the standard "
        "deviation of single joints:",
        "",
        "| walls | " + " | ".join(COLUMNS.values()) + " |",
        "|---" * (len(COLUMNS) + 1) + "|",
    ]
    for name, row in table.iterrows():
        cells_of_row = [_plain(row[key, "mean"], row[key, "std"]) for key in COLUMNS]
        lines.append(f"| {name} | " + " | ".join(cells_of_row) + " |")
    return "\n".join(lines)


def _plain(mean: float, deviation: float) -> str:
    """A mean to two figures of its deviation's size, without powers of ten."""
    if deviation == 0.0:
        return f"{mean:.3g}"
    digits = max(0, 1 - int(np.floor(np.log10(deviation))))
    return f"{mean:.{digits}f} ± {deviation:.{digits}f}"


def put_in(page: str, block: str) -> str:
    """The page with a new block between its marks."""
    before, _, rest = page.partition(START)
    _, _, after = rest.partition(END)
    return f"{before}{START}\n{block}\n{END}{after}"


def main(cells: int = 100, joints: int = 10) -> None:
    """Close the joints and write the page."""
    table = model_table(cells, range(joints), lambda line: print(line, flush=True))
    block = as_markdown(table, cells, joints)
    PAGE.write_text(put_in(PAGE.read_text(encoding="utf-8"), block), encoding="utf-8")


if __name__ == "__main__":
    main()
