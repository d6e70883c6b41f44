"""Figures of scanned walls."""

from typing import Any

import numpy as np
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from jointclosure.plotting.style import decimal_ticks, styled, subplots
from jointclosure.statistics.number_texts import percent
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.rotation_search import CLEAR
from jointclosure.walls.wall_roughness import increments

FIRST_TOUCH: dict[str, Any] = {
    "mfc": "none",
    "mec": "w",
    "mew": 1.6,
    "path_effects": [withStroke(linewidth=4.0, foreground="k")],
}
"""Circle about the first contact on a map: white in black, which is seen on all colours."""

HOLES = "0.4"
"""Colour of cells without a height, a grey that no map of heights or apertures has."""


def draw_field(axes: Axes, field: np.ndarray, spacing: float, **style: Any) -> AxesImage:
    """Draw a map of a field (y, x) on a grid of a spacing [m]; NaN have the colour of holes.

    ``style`` are arguments of matplotlib's ``imshow``.
    """
    axes.set(xlabel="x (mm)", ylabel="y (mm)", facecolor=HOLES)
    height, width = (1e3 * cells * spacing for cells in field.shape)
    return axes.imshow(field, origin="lower", extent=(0.0, width, 0.0, height), **style)


def draw_heights(axes: Axes, heights: np.ndarray, spacing: float, reach: float) -> AxesImage:
    """Draw a map of heights (y, x) [m], in mm, with colours from minus to plus ``reach`` [m]."""
    limits = {"vmin": -1e3 * reach, "vmax": 1e3 * reach}
    return draw_field(axes, 1e3 * heights, spacing, cmap="vlag", **limits)


@styled
def pair_figure(pair: RegisteredPair, title: str) -> Figure:
    """Draw two registered walls: maps of their heights, aperture and section at first touch.

    Unless one wall is flat, the correlation of the walls over wavelength and the fits of the
    orientations are drawn too.
    """
    columns = 3 if pair.fits else 2
    figure, grid = subplots(2, columns, figsize=(4.5 * columns, 8.2), title=title)
    panels = grid.ravel()
    reach = max(np.abs(pair.upper).max(), np.abs(pair.lower).max())
    upper, lower, aperture = (
        np.where(pair.holes, np.nan, field) for field in (pair.upper, pair.lower, pair.aperture)
    )
    walls = {"upper": -upper, "lower": lower}  # z upwards: mated walls look equal
    for axes, (side, heights) in zip(panels, walls.items(), strict=False):
        _add_bar(axes, draw_heights(axes, heights, pair.spacing, reach), "height (mm)")
        axes.set_title(f"{side} wall, seen from above")
    limits = {"vmin": 0.0, "vmax": 1e3 * np.nanpercentile(aperture, 99.0)}
    image = draw_field(panels[2], 1e3 * aperture, pair.spacing, cmap="viridis", **limits)
    _add_bar(panels[2], image, "aperture (mm)", "max")
    y, x = (1e3 * (cell + 0.5) * pair.spacing for cell in pair.first_touch_cell)
    panels[2].plot(x, y, "o", ms=11, **FIRST_TOUCH)
    panels[2].set_title("aperture at first touch (in the circle)")
    draw_section(panels[3], pair.upper, pair.lower, pair.spacing, pair.holes)
    panels[3].legend(frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.16))
    if pair.fits:
        _draw_mating(panels[4], pair)
        fits = pair.fits[::-1]
        axes = panels[5]
        colours = ["C0" if fit.orientation == pair.orientation else "0.75" for fit in fits]
        names = [fit.orientation.replace("_", " ") for fit in fits]
        axes.barh(names, [fit.correlation for fit in fits], color=colours)
        if (second := pair.fits[1].correlation) > 0.0:
            axes.axvline(CLEAR * second, color="0.3", lw=1.0, ls="--")
        axes.set(title="orientation of the upper scan")
        needed = f"line: {CLEAR:g} times the second, needed to be clear"
        axes.set(xlabel=f"correlation of slopes\n({needed})")
    for axes in panels[3:]:
        sns.despine(ax=axes)
    _name_holes(figure, pair.holes, "hole of a scan, taken out of contact")
    return figure


def _name_holes(figure: Figure, holes: np.ndarray, words: str) -> None:
    """Add a legend for the colour of holes (y, x), with their share of the cells, if any."""
    if holes.any():
        patch = Patch(facecolor=HOLES, label=f"{words} ({percent(holes.mean())} of the cells)")
        figure.legend(handles=[patch], loc="outside lower center", frameon=False)


def _add_bar(axes: Axes, image: AxesImage, label: str, extend: str = "neither") -> None:
    """Add a colour bar that is as high as the map."""
    ny, nx = image.get_size()
    axes.figure.colorbar(
        image, ax=axes, label=label, shrink=0.85 * min(ny / nx, 1.0), extend=extend
    )


def draw_section(
    axes, upper: np.ndarray, lower: np.ndarray, spacing: float, holes: np.ndarray | None = None
) -> None:
    """Draw a section of two walls (y, x) [m] at first touch, with the gap shaded.

    The section is along x through the first contact. In cells of ``holes`` (y, x) nothing is drawn.
    """
    aperture = float((upper + lower).max()) - upper - lower
    row, column = np.unravel_index(int(aperture.argmin()), aperture.shape)
    below = 1e3 * lower[row]
    over = below + 1e3 * aperture[row]
    if holes is not None:
        below, over = (np.where(holes[row], np.nan, wall) for wall in (below, over))
    x = 1e3 * (np.arange(below.size) + 0.5) * spacing
    axes.fill_between(x, below, over, color="0.85", lw=0.0)
    axes.plot(x, over, color="C0", lw=1.1, label="upper wall")
    axes.plot(x, below, color="C1", lw=1.1, label="lower wall")
    touch = {"ms": 10, "mfc": "none", "mec": "k", "mew": 1.6, "label": "first touch"}
    axes.plot(x[column], below[column], "o", **touch)
    y = 1e3 * (row + 0.5) * spacing
    axes.set(title=f"section at y = {y:.3g} mm", xlabel="x (mm)", ylabel="height (mm)")


