"""Closure and stiffness curves of one joint."""

import numpy as np
import pandas as pd
import seaborn as sns
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.budget import CLOSURE_GROSS, CLOSURE_NET, leading
from jointclosure.joint.curves import seat_of
from jointclosure.joint.history import GROSS, NET, branch_of, read_along
from jointclosure.joint.protocol import LOADING
from jointclosure.joint.stiffness import stiffness_table
from jointclosure.plotting.style import BRANCH_LINES, above, decimal_ticks, styled, subplots


@styled
def closure_curve(closed: xr.Dataset, title: str, ranges: pd.DataFrame | None = None) -> Figure:
    """Draw stress against gross and against net closure since seating.

    What is closed before seating depends on the point that touches first, and is not shown.

    Parameters
    ----------
    closed : Dataset
        As from `jointclosure.simulate`.
    title : str
    ranges : DataFrame, optional
        `jointclosure.engine.budget.Budget.ranges`, drawn as bars above the largest stress.
    """
    figure, panels = subplots(1, 2, figsize=(10.4, 4.8), sharex=True, sharey=True)
    columns = {GROSS: CLOSURE_GROSS, NET: CLOSURE_NET}
    for axes, (of, column) in zip(panels, columns.items(), strict=True):
        if ranges is not None:
            _draw_ranges(axes, ranges.xs(column, level=1), closed)
        draw_curves(axes, closed, "seating", of)
    panels[1].set(ylabel="")
    if panels[0].get_legend():  # below the panels, where no curve is
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        for axes in panels:
            axes.get_legend().remove()
    figure.suptitle(title, parse_math=False)
    sns.despine(figure)
    return figure


def _draw_ranges(axes: Axes, ranges: pd.DataFrame, closed: xr.Dataset) -> None:
    """Draw ranges [mm] of the closure at the largest stress by cycle, each above the one before."""
    largest = 1e-6 * float(closed.normal_stress.max())
    for row, (cycle, ends) in enumerate(ranges.iterrows(), start=1):
        first = leading(ends)
        widths = [[first - ends.low], [ends.high - first]]
        axes.errorbar(
            first, largest * (1.0 + 0.03 * row), xerr=widths,
            fmt="o", ms=4, capsize=3, color=f"C{cycle - 1}", label=f"cycle {cycle}, range",
        )  # fmt: skip


def draw_curves(axes: Axes, closed: xr.Dataset, since: str = "touch", of: str = NET) -> None:
    """Draw stress against closure on axes, each cycle in its colour, unloading dashed.

    Parameters
    ----------
    axes : Axes
    closed : Dataset
        As from `jointclosure.simulate`.
    since : {"touch", "seating", "cycle"}
        Zero of closure: first touch, the seating stress on each cycle's loading, or the start of
        each cycle.
    of : {"closure_net", "closure"}
        Net closure, or gross, as for `jointclosure.joint.history.read_along`.
    """
    cycle, branch = closed.cycle.values, closed.branch.values
    values, numbers = read_along(closed, of), sorted(set(cycle.tolist()))
    for number in numbers:
        zero = _zero_of(closed, number, since, of)
        for name, style in BRANCH_LINES.items():
            here = branch_of(cycle, branch, number, name)
            closure, stress = values[here], closed.normal_stress.values[here]
            if since == "seating":
                seat = seat_of(closed, number, name, of)
                closure, stress = _from_seating(closed, name, seat, closure, stress)
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
    kind = "net" if of == NET else "gross"
    axes.set(xlabel=f"{kind} closure from {words[since]} (mm)")
    axes.set(ylabel="normal stress (MPa)", ylim=0.0)
    if len(numbers) <= 5:
        axes.legend(frameon=False)


def draw_stiffness(axes: Axes, closed: xr.Dataset) -> None:
    """Draw net normal stiffness by chords against stress; chords of the landing as open circles."""
    table = stiffness_table(closed)
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        colour, order = f"C{cycle - 1}", above(cycle, branch)
        for landing, part in rows.groupby("landing"):
            label = "landing on the maximum" if landing else f"cycle {cycle}, {branch}"
            axes.plot(
                part.normal_stress_MPa, part.normal_stiffness_net_MPa_per_mm,
                "" if landing else BRANCH_LINES[branch], label=label, color=colour, zorder=order,
                marker="o", ms=3, mfc="none" if landing else colour,
            )  # fmt: skip
    axes.set(
        xlabel="normal stress (MPa)", ylabel="net normal stiffness (MPa/mm)", yscale="log", xlim=0.0
    )
    decimal_ticks(axes.yaxis)
    axes.legend(frameon=False, fontsize=9)


def _zero_of(closed: xr.Dataset, cycle: int, since: str, of: str) -> float:
    """Return the closure [m] from which closures of a cycle count."""
    if since == "seating":
        return seat_of(closed, cycle, LOADING, of)
    if since == "cycle":
        here = branch_of(closed.cycle.values, closed.branch.values, cycle, LOADING)
        return float(read_along(closed, of)[here[0]])
    return 0.0


def _from_seating(
    closed: xr.Dataset, branch: str, seat: float, closure: np.ndarray, stress: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a branch above the seating stress, including its point at that stress."""
    seating = float(closed.attrs["seating_stress_Pa"])
    above_it = stress > seating
    end = 0 if branch == LOADING else int(above_it.sum())
    return (
        np.insert(closure[above_it], end, seat),
        np.insert(stress[above_it], end, seating),
    )
