"""How the time to close a joint grows with cells, stress, realisations and roughness.

One cycle of dolerite walls of 100 x 100 cells, JRC 8, to 30 MPa, of which one value at a time is
changed: the cells along a square grid of fixed spacing, the maximum stress, the number of
realisations that are made and closed as a case of a study, or the JRC. Each in the elastic scene
(20 stresses up the curve) and in the full model (the paper's displacement and breakage steps,
whatever the grid and the walls).

A point is the median over --surfaces random surfaces; what takes less than a second is called
again, and its median taken. A grid is left out, and those beyond it, if the last two let expect
more than --seconds for one surface. Exponents are least squares of log time over log value, each
point the median of its surfaces, with the standard error of the slope; of the cells the exponent
is that of their number. An exponent describes the range that was measured: where overheads or
another regime begin, a power law does not hold, and the standard error shows it. FFT pairs
(benchmarks/yardstick.py) are timed in between. One thread. Run as `python benchmarks/growth.py`.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))
os.environ["MPLBACKEND"] = "Agg"

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np
import pandas as pd
import scipy.stats
import seaborn as sns
from yardstick import (
    SCENES,
    SPACING,
    Pair,
    case_settings,
    close,
    machine,
    median_time,
    show,
    spread,
    timed,
    warm_up,
)

import jointclosure as jc
from jointclosure.ensemble.closing import close_surfaces
from jointclosure.ensemble.surfaces import surfaces_of

BASE = {"cells": 100, "stress_mpa": 30.0, "jrc": 8.0}
VALUES = {
    "cells": (32, 64, 128, 256, 512),
    "stress_mpa": (1.0, 3.0, 10.0, 30.0, 100.0),
    "realisations": (1, 2, 4, 8, 16),
    "jrc": (2.0, 6.0, 10.0, 15.0, 20.0),
}
TITLES = {
    "cells": ("Cells", "cells of the grid"),
    "stress_mpa": ("Stress", "maximum normal stress (MPa)"),
    "realisations": ("Realisations", "realisations of a case"),
    "jrc": ("Roughness", "joint roughness coefficient"),
}


def abscissa(axis: str, values) -> np.ndarray:
    """What a value is drawn and fitted at: itself, or the number of cells of a square grid."""
    return np.asarray(values, dtype=float) ** (2 if axis == "cells" else 1)


def one_joint(scene: str, seed: int, cells: int, stress_mpa: float, jrc: float):
    """A function that closes a joint."""
    walls = jc.wall_pair(jrc, (cells, cells), SPACING, seed, roll_off=None)
    return lambda: close(walls, SCENES[scene], 1e6 * stress_mpa)


def case_of(scene: str, seed: int, realisations: int):
    """A function that makes and closes a number of realisations."""
    settings = case_settings(
        realisations, BASE["cells"], 1e6 * BASE["stress_mpa"], SCENES[scene],
        cycles=1, root_seed=seed,
    )  # fmt: skip
    case = settings.case._replace(jrc=BASE["jrc"])
    settings = settings._replace(
        case=case, surfaces=settings.surfaces._replace(jrc=case.jrc), seating_stress=0.0
    )

    def run():
        return [list(close_surfaces(pair, settings)) for pair in surfaces_of(settings.surfaces)]

    return run


def seconds_of(run, pair: Pair) -> float:
    """Seconds of a call, a median where it is short."""
    pair.sample()
    seconds, _ = timed(run)
    return seconds if seconds > 1.0 else median_time(run, 3, pair.sample)


def points(axis: str, scene: str, surfaces: int, limit: float) -> list[dict]:
    """Times along one axis."""
    rows = []
    for value in VALUES[axis]:
        if axis == "cells" and len(rows) > 1:
            before, last = rows[-2], rows[-1]
            slope = np.log(last["ms"] / before["ms"]) / np.log(last["value"] / before["value"])
            if 1e-3 * last["ms"] * (value / last["value"]) ** slope > limit:
                break
        pair, times = Pair(), []
        for seed in range(surfaces):
            if axis == "realisations":
                run = case_of(scene, seed, value)
            else:
                run = one_joint(scene, seed, **(BASE | {axis: value}))
            times.append(seconds_of(run, pair))
        row = {"axis": axis, "scene": scene, "value": value, "surfaces": surfaces}
        row |= spread(times, "ms", 1e3) | {"pairs": np.median(times) / pair.seconds}
        rows.append(row | {"pair ms": 1e3 * pair.seconds})
    return rows


def with_exponents(table: pd.DataFrame) -> pd.DataFrame:
    """The table and the fit of each curve, in columns."""
    for (axis, _), part in table.groupby(["axis", "scene"]):
        drawn = abscissa(axis, part["value"])
        fit = scipy.stats.linregress(np.log(drawn), np.log(part.ms))
        table.loc[part.index, ["exponent", "standard error"]] = fit.slope, fit.stderr
        table.loc[part.index, "fitted ms"] = np.exp(fit.intercept) * drawn**fit.slope
    return table


def draw(axes, axis: str, table: pd.DataFrame) -> None:
    """Time against one of the four, with the fitted powers."""
    title, label = TITLES[axis]
    for k, scene in enumerate(SCENES):
        part = table[(table.axis == axis) & (table.scene == scene)]
        x = abscissa(axis, part["value"])
        error = (part.ms - part["ms min"], part["ms max"] - part.ms)
        slope = f"{part.exponent.iloc[0]:.2f} ± {part['standard error'].iloc[0]:.2f}"
        name = f"{scene}: exponent {slope}".replace("-", "−")
        axes.errorbar(x, part.ms, error, fmt="os"[k], color=f"C{k}", capsize=3, ms=5, label=name)
        axes.plot(x, part["fitted ms"], "--", color=f"C{k}", lw=1)
    axes.set(xscale="log", yscale="log", title=title, xlabel=label, ylabel="time (ms)")
    values = table["value"][table.axis == axis].astype(float).unique()
    names = [f"{value:g}{'²' * (axis == 'cells')}" for value in values]
    axes.set_xticks(abscissa(axis, values), names)
    axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.35)  # room for the legend
    axes.legend(frameon=False, loc="upper left")


def figure_of(table: pd.DataFrame):
    """Time against each of the four, and what is the same in all."""
    sns.set_theme(context="paper", style="ticks", palette="colorblind", font_scale=1.1)
    figure, panels = plt.subplots(2, 2, figsize=(9.0, 7.0), layout="constrained")
    for axes, axis in zip(panels.flat, TITLES, strict=True):
        draw(axes, axis, table)
    sns.despine(figure)
    pair = table["pair ms"].median()
    figure.suptitle(
        "Time to close a joint: 100 × 100 cells, 30 MPa, JRC 8, dolerite, one cycle\n"
        f"medians and extremes over surfaces, and fitted powers; one FFT pair is {pair:.2f} ms"
    )
    return figure


def main(surfaces: int, limit: float, output: Path | None) -> None:
    """Print machine and times; write them, and the figure."""
    print(machine(), flush=True)
    warm_up("fast")
    rows = []
    for axis in VALUES:
        for scene in SCENES:
            rows += points(axis, scene, surfaces, limit)
            print(f"measured {axis}, {scene}", flush=True)
            if output:
                output.mkdir(parents=True, exist_ok=True)
                pd.DataFrame(rows).to_csv(output / "growth_so_far.csv", index=False)
    table = with_exponents(pd.DataFrame(rows))
    for axis, part in table.groupby("axis", sort=False):
        left_out = ["axis", "surfaces", "pair ms", "fitted ms"]
        show(TITLES[axis][0], part.drop(columns=left_out), None, axis)
    if output:
        output.mkdir(parents=True, exist_ok=True)
        table.to_csv(output / "growth.csv", index=False)
        (output / "growth_so_far.csv").unlink()
        figure_of(table).savefig(output / "growth.png", dpi=150)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--surfaces", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=60.0, help="most for one surface")
    parser.add_argument("--output", type=Path, help="folder for a CSV and a figure")
    arguments = parser.parse_args()
    main(arguments.surfaces, arguments.seconds, arguments.output)
