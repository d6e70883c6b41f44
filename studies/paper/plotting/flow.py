"""Figure of the hydraulic apertures of a study over stress."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from jointclosure.joint.protocol import UNLOADING
from jointclosure.plotting.style import BRANCH_LINES, above, key, legend_below, panel_grid, styled
from studies.frame.config.typed import StudyRock

_QUANTITIES = {
    "hydraulic_aperture": ("_mm", "hydraulic aperture (mm)"),
    "ratio": ("", "hydraulic / mechanical aperture"),
}


@styled
def flow_figure(table: pd.DataFrame, rocks: dict[str, StudyRock], seating_stress: float) -> Figure:
    """Draw mean hydraulic aperture and its ratio to the mean aperture for each rock's base case.

    Parameters
    ----------
    table : DataFrame
        As from `studies.frame.ensemble.flow_table.flow_table`.
    rocks : dict
        Rocks by name, in order; each has a row of panels.
    seating_stress : float
        Smallest stress of the curves [Pa].
    """
    directions = list(dict.fromkeys(table.direction))
    kinds = [(name, direction) for name in _QUANTITIES for direction in directions]
    figure, panels = panel_grid(len(rocks), len(kinds), (3.5, 3.1), (0.0, 0.7), sharex="row")
    base = table[(table.parameter == "base") & (table.stress_MPa >= 1e-6 * seating_stress)]
    for row, (name, rock) in zip(panels, rocks.items(), strict=True):
        rows = base[base.rock == name]
        for axes, (quantity, direction) in zip(row, kinds, strict=True):
            _draw(axes, rows[rows.direction == direction], quantity)
            axes.set(
                title=f"{rock.title}, flow along {direction}", xlabel="normal stress (MPa)",
                ylabel=_QUANTITIES[quantity][1], xlim=(0.0, 1e-6 * rock.max_normal_stress),
            )  # fmt: skip
        for pair in (row[: len(directions)], row[len(directions) :]):
            top = max(axes.get_ylim()[1] for axes in pair)
            for axes in pair:
                axes.set_ylim(0.0, top)
    cycles = sorted(table.cycle.unique())
    handles: list[Artist] = [
        key(color=f"C{cycle - 1}", lw=2, label=f"cycle {cycle}") for cycle in cycles
    ]
    handles += [
        key(color="0.5", lw=2, ls=style, label=f"mean, {branch}")
        for branch, style in BRANCH_LINES.items()
    ]
    handles += [
        key(color="0.5", lw=1.2, ls=":", label="mechanical (mean) aperture, loading"),
        Rectangle((0, 0), 1, 1, color="0.5", alpha=0.25, label="loading ± 1 standard deviation"),
    ]
    legend_below(figure, handles)
    sns.despine(figure)
    return figure


def _draw(axes, table: pd.DataFrame, quantity: str) -> None:
    """Draw the mean of each cycle's branches over the realisations, with a band about loading."""
    unit = _QUANTITIES[quantity][0]
    # the mean over only those joints that reach a stress would not represent all joints
    table = table[table.samples == table.samples.max()]
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        colour, stress = f"C{cycle - 1}", rows.stress_MPa.to_numpy()
        mean = rows[f"{quantity}_mean{unit}"].to_numpy()
        axes.plot(
            stress, mean, BRANCH_LINES[branch], color=colour, lw=2.0, zorder=above(cycle, branch)
        )
        if branch == UNLOADING:
            continue
        spread = np.nan_to_num(rows[f"{quantity}_standard_deviation{unit}"].to_numpy())
        low, high = np.maximum(mean - spread, 0.0), mean + spread
        axes.fill_between(stress, low, high, color=colour, alpha=0.18, lw=0)
        if quantity == "hydraulic_aperture":
            axes.plot(stress, rows.mean_aperture_mean_mm, ":", color=colour, lw=1.2)
