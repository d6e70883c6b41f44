"""Maps of a joint at the requested stresses: aperture, contact forces, damage."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from jointclosure.joint.curves import spacing_of
from jointclosure.plotting.scanned_joint import map_extent
from jointclosure.plotting.style import panel_grid, styled

_ROWS = 3
"""Rows of full size; with n snapshots each map has sqrt(n / 3) columns."""
_MAP: dict[str, Any] = {"origin": "lower", "interpolation": "nearest"}


@styled
def snapshot_figure(closed: xr.Dataset, title: str) -> Figure:
    """Draw each snapshot: aperture with contacts, stress of cells, change of the walls.

    Parameters
    ----------
    closed : Dataset
        As from `jointclosure.simulate` with ``snapshots``, of which at least one was reached.
    title : str

    Notes
    -----
    Up to three snapshots have a row each. Of more, each map has several columns, so that the figure
    is at most about 1.2 times as high as wide; snapshots follow each other downwards, then to the
    right. Colour scales are the same for all; a few cells may be beyond their ends. The stress is
    the mean over a whole cell; contacts are smaller.
    """
    number = closed.sizes["snapshot"]
    blocks = math.ceil(math.sqrt(number / _ROWS))
    rows = math.ceil(number / blocks)
    size = max(3.5 / blocks, 2.2)
    figure, panels = panel_grid(
        rows, 3 * blocks, (size, size - 0.1), (0.0, 1.3), sharex=True, sharey=True
    )
    titles = [describe_state(closed.isel(snapshot=k)) for k in range(number)]
    for group, maps in enumerate(MAPS.values()):
        drawn, columns = maps(closed), panels[:, group * blocks : (group + 1) * blocks]
        for k, axes in enumerate(columns.T.flat):
            if k >= number:
                axes.set_axis_off()
                continue
            image = draw_map(axes, closed, drawn, k)
            if group == 0:
                draw_contacts(axes, closed, k)
            words = [titles[k][0]] * (blocks > 1 and group > 0) + [titles[k][group]]
            axes.set_title("\n".join(words), fontsize=9.0)
        figure.colorbar(
            image, ax=columns, label=drawn.label, location="top", aspect=30, pad=0.01,
            extend=drawn.beyond,
        )  # fmt: skip
    for axes in panels[:, 0]:
        axes.set_ylabel("y (mm)")
    for axes in panels[-1]:
        axes.set_xlabel("x (mm)")
    figure.suptitle(title, parse_math=False)
    return figure


class StateMap(NamedTuple):
    """Maps (snapshot, y, x) of a joint's states, their label, colours, scale, and open ends."""

    label: str
    fields: np.ndarray
    colours: str
    norm: Normalize
    beyond: str


def aperture_map(closed: xr.Dataset) -> StateMap:
    """Return maps of the distance of the deformed walls [mm], 0 in contact."""
    gap = 1e3 * np.maximum(closed.snapshot_gap.values, 0.0)
    return StateMap(
        "aperture (mm), contacts red", gap, "mako", Normalize(0.0, reach_of(gap)), "max"
    )


def stress_map(closed: xr.Dataset) -> StateMap:
    """Return maps of the stress of the cells in contact [MPa], averaged over the cell."""
    stresses = 1e-6 * closed.snapshot_force.values / spacing_of(closed) ** 2
    shown = np.ma.masked_equal(stresses, 0.0)
    return StateMap(
        "stress of cells in contact (MPa)", shown, "rocket_r", _stress_norm(stresses), "min"
    )


def change_map(closed: xr.Dataset) -> StateMap:
    """Return maps of the change of both walls' heights together since first touch [mm]."""
    change = 1e3 * change_of_height(closed)
    reach = reach_of(np.abs(change))
    scale = Normalize(-reach, reach)
    return StateMap("change of both walls' height (mm)", change, "vlag_r", scale, "both")


MAPS: dict[str, Callable[[xr.Dataset], StateMap]] = {
    "aperture": aperture_map,
    "stress": stress_map,
    "change": change_map,
}


def draw_map(axes: Axes, closed: xr.Dataset, drawn: StateMap, snapshot: int) -> AxesImage:
    """Draw a map of one snapshot on axes in millimetres."""
    extent = map_extent(drawn.fields.shape[1:], spacing_of(closed))
    field = drawn.fields[snapshot]
    return axes.imshow(field, cmap=drawn.colours, norm=drawn.norm, extent=extent, **_MAP)


def draw_contacts(axes: Axes, closed: xr.Dataset, snapshot: int) -> None:
    """Draw the cells in contact in red."""
    force = closed.snapshot_force.values[snapshot]
    contacts = np.ma.masked_where(force == 0.0, np.ones_like(force))
    extent = map_extent(force.shape, spacing_of(closed))
    axes.imshow(contacts, cmap="autumn", extent=extent, **_MAP)


def describe_state(snapshot: xr.Dataset) -> tuple[str, str, str]:
    """Describe a snapshot by one title for each map."""
    stress = 1e-6 * float(snapshot.normal_stress[int(snapshot.snapshot_step)])
    contacts = 100.0 * float((snapshot.snapshot_force > 0.0).mean())
    broken = 1e9 * float(snapshot.snapshot_broken_volume)
    branch = f"cycle {int(snapshot.snapshot_cycle)}, {snapshot.snapshot_branch.item()}"
    return f"{branch}: {stress:.3g} MPa", f"{contacts:.3g} % in contact", f"{broken:.3g} mm³ broken"


def change_of_height(closed: xr.Dataset) -> np.ndarray:
    """Return the change of both walls' heights together (snapshot, y, x) since first touch [m]."""
    now = closed.snapshot_upper.values + closed.snapshot_lower.values
    return now - (closed.upper_first.values + closed.lower_first.values)


def _stress_norm(stresses: np.ndarray) -> LogNorm:
    """Return a scale of four decades up to the largest stress of a cell."""
    largest = float(stresses.max()) or 1.0
    return LogNorm(1e-4 * largest, largest)


def reach_of(values: np.ndarray) -> float:
    """Return the 99.5 % quantile of the values that are not 0, to ignore a few outliers."""
    some = values[values > 0.0]
    return float(np.quantile(some, 0.995)) if some.size else 1.0
