"""Figures of scanned walls."""

import numpy as np
import seaborn as sns
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from jointclosure.plotting.style import decimal_ticks, styled, subplots
from jointclosure.walls.measures import Increments


@styled
def roughness_figure(
    heights: np.ndarray, spacing: float, increments: Increments, title: str
) -> Figure:
    """Draw a wall (y, x) [m]: its map, profiles, and rms height differences over distance.

    Parameters
    ----------
    heights : array (y, x)
        Plane-detrended heights [m]; NaN where missing, drawn white.
    spacing : float
        Grid spacing [m].
    increments : Increments
        As from `jointclosure.walls.measures.increments`.
    title : str
    """
    figure, panels = subplots(1, 3, figsize=(13.0, 4.3), width_ratios=(1.1, 1.0, 1.0))
    ny, nx = heights.shape
    size = (1e3 * nx * spacing, 1e3 * ny * spacing)
    reach = 1e3 * np.nanmax(np.abs(heights))
    image = panels[0].imshow(
        1e3 * heights, origin="lower", extent=(0.0, size[0], 0.0, size[1]), cmap="vlag",
        vmin=-reach, vmax=reach,
    )  # fmt: skip
    figure.colorbar(image, ax=panels[0], label="height (mm)", shrink=0.85)
    panels[0].set(title="heights, mean plane removed", xlabel="x (mm)", ylabel="y (mm)")
    _draw_profiles(panels[1], heights, spacing)
    _draw_increments(panels[2], increments)
    figure.suptitle(title, parse_math=False)  # a file's name is not a formula
    sns.despine(figure)
    layout = figure.get_layout_engine()
    if isinstance(layout, ConstrainedLayoutEngine):
        layout.set(wspace=0.06)
    return figure


def _draw_profiles(axes, heights: np.ndarray, spacing: float) -> None:
    """Draw three profiles along each axis, shifted, at the scale of the heights."""
    gap = 4e3 * np.nanstd(heights)
    for number, part in enumerate((0.25, 0.5, 0.75)):
        for axis, colour in (("x", "C0"), ("y", "C1")):
            along = heights if axis == "x" else heights.T
            profile = 1e3 * along[int(part * len(along))]
            offset = gap * (number + (3 if axis == "y" else 0))
            place = 1e3 * spacing * np.arange(profile.size)
            axes.plot(place, profile + offset, color=colour, lw=0.9)
    for axis, colour in (("x", "C0"), ("y", "C1")):
        axes.plot([], [], color=colour, label=f"along {axis}, at 1/4, 1/2, 3/4")
    axes.set(title="profiles", xlabel="distance (mm)", ylabel="height, shifted (mm)")
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.18), fontsize=8)


def _draw_increments(axes, increments: Increments) -> None:
    distances = 1e3 * increments.distances
    for values, marker, colour, label in (
        (increments.x, "o", "C0", "of two heights along x"),
        (increments.y, "o", "C1", "of two heights along y"),
        (increments.second_x, "^", "C0", "second differences along x"),
        (increments.second_y, "^", "C1", "second differences along y"),
    ):
        axes.loglog(distances, 1e3 * values, marker, color=colour, ms=4, mfc="none", label=label)
    both = 1e3 * np.sqrt(0.5 * (increments.second_x**2 + increments.second_y**2))
    slope, offset = np.polyfit(np.log(distances[1:]), np.log(both[1:]), 1)
    line = np.exp(offset) * distances[1:] ** slope
    axes.loglog(distances[1:], line, color="0.3", lw=1.2, label=f"H = {slope:.2f}")
    for axis in (axes.xaxis, axes.yaxis):
        decimal_ticks(axis)
    axes.set(title="height differences over distance", xlabel="distance (mm)", ylabel="rms (mm)")
    axes.legend(frameon=False, fontsize=8)
