"""Draw the picture of README: two walls, where they touch at the largest stress, and their closure.

    .venv/bin/python docs/site/overview.py

It takes half a minute. 20 pairs of walls are closed; the map is of the first of them.
"""

import itertools
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import jointclosure as jc
from jointclosure.engine.aggregation import since_seating
from jointclosure.joint.loading import SEATING_STRESS

JRC, SHAPE, SPACING, SURFACES, STRESS = 8, (100, 100), 0.25e-3, 20, 10e6
ROCK = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
PICTURE = Path(__file__).parents[1] / "images/overview.png"


def walls_of(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A pair of independent walls."""
    return jc.wall_pair(jrc=JRC, shape=SHAPE, spacing=SPACING, seed=seed)


def draw_band(axes: Axes, ensemble: xr.Dataset) -> None:
    """Draw the mean net closure of each branch, and the band of its 5 to 95 % quantiles."""
    net = 1e3 * since_seating(ensemble).sel(stress=ensemble.stress > SEATING_STRESS)
    stress = 1e-6 * net.stress
    for cycle, branch in itertools.product(ensemble.cycle.values, ensemble.branch.values):
        closure = net.sel(cycle=cycle, branch=branch)
        low, high = (closure.quantile(share, "realization") for share in (0.05, 0.95))
        colour, style = ("C0", "C1")[cycle - 1], "-" if branch == "loading" else (0, (2, 3))
        colour = colour if style == "-" else "0.2"
        if style == "-":
            axes.fill_betweenx(stress, low, high, color=colour, alpha=0.15, lw=0)
        mean, at = closure.mean("realization").values, stress.values
        if branch == "loading":  # which starts at seating
            mean, at = np.append(0.0, mean), np.append(1e-6 * SEATING_STRESS, at)
        axes.plot(mean, at, ls=style, color=colour, label=f"cycle {cycle}, {branch}")
    axes.set(
        xlabel=f"net closure since {1e-6 * SEATING_STRESS:g} MPa (mm)",
        ylabel="normal stress (MPa)",
        ylim=0,
        xlim=0,
    )
    axes.legend(frameon=False)


def main() -> None:
    """Close the joints, and draw."""
    load = {"spacing": SPACING, "rock": ROCK, "max_normal_stress": STRESS}
    upper, lower = walls_of(0)
    joint = jc.simulate(upper, lower, **load, cycles=2, snapshots=[STRESS])
    ensemble = jc.simulate_ensemble(walls_of, seeds=range(SURFACES), **load)
    figure, (section, contacts, curves) = plt.subplots(
        1, 3, figsize=(14, 4), width_ratios=(1.25, 1.1, 1.2), layout="constrained"
    )
    jc.plot.walls(upper, lower, spacing=SPACING, axes=section)
    jc.plot.aperture(joint, 0, contacts)
    draw_band(curves, ensemble)
    section.set_title("two walls at first touch")
    contacts.set_title(f"the joint at {1e-6 * STRESS:g} MPa")
    curves.set_title(f"closure of {SURFACES} pairs: mean and 90 % band")
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
