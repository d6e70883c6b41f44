"""Figure of the region of constants that are compatible with a measured curve."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from jointclosure.joint.protocol import LOADING
from jointclosure.measured.calibration import CONFIDENCE
from jointclosure.measured.region import MECHANISMS, NEITHER, Compared, Region
from jointclosure.plotting.style import decimal_ticks, styled, subplots

_LEAST = 1e-4
"""Smallest p-value of the scale of colours."""


@styled
def region_figure(region: Region, title: str) -> Figure:
    """Draw p-values by strength and the constant of each mechanism, beside the nearest joints.

    The largest p-value of all mismatch wavelengths counts; the line surrounds what is compatible.
    """
    shown = [one for one in MECHANISMS if one.title in region.mechanisms]
    mechanisms = [one.title for one in shown] or [NEITHER]
    figure, panels = subplots(
        1, 1 + len(mechanisms), figsize=(5.6 + 3.9 * len(mechanisms), 5.0),
        width_ratios=[1.4, *[1.0] * len(mechanisms)],
    )  # fmt: skip
    nearest = max(region.mechanisms, key=region.p_value)
    _draw_curve(panels[0], region, nearest)
    for axes, name in zip(panels[1:], mechanisms, strict=True):
        kinds = region.of(name)
        mesh = _draw_p_values(axes, kinds)
        about = next((one for one in shown if one.title == name), None)
        if about is not None:
            constants = [getattr(one.later, about.field) for one in kinds]
            axes.set_xticks(range(len(kinds)), [f"{constant:g}" for constant in constants])
            unit = "" if about.unit == "1" else f" ({about.unit})"
            axes.set_xlabel(f"{about.constant}{unit}")
        else:
            axes.set_xticks([])
        number, _, j = region.nearest(name)
        strength = 1e-6 * kinds[number].likelihood.strengths[j]
        axes.plot(number, strength, "k+", ms=9, label="nearest")
        none = "" if region.compatible(name) else ": none is compatible"
        axes.set(title=f"{name}{none}", ylabel="compressive strength (MPa)")
        axes.legend(frameon=False, fontsize=8, loc="upper right")
    bar = figure.colorbar(mesh, ax=list(panels[1:]), extend="min")
    bar.set_label("probability that such a joint is as far from the mean")
    bar.ax.axhline(1.0 - CONFIDENCE, color="k")
    figure.suptitle(title, parse_math=False)
    return figure


def _draw_p_values(axes: Axes, kinds: list[Compared]):
    """Draw p-values over the constants (columns) and strengths, and the end of the region."""
    p_values = np.stack([one.likelihood.p_values.max(axis=0) for one in kinds], axis=1)
    strengths = 1e-6 * kinds[0].likelihood.strengths
    half = np.sqrt(strengths[1] / strengths[0])
    rows = np.append(strengths / half, strengths[-1] * half)
    columns = np.arange(len(kinds) + 1) - 0.5
    mesh = axes.pcolormesh(
        columns, rows, np.maximum(p_values, _LEAST), norm=LogNorm(_LEAST, 1.0), cmap="viridis",
        rasterized=True,
    )  # fmt: skip
    within = (p_values >= 1.0 - CONFIDENCE).astype(float)
    for place, column in enumerate(within.T):
        for low, high in _runs(column):
            corners = columns[[place, place + 1, place + 1, place, place]]
            axes.plot(corners, rows[[low, low, high, high, low]], "w-", lw=1.4)
    axes.set(yscale="log", ylim=(rows[0], rows[-1]))
    decimal_ticks(axes.yaxis)
    return mesh


def _runs(within: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last edge of each run of ones."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0.0], within, [0.0]])))
    return list(zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True))


def _draw_curve(axes: Axes, region: Region, mechanism: str) -> None:
    """Draw the measured curve since seating on the joints nearest to it, by cycle."""
    closures, stresses = 1e3 * region.nearest_closures(mechanism), 1e-6 * region.stresses
    for cycle in range(1, region.measured.cycles + 1):
        colour = f"C{cycle - 1}"
        for branch in (0, 1) if cycle in region.measured.unloaded else (0,):
            low, high = np.nanpercentile(closures[:, cycle - 1, branch], (5.0, 95.0), axis=0)
            label = f"cycle {cycle}: nine in ten of the nearest joints" if branch == 0 else None
            axes.fill_betweenx(stresses, low, high, color=colour, alpha=0.25, lw=0.0, label=label)
        seating = region.measured.seating
        for branch, stress, closure in region.curve.since_seating(cycle, seating):
            if branch == LOADING:
                stress, closure = np.append(seating, stress), np.append(0.0, closure)
            axes.plot(1e3 * closure, 1e-6 * stress, "o-", ms=3, lw=1.2, color=colour)
        axes.plot([], [], "o-", ms=3, color=colour, label=f"cycle {cycle}: measured")
    axes.set(xlabel="net closure since seating of the cycle (mm)", ylabel="normal stress (MPa)")
    axes.set(xlim=(min(0.0, axes.get_xlim()[0]), None), title=f"nearest: {mechanism}")
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.11))
