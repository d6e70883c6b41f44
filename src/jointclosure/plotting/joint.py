"""Closure curve of one joint."""

import numpy as np
import seaborn as sns
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engineering.curves import seat_of
from jointclosure.history import branch_of
from jointclosure.plotting.style import BRANCH_LINES, above, styled, subplots
from jointclosure.protocol import LOADING


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
    draw_curves(axes, closed)
    axes.set_title(title, parse_math=False)
    sns.despine(figure)
    return figure


def draw_curves(axes: Axes, closed: xr.Dataset, since: str = "touch") -> None:
    """Stress against closure on axes, each cycle in its colour, unloading dashed.

    Parameters
    ----------
    axes : Axes
    closed : Dataset
        As from `jointclosure.simulate`.
    since : {"touch", "seating", "cycle"}
        Where closure counts from: first touch, the seating stress on each cycle's loading, or
        each cycle's start.
    """
    cycle, branch = closed.cycle.values, closed.branch.values
    numbers = sorted(set(cycle.tolist()))
    for number in numbers:
        zero = _zero_of(closed, number, since)
        for name, style in BRANCH_LINES.items():
            here = branch_of(cycle, branch, number, name)
            closure, stress = closed.closure.values[here], closed.normal_stress.values[here]
            if since == "seating":
                closure, stress = _from_seating(closed, number, name, closure, stress)
            axes.plot(
                1e3 * (closure - zero),
                1e-6 * stress,
                style,
                color=f"C{number - 1}",
                zorder=above(number, name),
                label=f"cycle {number}, {name}",
            )
    seating = 1e-6 * float(closed.attrs["seating_stress_Pa"])
    words = {"touch": "first touch", "seating": f"{seating:g} MPa", "cycle": "the cycle's start"}
    axes.set(xlabel=f"closure from {words[since]} (mm)", ylabel="normal stress (MPa)", ylim=0.0)
    if len(numbers) <= 5:
        axes.legend(frameon=False)


def _zero_of(closed: xr.Dataset, cycle: int, since: str) -> float:
    """Closure [m] that counts as none in a cycle."""
    if since == "seating":
        return seat_of(closed, cycle, LOADING)
    if since == "cycle":
        here = branch_of(closed.cycle.values, closed.branch.values, cycle, LOADING)
        return float(closed.closure.values[here[0]])
    return 0.0


def _from_seating(
    closed: xr.Dataset, cycle: int, branch: str, closure: np.ndarray, stress: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a branch above the seating stress, its point at that stress included."""
    seating = float(closed.attrs["seating_stress_Pa"])
    above_it, seat = stress > seating, seat_of(closed, cycle, branch)
    end = 0 if branch == LOADING else int(above_it.sum())
    return (
        np.insert(closure[above_it], end, seat),
        np.insert(stress[above_it], end, seating),
    )
