"""Closure curve of one joint."""

import seaborn as sns
import xarray as xr
from matplotlib.figure import Figure

from jointclosure.history import branch_of
from jointclosure.plotting.style import BRANCH_LINES, above, styled, subplots


@styled
def closure_curve(closed: xr.Dataset, title: str) -> Figure:
    """Stress against closure from first touch, each cycle in its colour.

    Parameters
    ----------
    closed : Dataset
        As from `jointclosure.simulate`.
    title : str
    """
    figure, axes = subplots(figsize=(6.4, 4.4), layout="constrained")
    cycle, branch = closed.cycle.values, closed.branch.values
    for number in sorted(set(cycle.tolist())):
        for name, style in BRANCH_LINES.items():
            here = branch_of(cycle, branch, number, name)
            axes.plot(
                1e3 * closed.closure.values[here],
                1e-6 * closed.normal_stress.values[here],
                style,
                color=f"C{number - 1}",
                zorder=above(number, name),
                label=f"cycle {number}, {name}",
            )
    axes.set(
        title=title, xlabel="closure from first touch (mm)", ylabel="normal stress (MPa)", ylim=0.0
    )
    if len(set(cycle.tolist())) <= 5:
        axes.legend(frameon=False)
    sns.despine(figure)
    return figure
