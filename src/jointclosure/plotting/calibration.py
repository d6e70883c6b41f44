"""Figure of a joint fitted to its measured closure: readings and likelihood over wavelength."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.joint.protocol import LOADING
from jointclosure.measured.fit import Fit
from jointclosure.plotting.style import decimal_ticks, styled, subplots


@styled
def fit_figure(result: Fit, title: str) -> Figure:
    """Draw the curve on the band of the fitted joints, readings by wavelength, and likelihood.

    Where walls are scanned, readings and likelihood are drawn over the strength.

    Parameters
    ----------
    result : Fit
    title : str
    """
    figure, panels = subplots(2, 2, figsize=(12.5, 6.4), height_ratios=(2, 1), sharex="col")
    above, below = panels[:, 1]
    grid = panels[0, 0].get_gridspec()
    for axes in panels[:, 0]:
        axes.remove()
    curve = figure.add_subplot(grid[:, 0])
    _draw_curve(curve, result)
    axis, scale = (1, 1e-6) if result.scanned else (0, 1e3)
    tried = scale * (result.likelihood.wavelengths, result.likelihood.strengths)[axis]
    logs = np.moveaxis(result.simulated.logs, axis, 0)
    nodes = np.geomspace(tried[0], tried[-1], len(logs))
    _draw_readings(above, result, nodes, logs)
    profile = result.likelihood.log.max(axis=1 - axis)
    below.plot(tried, profile - profile.max(), color="C0")
    interval = result.compressive_strength if result.scanned else result.mismatch_wavelength
    if result.interval_holds and interval is not None:
        low, high = np.clip(scale * np.array(interval[1:]), nodes[0], nodes[-1])
        below.axvspan(low, high, color="0.9", lw=0.0, label="95 % interval")
        below.legend(frameon=False)
    elif not result.interval_holds:
        title += ": the model does not explain this curve, and no interval is valid"
    below.set(xscale="log", ylim=(-12.0, 1.0), ylabel="log likelihood")
    below.set_xlabel("compressive strength (MPa)" if result.scanned else "mismatch wavelength (mm)")
    decimal_ticks(below.xaxis)
    decimal_ticks(above.yaxis)
    figure.suptitle(title, parse_math=False)
    return figure


def _draw_readings(axes: Axes, result: Fit, nodes: np.ndarray, logs: np.ndarray) -> None:
    """Draw simulated (nodes, ..., readings) over measured readings, with 90 % of the joints."""
    known = np.isfinite(logs).reshape(len(nodes), -1).any(axis=1)
    nodes, logs = nodes[known], logs[known]
    places = result.measured.places()
    markers = dict(zip(dict.fromkeys(level for _, level in places), "osDv", strict=False))
    for number, ((cycle, level), name) in enumerate(
        zip(places, result.measured.names(), strict=True)
    ):
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


def _draw_curve(axes: Axes, result: Fit) -> None:
    """Draw the measured curve since seating on the band of the fitted joints, by cycle."""
    closures = 1e3 * result.simulated.closures[_fitted(result)]
    stresses = 1e-6 * result.simulated.stresses
    kind = "fitted" if result.reached else "nearest"
    for cycle in range(1, result.measured.cycles + 1):
        colour = f"C{cycle - 1}"
        for branch in (0, 1) if cycle in result.measured.unloaded else (0,):
            low, high = np.nanpercentile(closures[:, cycle - 1, branch], (5.0, 95.0), axis=0)
            label = f"cycle {cycle}: nine in ten {kind} joints" if branch == 0 else None
            axes.fill_betweenx(stresses, low, high, color=colour, alpha=0.25, lw=0.0, label=label)
        if result.curve is None:
            continue
        seating = result.measured.seating
        for branch, stress, closure in result.curve.since_seating(cycle, seating):
            if branch == LOADING:
                stress, closure = np.append(seating, stress), np.append(0.0, closure)
            axes.plot(1e3 * closure, 1e-6 * stress, "o-", ms=3, lw=1.2, color=colour)
        axes.plot([], [], "o-", ms=3, color=colour, label=f"cycle {cycle}: measured")
    axes.set(
        xlabel="net closure since seating of the cycle (mm)", ylabel="normal stress (MPa)",
        xlim=(min(0.0, axes.get_xlim()[0]), None),
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.09))


def _fitted(result: Fit) -> np.ndarray:
    """Return which joints (wavelengths, strengths, joints) are fitted ones.

    These are the ones of the simulated wavelength and strength nearest to the most likely values,
    and of all others within both intervals if these are valid.
    """
    kept = np.ones(result.simulated.logs.shape[:3], bool)
    best = np.unravel_index(int(result.likelihood.log.argmax()), result.likelihood.log.shape)
    fine = (result.likelihood.wavelengths, result.likelihood.strengths)
    for axis, values in enumerate(fine):
        count: int = kept.shape[axis]
        nodes = np.geomspace(values[0], values[-1], count)
        near = np.arange(count) == int(np.abs(np.log(nodes / values[best[axis]])).argmin())
        if result.interval_holds and values.size > 1:
            low, high = result.likelihood.interval(axis)[1:]
            near |= (nodes >= low) & (nodes <= high)
        kept &= np.expand_dims(near, [other for other in range(3) if other != axis])
    return kept & np.isfinite(result.simulated.logs).all(axis=-1)