def _draw_mating(axes, pair: RegisteredPair) -> None:
    """Draw the correlation of two walls over wavelength [mm], and the mismatch wavelength.

    The bars are one standard error. The interval of the mismatch wavelength is shaded.
    """
    mating = pair.mating
    error = (1.0 - mating.correlation**2) / np.sqrt(mating.modes)
    wavelengths = 1e3 * mating.wavelengths
    axes.axhline(0.0, color="0.7", lw=0.8)
    line = {"fmt": "o-", "color": "C0", "ms": 4, "lw": 1.1, "capsize": 2}
    axes.errorbar(wavelengths, mating.correlation, error, **line)
    limit = pair.mismatch.wavelength
    if 0.0 < limit < np.inf:
        ends = np.clip(1e3 * np.array(pair.mismatch[1:]), wavelengths[-1], wavelengths[0])
        axes.axvspan(*ends, color="0.9", lw=0.0)
        axes.axvline(1e3 * limit, color="0.3", lw=1.0, ls="--")
        at = (1e3 * limit, 0.02)
        words = f" {1e3 * limit:.3g} mm"
        axes.annotate(words, at, xycoords=("data", "axes fraction"), fontsize=9)
    axes.set(xscale="log", ylim=(min(-0.3, 1.1 * (mating.correlation - error).min()), 1.05))
    axes.set(title="correlation of the walls", xlabel="wavelength (mm)")
    axes.set(ylabel="correlation (1: mated, 0: independent)")
    decimal_ticks(axes.xaxis)


@styled
def roughness_figure(heights: np.ndarray, spacing: float, title: str) -> Figure:
    """Draw the roughness of a wall (y, x) [m]: map, profiles, and rms differences over distance."""
    wide: dict = {"layout": ConstrainedLayoutEngine(wspace=0.06), "width_ratios": (1.1, 1.0, 1.0)}
    figure, panels = subplots(1, 3, figsize=(13.0, 4.3), title=title, **wide)
    image = draw_heights(panels[0], heights, spacing, np.nanmax(np.abs(heights)))
    figure.colorbar(image, ax=panels[0], label="height (mm)", shrink=0.85)
    panels[0].set_title("heights, mean plane removed")
    gap = 4e3 * np.nanstd(heights)
    colours = {"x": "C0", "y": "C1"}
    for number, part in enumerate((0.25, 0.5, 0.75)):  # at the scale of the heights
        for colour, along, first in (("C0", heights, 0), ("C1", heights.T, 3)):
            profile = 1e3 * along[int(part * len(along))]
            place = 1e3 * spacing * np.arange(profile.size)
            panels[1].plot(place, profile + gap * (number + first), color=colour, lw=0.9)
    for axis, colour in colours.items():
        panels[1].plot([], [], color=colour, label=f"along {axis}, at 1/4, 1/2, 3/4")
    panels[1].set(title="profiles", xlabel="distance (mm)", ylabel="height, shifted (mm)")
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.18)}
    panels[1].legend(frameon=False, fontsize=8, **below)
    _draw_increments(panels[2], *increments(heights, spacing))
    sns.despine(figure)
    _name_holes(figure, np.isnan(heights), "no height")
    return figure


def profile_figure(heights: np.ndarray, spacing: float, title: str) -> Figure:
    """Draw a levelled profile of heights (n,) [m]; heights have a larger scale than distances."""
    figure, axes = subplots(1, 1, figsize=(9.0, 3.0), title=title)
    place = 1e3 * spacing * np.arange(heights.size)
    axes.plot(place, 1e3 * heights, color="C0", lw=1.0)
    axes.set(xlabel="distance along the mean line (mm)", ylabel="height (mm)")
    sns.despine(figure)
    return figure


def _draw_increments(axes, distances: np.ndarray, rms: dict[str, np.ndarray]) -> None:
    """Draw the rms height differences [m] over distances [m], both from `increments`.

    A power law is fitted to the second differences; its exponent H is in the legend.
    """
    distances = 1e3 * distances
    kinds = {"": ("o", "of two heights"), "second_": ("^", "second differences")}
    for prefix, (marker, words) in kinds.items():
        for axis, colour in (("x", "C0"), ("y", "C1")):
            style = {"color": colour, "ms": 4, "mfc": "none", "label": f"{words} along {axis}"}
            axes.loglog(distances, 1e3 * rms[prefix + axis], marker, **style)
    both = 1e3 * np.sqrt(0.5 * (rms["second_x"] ** 2 + rms["second_y"] ** 2))
    slope, offset = np.polyfit(np.log(distances[1:]), np.log(both[1:]), 1)
    line = np.exp(offset) * distances[1:] ** slope
    axes.loglog(distances[1:], line, color="0.3", lw=1.2, label=f"H = {slope:.2f}")
    decimal_ticks(axes.xaxis, axes.yaxis)
    axes.set(title="height differences over distance", xlabel="distance (mm)", ylabel="rms (mm)")
    axes.legend(frameon=False, fontsize=8)
