"""Figures for notebooks (`jointclosure.plot`): each function draws on axes and returns them.

``import jointclosure as jc`` and ``jc.plot.curves(joint)``. Without ``axes`` a new figure of pyplot
is made, which notebooks show. Lengths are drawn in mm and stresses in MPa.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import xarray as xr

from jointclosure.inputs import InputError, check_length, check_one_of
from jointclosure.joint.history import GROSS, NET
from jointclosure.joint.result_tables import stress_table
from jointclosure.plotting.joint import draw_curves, draw_stiffness
from jointclosure.plotting.snapshots import MAPS, describe_state, draw_map
from jointclosure.plotting.style import BRANCH_LINES, styled
from jointclosure.plotting.walls import draw_heights, draw_section

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jointclosure.uncertainty.scanned_joint import ClosedJoint

Joint: TypeAlias = "xr.Dataset | ClosedJoint"
__all__ = ["aperture", "contacts", "curves", "damage", "stiffness", "wall", "walls"]


def __dir__() -> list[str]:
    return __all__


@styled
def curves(
    joint: Joint, axes: Axes | None = None, since: str = "touch", gross: bool = False
) -> Axes:
    """Draw normal stress [MPa] over closure [mm] of a joint, or of all joints of an ensemble.

    Loading is solid and unloading dashed, with a colour for each cycle. Joints of an ensemble are
    thin lines. Their mean, a thick line, is at each stress over the joints that reached it. The
    range of a `ClosedJoint` is not drawn.

    Parameters
    ----------
    joint : Dataset or ClosedJoint
        Joint from `jointclosure.simulate` or `jointclosure.close`, or an ensemble from
        `jointclosure.simulate_ensemble`.
    axes : Axes, optional
        Axes to draw on, whose labels, lower limit of stress and legend are set. By default those of
        a new figure of pyplot.
    since : {"touch", "seating", "cycle"}
        Zero of closure: first touch, the seating stress on the loading of each cycle, or the start
        of each cycle. For an ensemble only "touch" is allowed.
    gross : bool
        Whether to draw gross closure, with the elastic indentation of the half-spaces, in place of
        net closure.

    Returns
    -------
    Axes
        The axes that were drawn on.

    Raises
    ------
    InputError
        If ``since`` is not one of these words, or not "touch" for an ensemble.
    """
    check_one_of("since", since, ("touch", "seating", "cycle"))
    history = _history(joint)
    axes = _axes(axes)
    if "realization" in history.dims:
        if since != "touch":
            raise InputError(f"since = {since!r}: must be touch for an ensemble")
        _ensemble_curves(axes, history, gross)
    else:
        draw_curves(axes, history, since, GROSS if gross else NET)
    return axes


def _ensemble_curves(axes: Axes, ensemble: xr.Dataset, gross: bool) -> None:
    """Draw the closure of each joint of an ensemble as a thin line, and the mean as a thick line.

    The mean at a stress is over the joints that reached it.
    """
    stress = 1e-6 * ensemble.stress.values
    closures = ensemble.closure if gross else ensemble.closure - ensemble.bulk_indentation
    for index, number in enumerate(ensemble.cycle.values):
        for name, style in BRANCH_LINES.items():
            closure = 1e3 * closures.sel(cycle=number, branch=name).values
            known = np.isfinite(closure).any(axis=0)
            colour = f"C{index}"
            axes.plot(closure.T, stress, style, color=colour, lw=0.5, alpha=0.35)
            mean = np.nanmean(closure[:, known], axis=0)
            label = f"cycle {number}, {name}: mean"
            axes.plot(mean, stress[known], style, color=colour, lw=2.0, label=label)
    kind = "gross" if gross else "net"
    axes.set(xlabel=f"{kind} closure from first touch (mm)", ylabel="normal stress (MPa)", ylim=0.0)
    axes.legend(frameon=False)


@styled
def stiffness(joint: Joint, axes: Axes | None = None) -> Axes:
    """Draw the net tangent stiffness kn [MPa/mm] of one joint over normal stress [MPa].

    The stiffness has a logarithmic axis, with a line for each cycle and branch. The range of a
    `ClosedJoint` is not drawn.

    Parameters
    ----------
    joint : Dataset or ClosedJoint
        Joint from `jointclosure.simulate` or `jointclosure.close`; no ensemble.
    axes : Axes, optional
        Axes to draw on, by default those of a new figure of pyplot.

    Returns
    -------
    Axes
        The axes that were drawn on.
    """
    axes = _axes(axes)
    draw_stiffness(axes, stress_table(_history(joint)))
    return axes


@styled
def wall(heights: np.ndarray, spacing: float, axes: Axes | None = None) -> Axes:
    """Draw a map of the heights of one wall [mm], with a colour bar.

    Parameters
    ----------
    heights : array (y, x)
        Heights [m]; NaN are holes.
    spacing : float
        Grid spacing [m].
    axes : Axes, optional
        Axes to draw on, by default those of a new figure of pyplot.

    Returns
    -------
    Axes
        The axes that were drawn on.

    Raises
    ------
    InputError
        If the spacing is not allowed.
    """
    check_length("spacing", spacing)
    axes = _axes(axes)
    heights = np.asarray(heights)
    image = draw_heights(axes, heights, spacing, float(np.nanmax(np.abs(heights))))
    image.set_interpolation("nearest")
    axes.figure.colorbar(image, ax=axes, label="height (mm)")
    return axes


@styled
def walls(
    upper: Any, lower: np.ndarray | None = None, *, spacing: float | None = None,
    axes: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw both walls at first touch, in a section along x through the first contact [mm].

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m]; or only ``upper``, a `ClosedJoint` or `RegisteredPair`
        with walls and spacing.
    spacing : float
        Grid spacing [m], needed with arrays.
    axes : Axes, optional
        Axes to draw on, by default those of a new figure of pyplot.

    Returns
    -------
    Axes
        The axes that were drawn on.

    Raises
    ------
    InputError
        If a wall or the spacing is missing, or the spacing is not allowed.
    """
    pair = getattr(upper, "pair", upper)
    if lower is None and hasattr(pair, "spacing") and hasattr(pair, "lower"):
        upper = pair.upper
        lower = pair.lower
        spacing = pair.spacing
    if lower is None or spacing is None:
        raise InputError("walls: must be upper, lower and spacing=, or a joint that has them")
    check_length("spacing", spacing)
    axes = _axes(axes)
    draw_section(axes, np.asarray(upper), np.asarray(lower), spacing)
    axes.legend(frameon=False, loc="best")
    return axes


