"""Figures of a joint at stresses: aperture, contact forces, damage; and an animation of them."""

import math
from typing import Any

import numpy as np
import seaborn as sns
import xarray as xr
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from jointclosure.inputs import InputError
from jointclosure.joint.history import GROSS, history_of
from jointclosure.plotting.joint import draw_curves
from jointclosure.plotting.style import panel_grid, styled, subplots
from jointclosure.plotting.walls import draw_field

STRESSES = 16  # snapshots of a branch for a smooth animation
CONTACTS = "#f0e442"  # yellow; it is lighter than all colours of apertures, so that all see it
_APERTURES = ListedColormap(sns.color_palette("mako", 256)[50:170])  # dark blue to blue-green
_PAUSE = 300  # duration of a frame in milliseconds
_ROWS = 3  # of full size; with n snapshots each map has sqrt(n / 3) columns


@styled
def snapshot_figure(closed: xr.Dataset, title: str) -> Figure:
    """Draw three maps of each snapshot of a joint.

    They are the aperture with contacts, the stress of cells, and the change of the walls' heights.
    """
    number = closed.sizes["snapshot"]
    blocks = math.ceil(math.sqrt(number / _ROWS))
    rows = math.ceil(number / blocks)
    size = max(3.5 / blocks, 2.2)
    figure, panels = panel_grid(
        rows, 3 * blocks, (size, size - 0.1), (0.0, 1.3), title=title, sharex=True, sharey=True
    )
    titles = [describe_state(closed.isel(snapshot=k)) for k in range(number)]
    for group, (name, about) in enumerate(MAPS.items()):
        columns = panels[:, group * blocks : (group + 1) * blocks]
        for k, axes in enumerate(columns.T.flat):
            if k >= number:
                axes.set_axis_off()
                continue
            image = draw_map(axes, closed, name, k)
            words = [titles[k][0]] * (blocks > 1 and group > 0) + [titles[k][group]]
            axes.set_title("\n".join(words), fontsize=9.0)
        figure.colorbar(image, ax=columns, location="top", aspect=30, pad=0.01, **about)
    for axes in panels.flat:
        axes.label_outer()
    return figure


MAPS: dict[str, dict[str, Any]] = {
    "aperture": {"label": "aperture (mm), contacts yellow", "extend": "max"},
    "stress": {"label": "stress of cells in contact (MPa)", "extend": "min"},
    "change": {"label": "change of the sum of both walls' heights (mm)", "extend": "both"},
}
"""Maps of a joint's states: label and open ends of their colours."""


def draw_map(axes: Axes, closed: xr.Dataset, name: str, snapshot: int) -> AxesImage:
    """Draw the map ``name``, one of `MAPS`, of a snapshot, by its index.

    The scale of colours is that of all snapshots of the joint.
    """
    force = closed.snapshot_force.values
    spacing = history_of(closed).spacing
    colours: str | Colormap
    norm: Normalize
    if name == "aperture":
        fields = 1e3 * np.maximum(closed.snapshot_gap.values, 0.0)
        colours = _APERTURES
        norm = Normalize(0.0, reach_of(fields))
    elif name == "stress":
        fields = 1e-6 * force / spacing**2
        largest = float(fields.max()) or 1.0
        colours = "rocket_r"
        norm = LogNorm(1e-4 * largest, largest)
        fields = np.ma.masked_equal(fields, 0.0)
    else:
        fields = 1e3 * change_of_height(closed)
        reach = reach_of(np.abs(fields))
        colours = "vlag_r"
        norm = Normalize(-reach, reach)
    style = {"interpolation": "nearest"}
    image = draw_field(axes, fields[snapshot], spacing, cmap=colours, norm=norm, **style)
    if name == "aperture":
        touching = force[snapshot]
        contacts = np.ma.masked_where(touching == 0.0, np.ones_like(touching))
        draw_field(axes, contacts, spacing, cmap=ListedColormap([CONTACTS]), **style)
    return image


def describe_state(snapshot: xr.Dataset) -> tuple[str, str, str]:
    """Return a title for each of `MAPS` of a snapshot: stress, share in contact, broken volume."""
    stress = 1e-6 * float(snapshot.normal_stress[int(snapshot.snapshot_step)])
    contacts = 100.0 * float((snapshot.snapshot_force > 0.0).mean())
    broken = 1e9 * float(snapshot.snapshot_broken_volume)
    branch = f"cycle {int(snapshot.snapshot_cycle)}, {snapshot.snapshot_branch.item()}"
    return f"{branch}: {stress:.3g} MPa", f"{contacts:.3g} % in contact", f"{broken:.3g} mm³ broken"


