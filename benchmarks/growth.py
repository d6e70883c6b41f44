"""How the time to close a joint grows with cells, stress, realisations and roughness.

One cycle of dolerite walls of 100 x 100 cells, JRC 8, to 30 MPa, of which one value at a time is
changed, in the elastic scene (20 stresses) and in the full model. Every surface is closed in a
process of its own after a small joint that loads the kernels: seconds of CPU time (of less than
one: the median of further calls) and peak memory. A grid, and those beyond it, are left out if the
last two let expect more than --seconds.

The curve is a parabola of log time over log value, by least squares over all surfaces, with the
interval that holds 95 % of single surfaces; exponents are its slopes at both ends. --once N closes
only joints of N x N cells, with and without a roll-off. FFT pairs (benchmarks/yardstick.py) are
timed in between.
"""

import itertools
from pathlib import Path

import matplotlib.ticker
import yardstick

# isort: split
import numpy as np
import pandas as pd
import scipy.stats
import seaborn as sns

import jointclosure as jc
from jointclosure.ensembles.quantities import names_of_case
from jointclosure.plotting.style import styled, subplots
from jointclosure.walls.synthesis import ROLL_OFF
from studies.frame.settings import Point
from studies.frame.simulation import close_joints

BASE = {"cells": 100, "stress_mpa": 30.0, "jrc": 8.0}
VALUES = {
    "cells": (50, 100, 200, 400),
    "stress_mpa": (1.0, 3.0, 10.0, 30.0, 100.0),
    "realisations": (1, 2, 4, 8),
    "jrc": (2.0, 5.0, 10.0, 20.0),
}
TITLES = {
    "cells": ("Cells", "cells of the grid"),
    "stress_mpa": ("Stress", "maximum normal stress (MPa)"),
    "realisations": ("Realisations", "realisations of a case"),
    "jrc": ("Roughness", "joint roughness coefficient"),
}
SCENE_TITLES = {"full": "all effects", "elastic": "without breakage"}
"""Names of scenes in the figure."""


def abscissa(axis: str, values) -> np.ndarray:
    """Return the abscissa of values: the values, or the numbers of cells of square grids."""
    return np.asarray(values, dtype=float) ** (2 if axis == "cells" else 1)


def one_joint(scene, seed: int, cells: int, stress_mpa: float, jrc: float, roll_off=None):
    """Return a function that simulates a joint."""
    walls = jc.wall_pair(jrc, (cells, cells), yardstick.SPACING, seed, roll_off=roll_off)
    return lambda: yardstick.close(walls, yardstick.SCENES[scene], 1e6 * stress_mpa)


def case_of(scene: str, seed: int, realisations: int):
    """Return a function that makes the walls of some realisations and simulates them."""
    settings = yardstick.case_settings(
        realisations, BASE["cells"], 1e6 * BASE["stress_mpa"], yardstick.SCENES[scene],
        cycles=1, root_seed=seed,
    )  # fmt: skip
    case = settings.case.changed("jrc", BASE["jrc"]).under(seating_stress=0.0)
    point = Point({}, settings._replace(case=case))
    names = names_of_case(flow=False)
    return lambda: close_joints(point, point.walls(), names)


def closed_alone(axis: str, scene: str, seed: int, value: float) -> tuple[float, float]:
    """Return processor time [s] and peak memory [MB] of this process for one point of an axis."""
    yardstick.warm_up("fast")
    if axis == "realisations":
        run = case_of(scene, seed, int(value))
    else:
        changed = BASE | {axis: value}
        run = one_joint(scene, seed, int(changed.pop("cells")), **changed)
    seconds, _ = yardstick.timed(run)
    return (seconds if seconds > 1.0 else yardstick.median_time(run, 3)), yardstick.peak_memory()