@styled
def aperture(joint: Joint, snapshot: int = -1, axes: Axes | None = None) -> Axes:
    """Draw a map of the distance of the deformed walls [mm] in a snapshot, with contacts in yellow.

    Parameters
    ----------
    joint : Dataset or ClosedJoint
        Joint from `jointclosure.simulate` or `jointclosure.close` with ``snapshots``.
    snapshot : int
        Index of the snapshot, by default the last one.
    axes : Axes, optional
        Axes to draw on, by default those of a new figure of pyplot.

    Returns
    -------
    Axes
        The axes that were drawn on. The colours have the same scale for all snapshots of the joint.

    Raises
    ------
    InputError
        If the joint has no such snapshot.
    """
    return _state_map(axes, joint, snapshot, "aperture")


@styled
def contacts(joint: Joint, snapshot: int = -1, axes: Axes | None = None) -> Axes:
    """Draw a map of the normal stress [MPa] of the cells in contact in a snapshot.

    Parameters
    ----------
    joint, snapshot, axes
        As for `aperture`.

    Returns
    -------
    Axes
        The axes that were drawn on.

    Raises
    ------
    InputError
        If the joint has no such snapshot.
    """
    return _state_map(axes, joint, snapshot, "stress")


@styled
def damage(joint: Joint, snapshot: int = -1, axes: Axes | None = None) -> Axes:
    """Draw a map of what the walls lost or gained by breakage and gouge up to a snapshot.

    It is the change of the sum of both walls' heights [mm] since first touch.

    Parameters
    ----------
    joint, snapshot, axes
        As for `aperture`.

    Returns
    -------
    Axes
        The axes that were drawn on.

    Raises
    ------
    InputError
        If the joint has no such snapshot.
    """
    return _state_map(axes, joint, snapshot, "change")


def _state_map(axes: Axes | None, joint: Joint, snapshot: int, name: str) -> Axes:
    """Draw the map ``name``, one of `MAPS`, of a snapshot of a joint, with colour bar and title.

    Raise `InputError` if the joint has no such snapshot.
    """
    history = _history(joint)
    axes = _axes(axes)
    count = history.sizes.get("snapshot", 0)
    if not -count <= snapshot < count:
        raise InputError(
            f"snapshot = {snapshot!r}: the joint has {count}; simulate(..., snapshots=[...]) and "
            "close(..., snapshots=[...]) store them"
        )
    titles = dict(zip(MAPS, describe_state(history.isel(snapshot=snapshot)), strict=True))
    axes.set_title(titles["aperture"] + ("" if name == "aperture" else f", {titles[name]}"))
    axes.figure.colorbar(draw_map(axes, history, name, snapshot), ax=axes, **MAPS[name])
    return axes


def _history(joint: Joint) -> xr.Dataset:
    """Return the history of a joint: that of a `ClosedJoint`, or the dataset itself."""
    return joint if isinstance(joint, xr.Dataset) else joint.history


def _axes(axes: Axes | None) -> Axes:
    """Return the given axes, or those of a new figure of pyplot if none are given."""
    import matplotlib.pyplot as plt  # the imports above name its extra if it is missing

    return plt.subplots(layout="constrained")[1] if axes is None else axes