def change_of_height(closed: xr.Dataset) -> np.ndarray:
    """Return the change (snapshot, y, x) [m] of the sum of both walls' heights since first touch.

    It is negative where the walls lost height.
    """
    now = closed.snapshot_upper.values + closed.snapshot_lower.values
    return now - (closed.upper_first.values + closed.lower_first.values)


def reach_of(values: np.ndarray) -> float:
    """Return the end of a scale of colours: the 99.5 % quantile of the values above 0.

    It is 1 if no value is above 0.
    """
    some = values[values > 0.0]
    return float(np.quantile(some, 0.995)) if some.size else 1.0


def animated_stresses(largest: float) -> list[float]:
    """Return the stresses [Pa] of the snapshots of an animation, from 0 to the ``largest``.

    They are dense at low stress, where joints close fast.
    """
    return [float(largest * share**2) for share in np.linspace(0.0, 1.0, STRESSES + 1)]


@styled
def crushing_animation(closed: xr.Dataset, title: str) -> FuncAnimation:
    """Animate a joint over its snapshots: a section of the walls, a map of their change, the curve.

    A point on the curve of gross closure shows the state. Raise `InputError` without snapshots.
    """
    if not closed.sizes.get("snapshot"):
        raise InputError("an animation needs snapshots: simulate(..., snapshots=[...])")
    mosaic = [["curve", "map"], ["walls", "walls"]]
    figure, panels = subplots(mosaic, figsize=(8.0, 6.0), title=title)
    FigureCanvasAgg(figure)
    image = draw_map(panels["map"], closed, "change", 0)
    label = "change of height (mm)"
    figure.colorbar(image, ax=panels["map"], label=label, extend="both", shrink=0.85)

    @styled
    def show(frame: int) -> list:
        """Draw a frame on cleared axes, as `FuncAnimation` asks for it."""
        for axes in panels.values():
            axes.clear()
        at = closed.isel(snapshot=frame)
        state = closed.isel(step=int(at.snapshot_step))
        closure = 1e3 * state.closure
        stress = 1e-6 * state.normal_stress
        draw_curves(panels["curve"], closed, of=GROSS)
        panels["curve"].plot(closure, stress, "o", color="black", ms=7, zorder=5)
        panels["curve"].set_title(describe_state(at)[0])
        draw_map(panels["map"], closed, "change", frame)
        touching = at.snapshot_force.values > 0.0
        contacts = np.ma.masked_where(~touching, np.zeros(touching.shape))
        style = {"cmap": "gray", "vmin": 0.0, "vmax": 1.0, "interpolation": "nearest"}
        draw_field(panels["map"], contacts, history_of(closed).spacing, **style)
        panels["map"].set_title(f"contacts black: {100.0 * touching.mean():.2g} % of the cells")
        _draw_walls(panels["walls"], closed, frame)
        for name in ("curve", "walls"):
            sns.despine(ax=panels[name])
        return []

    show(0)
    return FuncAnimation(figure, show, frames=closed.sizes["snapshot"], interval=_PAUSE)


def _draw_walls(axes, closed: xr.Dataset, frame: int) -> None:
    """Draw a section of both walls along x at a snapshot, the upper one above its gap.

    The section is along the row whose heights change most up to the last snapshot.
    """
    row = int(np.abs(change_of_height(closed)[-1]).sum(axis=1).argmax())
    lower = 1e3 * closed.snapshot_lower.values[:, row]
    upper = lower + 1e3 * np.maximum(closed.snapshot_gap.values[:, row], 0.0)
    pristine = 1e3 * closed.lower_first.values[row]
    x = 1e3 * closed.x.values
    lowest = min(lower.min(), pristine.min())
    highest = upper.max()
    room = 0.1 * (highest - lowest)
    low = lowest - room
    high = highest + room
    axes.fill_between(x, lower[frame], low, color="C1", alpha=0.55)
    axes.fill_between(x, upper[frame], high, color="C0", alpha=0.55)
    axes.plot(x, pristine, ":", color="0.3", lw=1.0, zorder=4)
    force = closed.snapshot_force.values[frame, row] > 0.0
    axes.plot(x[force], lower[frame][force], "o", color="black", ms=4)
    axes.set(xlim=(x[0], x[-1]), ylim=(low, high), xlabel="x (mm)", ylabel="height (mm)")
    where = 1e3 * float(closed.y.values[row])
    axes.set_title(f"walls at y = {where:.3g} mm; dotted: lower wall before; dots: contacts")
