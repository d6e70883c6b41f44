"""Maps of a joint at the stresses that were asked for: aperture, contact forces, damage."""

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from jointclosure.engineering.curves import area_of
from jointclosure.plotting.scanned_joint import map_extent
from jointclosure.plotting.style import styled, subplots

_MAP = {"origin": "lower", "interpolation": "nearest"}


@styled
def snapshot_figure(closed: xr.Dataset, title: str) -> Figure:
    """A row for each snapshot: aperture with contacts, stress of the cells, change of the walls.

    Parameters
    ----------
    closed : Dataset
        As from `jointclosure.simulate` with ``snapshots``, of which at least one was reached.
    title : str

    Notes
    -----
    Colours mean the same in all rows; few cells may be beyond their ends. The stress
    is that of a whole cell; contacts are smaller.
    """
    number = closed.sizes["snapshot"]
    spacing = (area_of(closed) / (closed.sizes["y"] * closed.sizes["x"])) ** 0.5
    stresses = 1e-6 * closed.snapshot_force.values / spacing**2
    figure, panels = subplots(
        number, 3, figsize=(10.5, 3.2 * number + 1.3), layout="constrained", squeeze=False,
        sharex=True, sharey=True,
    )  # fmt: skip
    columns = (
        ("aperture (mm), contacts red", 1e3 * np.maximum(closed.snapshot_gap.values, 0.0), "mako"),
        ("stress of cells in contact (MPa)", np.ma.masked_equal(stresses, 0.0), "rocket_r"),
        ("change of both walls' height (mm)", 1e3 * change_of_height(closed), "vlag_r"),
    )
    top, reach = reach_of(columns[0][1]), reach_of(np.abs(columns[2][1]))
    norms = (Normalize(0.0, top), _stress_norm(stresses), Normalize(-reach, reach))
    extent = map_extent(stresses.shape[1:], spacing)
    beyond = ("max", "min", "both")
    for column, (label, maps, colours), norm, extend in zip(
        panels.T, columns, norms, beyond, strict=True
    ):
        for axes, field in zip(column, maps, strict=True):
            image = axes.imshow(field, cmap=colours, norm=norm, extent=extent, **_MAP)
        figure.colorbar(
            image, ax=column, label=label, location="top", aspect=30, pad=0.01, extend=extend
        )
    for k, row in enumerate(panels):
        contacts = np.ma.masked_where(stresses[k] == 0.0, np.ones_like(stresses[k]))
        row[0].imshow(contacts, cmap="autumn", extent=extent, **_MAP)
        for axes, said in zip(row, _said(closed.isel(snapshot=k)), strict=True):
            axes.set_title(said, fontsize=9)
        row[0].set_ylabel("y (mm)")
    for axes in panels[-1]:
        axes.set_xlabel("x (mm)")
    figure.suptitle(title, parse_math=False)
    return figure


def _said(snapshot: xr.Dataset) -> tuple[str, str, str]:
    """What stands over the maps of a snapshot."""
    stress = 1e-6 * float(snapshot.normal_stress[int(snapshot.snapshot_step)])
    contacts = 100.0 * float((snapshot.snapshot_force > 0.0).mean())
    broken = 1e9 * float(snapshot.snapshot_broken_volume)
    branch = f"cycle {int(snapshot.snapshot_cycle)}, {snapshot.snapshot_branch.item()}"
    return f"{branch}: {stress:.3g} MPa", f"{contacts:.3g} % in contact", f"{broken:.3g} mm³ broken"


def change_of_height(closed: xr.Dataset) -> np.ndarray:
    """Change of both walls' heights together (snapshot, y, x) since first touch [m]."""
    now = closed.snapshot_upper.values + closed.snapshot_lower.values
    return now - (closed.upper_first.values + closed.lower_first.values)


def _stress_norm(stresses: np.ndarray) -> LogNorm:
    """Four decades up to the largest stress of a cell."""
    largest = float(stresses.max()) or 1.0
    return LogNorm(1e-4 * largest, largest)


def reach_of(values: np.ndarray) -> float:
    """What all but one in two hundred of those that are not 0 reach, so that few hide none."""
    some = values[values > 0.0]
    return float(np.quantile(some, 0.995)) if some.size else 1.0