def closed_once(scene: str, cells: int, roll_off: float | None) -> tuple[float, float, float]:
    """Return processor time [s], peak memory [MB] and maximum closure [mm] of one joint."""
    yardstick.warm_up("fast")
    seconds, closed = yardstick.timed(
        one_joint(scene, 0, **BASE | {"cells": cells}, roll_off=roll_off)
    )
    return seconds, yardstick.peak_memory(), 1e3 * float(closed.max_closure[0])


def once(cells: int, output: Path | None) -> None:
    """Print the cost of one large joint in each scene, on walls with and without a roll-off."""
    print(yardstick.machine(), flush=True)
    rows = []
    for roll_off, scene in itertools.product((ROLL_OFF, None), ("elastic", "full")):
        seconds, memory, closure = yardstick.called_alone(closed_once, scene, cells, roll_off)
        rows.append({"scene": scene, "cells": cells, "roll-off mm": 1e3 * (roll_off or np.nan)})
        rows[-1] |= {"s": seconds, "MB": memory, "closure mm": closure}
        yardstick.show("One joint", pd.DataFrame(rows), output, "growth_once")


def points(axis: str, scene: str, surfaces: int, limit: float) -> list[dict]:
    """Return times [ms] and memory [MB] along one axis, a row for each surface.

    Grids whose expected time exceeds ``limit`` [s] are left out.
    """
    rows = []
    medians = []
    for value in VALUES[axis]:
        if axis == "cells" and len(medians) > 1:
            (before, early), (last, late) = medians[-2:]
            slope = np.log(late / early) / np.log(last / before)
            if late * (value / last) ** slope > limit:
                break
        pair = yardstick.Pair()
        times = []
        for seed in range(surfaces):
            pair.sample()
            seconds, memory = yardstick.called_alone(closed_alone, axis, scene, seed, float(value))
            times.append(seconds)
            row = {"axis": axis, "scene": scene, "value": value, "seed": seed}
            rows.append(row | {"ms": 1e3 * seconds, "MB": memory})
        medians.append((value, float(np.median(times))))
        rows[-1]["pair ms"] = 1e3 * pair.seconds
    return rows


def fit_of(x: np.ndarray, ms: np.ndarray, at: np.ndarray) -> dict[str, np.ndarray]:
    """Fit a parabola in logarithms to times; return times and slopes ``at`` places, with errors.

    ``low`` and ``high`` are the ends of the interval that holds 95 % of single surfaces.
    """
    middle = np.log(x).mean()
    freedom = x.size - 3
    coefficients, covariance = np.polyfit(np.log(x) - middle, np.log(ms), 2, cov=True)
    apart = np.log(ms) - np.polyval(coefficients, np.log(x) - middle)
    variance = (apart**2).sum() / freedom
    u = np.log(at) - middle
    here = np.vander(u, 3)
    slope = np.stack([2.0 * u, np.ones(u.size), np.zeros(u.size)], axis=1)
    error = np.sqrt(np.einsum("ij,jk,ik->i", here, covariance, here) + variance)
    half = scipy.stats.t.ppf(0.975, freedom) * error
    fitted = here @ coefficients
    return {
        "fitted ms": np.exp(fitted),
        "low ms": np.exp(fitted - half),
        "high ms": np.exp(fitted + half),
        "exponent": slope @ coefficients,
        "standard error": np.sqrt(np.einsum("ij,jk,ik->i", slope, covariance, slope)),
    }


def summarised(closed: pd.DataFrame) -> pd.DataFrame:
    """Tabulate medians over the surfaces at each point, and the fit (`fit_of`) of each curve."""
    parts = []
    for (axis, scene), part in closed.groupby(["axis", "scene"], sort=False):
        rows = []
        for value, group in part.groupby("value"):
            row = {"axis": axis, "scene": scene, "value": value, "surfaces": len(group)}
            row |= yardstick.spread(list(group.ms), "ms", 1.0) | {"MB": group.MB.max()}
            row |= {"pairs": group.ms.median() / group["pair ms"].max()}
            rows.append(row | {"pair ms": group["pair ms"].max()})
        table = pd.DataFrame(rows)
        x = abscissa(axis, part["value"])
        at = abscissa(axis, table["value"])
        parts.append(table.assign(**fit_of(x, part.ms.to_numpy(), at)))
    return pd.concat(parts, ignore_index=True)


