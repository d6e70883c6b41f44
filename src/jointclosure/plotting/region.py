"""Figure of the region of constants that are compatible with a measured curve."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from jointclosure.measured.calibration import CONFIDENCE
from jointclosure.measured.region import MECHANISMS, NEITHER, Compared, Region
from jointclosure.plotting.joint import draw_measured
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
        1, 1 + len(mechanisms), figsize=(5.6 + 3.9 * len(mechanisms), 6.4),
        width_ratios=[1.4, *[1.0] * len(mechanisms)],
    )  # fmt: skip
    nearest = max(region.mechanisms, key=region.p_value)
    closures = region.closures[region.place(nearest)]
    draw_measured(panels[0], region, closures, region.stresses, "of the nearest")
    panels[0].set_title(f"nearest: {nearest}")
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
        axes.plot(number, strength, "r+", ms=10, mew=1.8, clip_on=False, zorder=5)
        none = "" if region.compatible(name) else ": none is compatible"
        axes.set(title=f"{name}{none}", ylabel="compressive strength (MPa)")
    bar = figure.colorbar(mesh, ax=list(panels[1:]), extend="min")
    bar.set_label("share of such joints that lie as far off (+: nearest)")
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
