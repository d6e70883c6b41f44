"""Figures of two registered scanned walls."""

import numpy as np
import seaborn as sns
from matplotlib.figure import Figure

from jointclosure.engine.budget import ALL, CLOSURE_NET, NUMBERS, TITLES, Budget
from jointclosure.plotting.style import decimal_ticks, styled, subplots
from jointclosure.walls.registration import CLEAR, RegisteredPair


@styled
def pair_figure(pair: RegisteredPair, title: str) -> Figure:
    """Draw both walls, aperture and section at first touch, correlation, and orientations.

    Correlation and orientations are left out where one wall is flat.

    Parameters
    ----------
    pair : RegisteredPair
    title : str
    """
    columns = 3 if pair.fits else 2
    figure, grid = subplots(2, columns, figsize=(4.5 * columns, 8.2))
    panels = grid.ravel()
    # z upwards on both, so that mated walls look equal
    _draw_wall(panels[0], -pair.upper, pair, "upper wall, seen from above")
    _draw_wall(panels[1], pair.lower, pair, "lower wall, seen from above")
    _draw_aperture(panels[2], pair)
    _draw_section(panels[3], pair)
    if pair.fits:
        _draw_mating(panels[4], pair)
        _draw_orientations(panels[5], pair)
    figure.suptitle(title, parse_math=False)  # a file's name is not a formula
    for axes in panels[3:]:
        sns.despine(ax=axes)
    return figure


@styled
def range_figure(budget: Budget, title: str) -> Figure:
    """Draw the net closure of the first and the last cycle, and how far each source moves it.

    Parameters
    ----------
    budget : Budget
    title : str
    """
    ranges = budget.ranges.xs(CLOSURE_NET, level="quantity")
    cycles = list(dict.fromkeys(ranges.index[[0, -1]]))
    figure, panels = subplots(1, len(cycles), figsize=(5.2 * len(cycles), 3.6), squeeze=False)
    for axes, cycle in zip(panels[0], cycles, strict=True):
        row, results = ranges.loc[cycle], budget.results[budget.results.cycle == cycle]
        shares = row.drop(NUMBERS).astype(float).dropna().sort_values()
        for place, name in enumerate(shares.index):
            values = results.loc[results.source == name, CLOSURE_NET].to_numpy()
            axes.plot([row.best, *values], [place] * (1 + values.size), "-", color="0.6")
            axes.plot(values, [place] * values.size, "o", color="C0")
        drawn = results.loc[results.source == ALL, CLOSURE_NET].to_numpy()
        axes.plot([row.low, row.high], [len(shares)] * 2, "-", color="C1", lw=3)
        axes.plot(drawn, [len(shares) + 0.35] * drawn.size, "|", color="C1", ms=5)
        axes.plot(row["median"], len(shares), "|", color="white", ms=6, mew=1.5)
        axes.plot(row.best, len(shares), "o", color="C1")
        axes.axvline(row.best, color="0.8", lw=0.8, zorder=0)
        labels = [f"{TITLES[name]} ({100.0 * share:.0f} %)" for name, share in shares.items()]
        axes.set_yticks(range(len(shares) + 1), [*labels, "all together, 9 in 10"])
        axes.set(xlabel=f"net closure since seating, cycle {cycle} (mm)")
    figure.suptitle(title, parse_math=False)
    sns.despine(figure)
    return figure


def map_extent(pair_shape: tuple[int, int], spacing: float) -> tuple[float, float, float, float]:
    """Return edges (left, right, bottom, top) [mm] of a map of cells (y, x)."""
    ny, nx = pair_shape
    return 0.0, 1e3 * nx * spacing, 0.0, 1e3 * ny * spacing


def _place(pair: RegisteredPair) -> tuple[float, float]:
    """Return x and y of the middle of the cell of first touch [mm]."""
    y, x = pair.first_touch
    return 1e3 * (x + 0.5) * pair.spacing, 1e3 * (y + 0.5) * pair.spacing


def _shrunk(wall: np.ndarray) -> float:
    """Return the length of a colour bar that is as high as the map of a wall (y, x)."""
    ny, nx = wall.shape
    return 0.85 * min(ny / nx, 1.0)