def draw(axes, axis: str, table: pd.DataFrame) -> None:
    """Draw time over one axis, with fitted curves and the intervals of single surfaces."""
    title, label = TITLES[axis]
    for k, scene in enumerate(yardstick.SCENES):
        part = table[(table.axis == axis) & (table.scene == scene)]
        x = abscissa(axis, part["value"])
        error = (part.ms - part["ms min"], part["ms max"] - part.ms)
        slopes = [f"{part.exponent.iloc[i]:.2f} ± {part['standard error'].iloc[i]:.2f}"
                  for i in (0, -1)]  # fmt: skip
        slope = f"exponent {slopes[0]} (left end)\nand {slopes[1]} (right end)"
        name = f"{SCENE_TITLES.get(scene, scene)}: {slope.replace('-', '−')}"
        error = [1e-3 * side for side in error]
        axes.errorbar(
            x, 1e-3 * part.ms, error, fmt="os"[k], color=f"C{k}", capsize=3, ms=5, label=name
        )
        fine = np.geomspace(x[0], x[-1], 100)
        curve = {}
        for column in ("fitted ms", "low ms", "high ms"):
            through = np.polyfit(np.log(x), np.log(1e-3 * part[column]), min(3, x.size - 1))
            curve[column] = np.exp(np.polyval(through, np.log(fine)))
        axes.plot(fine, curve["fitted ms"], "--", color=f"C{k}", lw=1)
        axes.fill_between(fine, curve["low ms"], curve["high ms"], color=f"C{k}", alpha=0.15, lw=0)
    axes.set(xscale="log", yscale="log", title=title, xlabel=label, ylabel="processor time (s)")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    values = sorted(set(table["value"][table.axis == axis]))
    names = [f"{value:g}{'²' * (axis == 'cells')}" for value in values]
    axes.set_xticks(abscissa(axis, values), names)
    axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.45, -0.2), fontsize="small")


@styled
def figure_of(table: pd.DataFrame):
    """Draw time over each of the four axes."""
    figure, panels = subplots(2, 2, figsize=(7.4, 8.6))
    for axes, axis in zip(panels.flat, TITLES, strict=True):
        draw(axes, axis, table)
    sns.despine(figure)
    return figure


def main(surfaces: int, limit: float, output: Path | None) -> None:
    """Print machine and times; write times and figure to a folder, if one is given."""
    print(yardstick.machine(), flush=True)
    yardstick.warm_up("fast")
    rows = []
    for axis in VALUES:
        for scene in yardstick.SCENES:
            rows += points(axis, scene, surfaces, limit)
            print(f"measured {axis}, {scene}", flush=True)
            if output:
                output.mkdir(parents=True, exist_ok=True)
                pd.DataFrame(rows).to_csv(output / "growth_so_far.csv", index=False)
    closed = pd.DataFrame(rows)
    table = summarised(closed)
    for axis, part in table.groupby("axis", sort=False):
        shown = part.drop(columns=["axis", "surfaces", "pair ms"])
        yardstick.show(TITLES[axis][0], shown, None, axis)
    if output:
        table.to_csv(output / "growth.csv", index=False)
        (output / "growth_so_far.csv").unlink()
        figure_of(table).savefig(output / "growth.png", dpi=150)


if __name__ == "__main__":
    asked = yardstick.options(__doc__, output=Path, once=0, surfaces=5, seconds=200.0)
    if asked.once:
        raise SystemExit(once(asked.once, asked.output))
    main(asked.surfaces, asked.seconds, asked.output)
