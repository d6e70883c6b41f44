"""Figures of a measured curve beside simulated joints: its fit, and the region of constants."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from scipy import ndimage

from jointclosure.joint.status import BRANCHES, LOADING
from jointclosure.measured.fit import Fit
from jointclosure.measured.likelihood import Likelihood
from jointclosure.measured.validation import MECHANISMS, NEITHER, Region
from jointclosure.plotting.style import decimal_ticks, styled, subplots
from jointclosure.statistics.standard_errors import CONFIDENCE

_LEAST = 1e-4  # p-value at the end of the scale of colours


@styled
def fit_figure(result: Fit, title: str) -> Figure:
    """Draw the measured curve on the band of the fitted joints, and what the fit tried.

    If the model does not explain the curve, the band is that of the nearest joints. Beside it, over
    the fitted parameter, are the ratios of simulated to measured readings, and the log likelihood
    if the model explains the curve. The parameter is the mismatch wavelength, or the compressive
    strength for scanned walls.
    """
    if not result.interval_holds:
        title += ": the model does not explain this curve, and no interval is valid"
    size: dict[str, Any] = {"figsize": (12.5, 6.4), "title": title}
    if result.interval_holds:
        figure, panels = subplots("ca;cb", **size, height_ratios=(2, 1))
        panels["a"].sharex(panels["b"])
        panels["a"].tick_params(labelbottom=False)
    else:
        figure, panels = subplots("ca", **size)
    curve, above = panels["c"], panels["a"]
    lowest = panels.get("b", above)
    closures = result.simulated.closures[_drawn_joints(result)]
    kind = ("nearest", "fitted")
    draw_measured(curve, result, closures, result.simulated.stresses, kind[result.reached])
    axis, scale = (1, 1e-6) if result.scanned else (0, 1e3)
    tried = scale * (result.likelihood.wavelengths, result.likelihood.strengths)[axis]
    logs = np.moveaxis(result.simulated.logs, axis, 0)
    nodes = np.geomspace(tried[0], tried[-1], len(logs))
    _draw_readings(above, result, nodes, logs)
    if "b" in panels:
        below = panels["b"]
        profile = result.likelihood.log.max(axis=1 - axis)
        below.plot(tried, profile - profile.max(), color="C0")
        interval = result.compressive_strength if result.scanned else result.mismatch_wavelength
        if interval is not None:
            low, high = np.clip(scale * np.array(interval[1:]), nodes[0], nodes[-1])
            below.axvspan(low, high, color="0.9", lw=0.0, label="95 % interval")
            below.legend(frameon=False)
        below.set(xscale="log", ylim=(-12.0, 1.0), ylabel="log likelihood")
    fitted = "compressive strength (MPa)" if result.scanned else "mismatch wavelength (mm)"
    lowest.set_xlabel(fitted)
    decimal_ticks(lowest.xaxis, above.yaxis)
    return figure


def _draw_readings(axes: Axes, result: Fit, nodes: np.ndarray, logs: np.ndarray) -> None:
    """Draw the ratio of simulated to measured readings over the fitted parameter.

    Each reading has the median and the range of 90 % of the joints. ``nodes`` (n,) are the values
    of the parameter, ``logs`` (n, ..., readings) the logarithms of simulated readings, NaN for
    failed joints; nodes at which all joints failed are left out.
    """
    known = np.isfinite(logs).reshape(len(nodes), -1).any(axis=1)
    nodes = nodes[known]
    logs = logs[known]
    places = result.measured.places()
    names = result.measured.names()
    markers = dict(zip(dict.fromkeys(level for _, level in places), "osDv", strict=False))
    for number, ((cycle, level), name) in enumerate(zip(places, names, strict=True)):
        ratios = np.exp(logs[..., number]).reshape(len(nodes), -1) / result.measured.values[number]
        low, middle, high = np.nanpercentile(ratios, (5.0, 50.0, 95.0), axis=1)
        axes.errorbar(
            nodes * 1.02 ** (number - 0.5 * (len(places) - 1)), middle,
            yerr=(middle - low, high - middle), lw=0.8, ms=4, color=f"C{cycle - 1}",
            marker=markers[level], mfc=None if level is None else "none", label=name,
        )  # fmt: skip
    axes.axhline(1.0, color="0.4", lw=0.8, zorder=0)
    axes.set(xscale="log", yscale="log", ylabel="simulated over measured")
    axes.legend(
        frameon=False, fontsize=8, title="median, 90 % of joints",
        loc="upper left", bbox_to_anchor=(1.0, 1.0),
    )  # fmt: skip


def draw_measured(
    axes: Axes, result: Fit | Region, closures: np.ndarray, stresses: np.ndarray, kind: str
) -> None:
    """Draw a measured curve, and below it the band of nine in ten simulated joints.

    ``closures`` (joints, cycles, 2, stresses) [m] are net, since the seating of each cycle, on
    loading and unloading, at ``stresses`` [Pa]. ``kind`` says in the legend which joints they are.
    """
    for cycle in range(1, result.measured.cycles + 1):
        colour = f"C{cycle - 1}"
        for branch in (0, 1) if cycle in result.measured.unloaded else (0,):
            ends = np.nanpercentile(1e3 * closures[:, cycle - 1, branch], (5.0, 95.0), axis=0)
            label = f"cycle {cycle}, {BRANCHES[branch]}: nine in ten {kind} joints"
            loads = BRANCHES[branch] == LOADING
            axes.fill_betweenx(
                1e-6 * stresses, *ends, lw=0.0, label=label, alpha=0.25 if loads else 0.6,
                fc=colour if loads else "none", ec=colour, hatch=None if loads else "////",
            )  # fmt: skip
        seating = result.measured.seating
        for branch, stress, closure in result.curve.since_seating(cycle, seating):
            if branch == LOADING:
                stress = np.append(seating, stress)
                closure = np.append(0.0, closure)
            axes.plot(1e3 * closure, 1e-6 * stress, "o-", ms=3, lw=1.2, color=colour)
        axes.plot([], [], "o-", ms=3, color=colour, label=f"cycle {cycle}: measured")
    axes.set(xlabel="net closure since seating of the cycle (mm)", ylabel="normal stress (MPa)")
    axes.set(xlim=(min(0.0, axes.get_xlim()[0]), None))
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper left", bbox_to_anchor=(-0.1, -0.09))


def _drawn_joints(result: Fit) -> np.ndarray:
    """Return whether each simulated joint (wavelengths, strengths, joints) is drawn.

    Drawn are joints at the most likely wavelength and strength; if the interval of the fit is
    valid, those within it too. Joints without all readings are not.
    """
    likelihood = result.likelihood
    kept = np.isfinite(result.simulated.logs).all(axis=-1)
    best = likelihood.nodes(likelihood.best, kept.shape[:2])
    for axis, values in enumerate((likelihood.wavelengths, likelihood.strengths)):
        nodes = np.geomspace(values[0], values[-1], kept.shape[axis])
        near = np.arange(nodes.size) == best[axis]
        if result.interval_holds and values.size > 1:
            low, high = likelihood.interval(axis)[1:]
            near |= (nodes >= low) & (nodes <= high)
        kept &= np.expand_dims(near, [other for other in range(3) if other != axis])
    return kept


@styled
def region_figure(region: Region, title: str) -> Figure:
    """Draw the measured curve on the nearest joints, and p-values by strength and constant.

    There is a panel for each mechanism. A p-value is the largest over the mismatch wavelengths.
    """
    mechanisms = [name for name in MECHANISMS if name in region.mechanisms] or [NEITHER]
    figure, panels = subplots(
        1, 1 + len(mechanisms), figsize=(5.6 + 3.9 * len(mechanisms), 6.4),
        width_ratios=[1.4, *[1.0] * len(mechanisms)], title=title,
    )  # fmt: skip
    nearest = max(region.mechanisms, key=region.p_value)
    closures = region.closures[region.place(nearest)]
    draw_measured(panels[0], region, closures, region.stresses, "of the nearest")
    panels[0].set_title(f"nearest: {nearest}")
    for axes, name in zip(panels[1:], mechanisms, strict=True):
        laters, kinds = zip(*region.joints_of(name).items(), strict=True)
        mesh = _draw_p_values(axes, kinds)
        if about := MECHANISMS.get(name):
            constants = [getattr(later, about.field) for later in laters]
            axes.set_xticks(range(len(kinds)), [f"{constant:g}" for constant in constants])
            unit = "" if about.unit == "1" else f" ({about.unit})"
            axes.set_xlabel(f"{about.constant}{unit}")
        else:
            axes.set_xticks([])
        number, _, j = region.nearest(name)
        strength = 1e-6 * kinds[number].strengths[j]
        axes.plot(number, strength, "r+", ms=10, mew=1.8, clip_on=False, zorder=5)
        none = "" if region.compatible(name) else ": none is compatible"
        axes.set(title=f"{name}{none}", ylabel="compressive strength (MPa)")
    bar = figure.colorbar(mesh, ax=list(panels[1:]), extend="min")
    bar.set_label("share of such joints that lie as far off (+: nearest)")
    bar.ax.axhline(1.0 - CONFIDENCE, color="k")
    return figure


def _draw_p_values(axes: Axes, kinds: Sequence[Likelihood]):
    """Draw p-values by constant (columns) and strength, with the limit of the compatible region.

    ``kinds`` are the likelihoods of the constants. Return the mesh, for a colour bar.
    """
    p_values = np.stack([one.p_values.max(axis=0) for one in kinds], axis=1)
    strengths = 1e-6 * kinds[0].strengths
    half = np.sqrt(strengths[1] / strengths[0])
    rows = np.append(strengths / half, strengths[-1] * half)
    columns = np.arange(len(kinds) + 1) - 0.5
    mesh = axes.pcolormesh(
        columns, rows, np.maximum(p_values, _LEAST), norm=LogNorm(_LEAST, 1.0), cmap="viridis",
        rasterized=True,
    )  # fmt: skip
    for place, column in enumerate((p_values >= 1.0 - CONFIDENCE).T):
        for (run,) in ndimage.find_objects(ndimage.label(column)[0]):
            low = run.start
            high = run.stop
            corners = place + np.array([0, 1, 1, 0, 0])
            axes.plot(columns[corners], rows[[low, low, high, high, low]], "w-", lw=1.4)
    axes.set(yscale="log", ylim=(rows[0], rows[-1]))
    decimal_ticks(axes.yaxis)
    return mesh