def _draw_wall(axes, heights: np.ndarray, pair: RegisteredPair, title: str) -> None:
    reach = 1e3 * max(np.abs(pair.upper).max(), np.abs(pair.lower).max())
    image = axes.imshow(
        1e3 * heights, origin="lower", extent=map_extent(heights.shape, pair.spacing), cmap="vlag",
        vmin=-reach, vmax=reach,
    )  # fmt: skip
    axes.figure.colorbar(image, ax=axes, label="height (mm)", shrink=_shrunk(heights))
    axes.set(title=title, xlabel="x (mm)", ylabel="y (mm)")


def _draw_aperture(axes, pair: RegisteredPair) -> None:
    image = axes.imshow(
        1e3 * pair.aperture, origin="lower", extent=map_extent(pair.aperture.shape, pair.spacing),
        cmap="viridis", vmin=0.0, vmax=1e3 * np.percentile(pair.aperture, 99.0),
    )  # fmt: skip
    axes.figure.colorbar(
        image, ax=axes, label="aperture (mm)", shrink=_shrunk(pair.aperture), extend="max"
    )
    x, y = _place(pair)
    axes.plot(x, y, "o", ms=11, mfc="none", mec="red", mew=1.8)
    axes.set(title="aperture at first touch (in the circle)", xlabel="x (mm)", ylabel="y (mm)")


def _draw_section(axes, pair: RegisteredPair) -> None:
    """Draw both walls along x through first touch, with the gap between them shaded."""
    draw_section(axes, pair.upper, pair.lower, pair.spacing)
    axes.legend(frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.16))


def draw_section(axes, upper: np.ndarray, lower: np.ndarray, spacing: float) -> None:
    """Draw walls (y, x) [m] at first touch, along x through it, with the gap shaded."""
    aperture = float((upper + lower).max()) - upper - lower
    row, column = np.unravel_index(int(aperture.argmin()), aperture.shape)
    below = 1e3 * lower[row]
    over = below + 1e3 * aperture[row]
    x = 1e3 * (np.arange(below.size) + 0.5) * spacing
    axes.fill_between(x, below, over, color="0.85", lw=0.0)
    axes.plot(x, over, color="C0", lw=1.1, label="upper wall")
    axes.plot(x, below, color="C1", lw=1.1, label="lower wall")
    axes.plot(x[column], below[column], "o", ms=9, mfc="none", mec="red", mew=1.6)
    y = 1e3 * (row + 0.5) * spacing
    axes.set(title=f"section at y = {y:.3g} mm", xlabel="x (mm)", ylabel="height (mm)")


def _draw_mating(axes, pair: RegisteredPair) -> None:
    """Draw correlation over wavelength, with one standard error, and the mismatch wavelength."""
    mating = pair.mating
    error = (1.0 - mating.correlation**2) / np.sqrt(mating.modes)
    wavelengths = 1e3 * mating.wavelengths
    axes.axhline(0.0, color="0.7", lw=0.8)
    axes.errorbar(
        wavelengths, mating.correlation, error, fmt="o-", color="C0", ms=4, lw=1.1, capsize=2
    )
    limit = pair.mismatch.wavelength
    if 0.0 < limit < np.inf:
        ends = np.clip(1e3 * np.array(pair.mismatch[1:]), wavelengths[-1], wavelengths[0])
        axes.axvspan(*ends, color="0.9", lw=0.0)
        axes.axvline(1e3 * limit, color="0.3", lw=1.0, ls="--")
        axes.annotate(
            f" {1e3 * limit:.3g} mm", (1e3 * limit, 0.02), xycoords=("data", "axes fraction"),
            fontsize=9,
        )  # fmt: skip
    axes.set(
        xscale="log", ylim=(min(-0.3, 1.1 * (mating.correlation - error).min()), 1.05),
        title="correlation of the walls", xlabel="wavelength (mm)",
        ylabel="correlation (1: mated, 0: independent)",
    )  # fmt: skip
    decimal_ticks(axes.xaxis)


def _draw_orientations(axes, pair: RegisteredPair) -> None:
    """Draw the correlation of slopes in each orientation, with the one used in colour."""
    fits = pair.fits[::-1]
    colours = ["C0" if fit.orientation == pair.orientation else "0.75" for fit in fits]
    names = [fit.orientation.replace("_", " ") for fit in fits]
    axes.barh(names, [fit.correlation for fit in fits], color=colours)
    second = pair.fits[1].correlation
    if second > 0.0:
        axes.axvline(CLEAR * second, color="0.3", lw=1.0, ls="--")
    axes.set(
        title="orientation of the upper scan",
        xlabel=f"correlation of slopes (line: {CLEAR:g} times the second)",
    )
