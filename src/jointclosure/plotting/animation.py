"""Animation of a joint being crushed: a section, broken volume, and the curve."""

import numpy as np
import seaborn as sns
import xarray as xr
from matplotlib.animation import FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg

from jointclosure.inputs import InputError
from jointclosure.joint.curves import spacing_of
from jointclosure.joint.history import GROSS
from jointclosure.plotting.joint import draw_curves
from jointclosure.plotting.scanned_joint import map_extent
from jointclosure.plotting.snapshots import change_of_height, reach_of
from jointclosure.plotting.style import StyledFigure, styled

STRESSES = 16
"""Number of snapshots of a branch for a smooth animation."""
_PAUSE = 300
"""Duration of a frame in milliseconds."""


def animated_stresses(largest: float) -> list[float]:
    """Return stresses [Pa] at which an animation up to a largest stress [Pa] has snapshots.

    They are spaced quadratically, because joints close fast at low stress.
    """
    return [float(largest * share**2) for share in np.linspace(0.0, 1.0, STRESSES + 1)]


@styled
def crushing_animation(closed: xr.Dataset, title: str) -> FuncAnimation:
    """Animate the walls along x, the change of their heights, and the curve up to each snapshot.

    Parameters
    ----------
    closed : Dataset
        As from `jointclosure.simulate` with ``snapshots``, such as `animated_stresses`.
    title : str

    Returns
    -------
    FuncAnimation
        Write it by ``save("joint.gif", writer="pillow")``, or by `jointclosure.storage.figures`.

    Raises
    ------
    InputError
        If the joint has no snapshots.
    """
    if not closed.sizes.get("snapshot"):
        raise InputError("an animation needs snapshots: simulate(..., snapshots=[...])")
    figure = StyledFigure(figsize=(8.0, 6.0), layout="constrained")
    panels = figure.subplot_mosaic([["curve", "map"], ["walls", "walls"]])
    FigureCanvasAgg(figure)
    draws = (
        _curve(panels["curve"], closed),
        _map(panels["map"], closed),
        _walls(panels["walls"], closed),
    )
    figure.suptitle(title, parse_math=False)
    for name in ("curve", "walls"):
        sns.despine(ax=panels[name])

    def show(frame: int) -> list:
        for draw in draws:
            draw(frame)
        return []

    show(0)
    return FuncAnimation(figure, show, frames=closed.sizes["snapshot"], interval=_PAUSE)


def _curve(axes, closed: xr.Dataset):
    closure, stress = 1e3 * closed.closure.values, 1e-6 * closed.normal_stress.values
    draw_curves(axes, closed, of=GROSS)
    (place,) = axes.plot([], [], "o", color="black", ms=7, zorder=5)

    def draw(frame: int) -> None:
        at = closed.isel(snapshot=frame)
        step = int(at.snapshot_step)
        place.set_data([closure[step]], [stress[step]])
        axes.set_title(
            f"cycle {int(at.snapshot_cycle)}, {at.snapshot_branch.item()}: {stress[step]:.3g} MPa"
        )

    return draw


def _map(axes, closed: xr.Dataset):
    """Draw the change of height of both walls, with contacts in black."""
    change = 1e3 * change_of_height(closed)
    reach, extent = reach_of(np.abs(change)), map_extent(change.shape[1:], spacing_of(closed))
    drawn = {"origin": "lower", "interpolation": "nearest", "extent": extent}
    image = axes.imshow(change[0], cmap="vlag_r", vmin=-reach, vmax=reach, **drawn)
    none = np.ma.masked_all(change[0].shape)
    contacts = axes.imshow(none, cmap="gray", vmin=0.0, vmax=1.0, **drawn)
    label = "change of height (mm)"
    axes.figure.colorbar(image, ax=axes, label=label, extend="both", shrink=0.85)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")

    def draw(frame: int) -> None:
        touching = closed.snapshot_force.values[frame] > 0.0
        image.set_data(change[frame])
        contacts.set_data(np.ma.masked_where(~touching, np.zeros(touching.shape)))
        axes.set_title(f"contacts black: {100.0 * touching.mean():.2g} % of the cells")

    return draw


def _walls(axes, closed: xr.Dataset):
    """Draw both walls along the row that loses most, the upper one at its gap to the lower one."""
    row = int(np.abs(change_of_height(closed)[-1]).sum(axis=1).argmax())
    lower = 1e3 * closed.snapshot_lower.values[:, row]
    upper = lower + 1e3 * np.maximum(closed.snapshot_gap.values[:, row], 0.0)
    pristine = 1e3 * closed.lower_first.values[row]
    x = 1e3 * closed.x.values
    low, high = min(lower.min(), pristine.min()), upper.max()
    margin = 0.1 * (high - low)
    axes.set(
        xlim=(x[0], x[-1]), ylim=(low - margin, high + margin), xlabel="x (mm)",
        ylabel="height (mm)",
    )  # fmt: skip
    axes.plot(x, pristine, ":", color="0.3", lw=1.0, zorder=4)
    parts: list = []

    def draw(frame: int) -> None:
        while parts:
            parts.pop().remove()
        parts.append(axes.fill_between(x, lower[frame], low - margin, color="C1", alpha=0.55))
        parts.append(axes.fill_between(x, upper[frame], high + margin, color="C0", alpha=0.55))
        force = closed.snapshot_force.values[frame, row] > 0.0
        parts.extend(axes.plot(x[force], lower[frame][force], "o", color="black", ms=4))

    where = 1e3 * float(closed.y.values[row])
    axes.set_title(f"walls at y = {where:.3g} mm; dotted: lower wall before; dots: contacts")
    return draw
