"""Figures of a joint: closure, stiffness, laws and apertures, and the fit to a measured curve."""

import numpy as np
import pandas as pd
import seaborn as sns
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.budget import CLOSURE_GROSS, CLOSURE_NET, leading
from jointclosure.joint.curves import curve_table, has_flow, stiffness_table
from jointclosure.joint.history import GROSS, NET, branch_of, read_along, seat_of
from jointclosure.joint.laws import LAWS, fitted_laws, law_curves, law_words
from jointclosure.joint.protocol import LOADING
from jointclosure.measured.fit import Fit
from jointclosure.plotting.style import BRANCH_LINES, above, decimal_ticks, styled, subplots


@styled
def closure_curve(closed: xr.Dataset, title: str, ranges: pd.DataFrame | None = None) -> Figure:
    """Draw stress against gross and against net closure since seating, before which none counts."""
    figure, panels = subplots(1, 2, figsize=(10.4, 4.8), sharex=True, sharey=True)
    columns = {GROSS: CLOSURE_GROSS, NET: CLOSURE_NET}
    for axes, (of, column) in zip(panels, columns.items(), strict=True):
        if ranges is not None:
            _draw_ranges(axes, ranges.xs(column, level=1), closed)
        draw_curves(axes, closed, "seating", of)
    panels[1].set(ylabel="")
    if panels[0].get_legend():  # below the panels, where no curve is
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        for axes in panels:
            axes.get_legend().remove()
    figure.suptitle(title, parse_math=False)
    sns.despine(figure)
    return figure


def _draw_ranges(axes: Axes, ranges: pd.DataFrame, closed: xr.Dataset) -> None:
    """Draw ranges [mm] of the closure at the largest stress by cycle, each above the one before."""
    largest = 1e-6 * float(closed.normal_stress.max())
    for row, (cycle, ends) in enumerate(ranges.iterrows(), start=1):
        first = leading(ends)
        widths = [[first - ends.low], [ends.high - first]]
        axes.errorbar(
            first, largest * (1.0 + 0.03 * row), xerr=widths,
            fmt="o", ms=4, capsize=3, color=f"C{cycle - 1}", label=f"cycle {cycle}, range",
        )  # fmt: skip


def draw_curves(axes: Axes, closed: xr.Dataset, since: str = "touch", of: str = NET) -> None:
    """Draw stress against closure on axes, each cycle in its colour, unloading dashed."""
    values, numbers = read_along(closed, of), sorted(set(closed.cycle.values.tolist()))
    seating = float(closed.attrs["seating_stress_Pa"])
    for number in numbers:
        zero = 0.0
        if since == "seating":
            zero = seat_of(closed, number, LOADING, of)
        elif since == "cycle":
            zero = values[branch_of(closed, number, LOADING)[0]]
        for name, style in BRANCH_LINES.items():
            here = branch_of(closed, number, name)
            closure, stress = values[here], closed.normal_stress.values[here]
            if since == "seating":  # from its point at the seating stress
                over = stress > seating
                end = 0 if name == LOADING else int(over.sum())
                closure = np.insert(closure[over], end, seat_of(closed, number, name, of))
                stress = np.insert(stress[over], end, seating)
            axes.plot(
                1e3 * (closure - zero), 1e-6 * stress, style, color=f"C{number - 1}",
                zorder=above(number, name), label=f"cycle {number}, {name}",
            )  # fmt: skip
    words = {"touch": "first touch", "cycle": "the cycle's start"}
    words["seating"] = f"{1e-6 * seating:g} MPa"
    kind = "net" if of == NET else "gross"
    axes.set(xlabel=f"{kind} closure from {words[since]} (mm)")
    axes.set(ylabel="normal stress (MPa)", ylim=0.0)
    if len(numbers) <= 5:
        axes.legend(frameon=False)


def draw_stiffness(axes: Axes, closed: xr.Dataset) -> None:
    """Draw net normal stiffness by chords against stress; chords of the landing as open circles."""
    table = stiffness_table(closed)
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        colour, order = f"C{cycle - 1}", above(cycle, branch)
        for landing, part in rows.groupby("landing"):
            label = "landing on the maximum" if landing else f"cycle {cycle}, {branch}"
            axes.plot(
                part.normal_stress_MPa, part.normal_stiffness_net_MPa_per_mm,
                "" if landing else BRANCH_LINES[branch], label=label, color=colour, zorder=order,
                marker="o", ms=3, mfc="none" if landing else colour,
            )  # fmt: skip
    axes.set(xlabel="normal stress (MPa)", ylabel="net normal stiffness (MPa/mm)")
    axes.set(yscale="log", xlim=0.0)
    decimal_ticks(axes.yaxis)
    axes.legend(frameon=False, fontsize=9)


@styled
def engineering_figure(history: xr.Dataset, title: str) -> Figure:
    """Draw net closure since seating with the fitted laws, net stiffness and apertures.

    For a history with flow there is a further panel of hydraulic apertures.
    """
    shape, size = ((2, 2), (10.4, 8.4)) if has_flow(history) else ((1, 3), (13.5, 4.6))
    figure, panels = subplots(*shape, figsize=size)
    panels = panels.ravel()
    _draw_closure(panels[0], history)
    draw_stiffness(panels[1], history)
    panels[1].set_title("normal stiffness, by chords")
    _draw_aperture(panels[2], history)
    if has_flow(history):
        _draw_flow(panels[3], history)
        panels[3].set_ylim(0.0, max(axes.get_ylim()[1] for axes in panels[2:]))
        panels[2].set_ylim(panels[3].get_ylim())
    figure.suptitle(title, parse_math=False)
    for axes in panels:
        sns.despine(ax=axes)
    return figure


def _draw_closure(axes, history: xr.Dataset) -> None:
    """Draw loading of each cycle from its seating, and the fitted laws."""
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    fits = fitted_laws(history)
    styles = dict(zip(LAWS, (":", "-.", "--"), strict=True))
    for (cycle, branch), (stress, closure) in law_curves(history).items():
        if branch != LOADING:
            continue
        axes.plot(closure, stress, color=f"C{cycle - 1}", lw=2.2, label=f"cycle {cycle}")
        for name, style in styles.items():
            rows = fits[(fits.cycle == cycle) & (fits.branch == branch) & (fits.law == name)]
            law = LAWS[name].closure(stress, seating, *rows.value)
            axes.plot(law, stress, style, color="0.25", lw=1.0)
    for name, style in styles.items():
        axes.plot([], [], style, color="0.25", lw=1.0, label=law_words(name))
    axes.set(title="loading, and laws fitted to it", ylim=0.0, ylabel="normal stress (MPa)")
    axes.set(xlabel=f"net closure since {seating:g} MPa (mm)")
    axes.legend(frameon=False, fontsize=9)


def _draw_aperture(axes, history: xr.Dataset) -> None:
    """Draw mean aperture over stress from seating on, which leaves out the first contacts."""
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    table = curve_table(history)
    top = 0.0
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        axes.plot(
            rows.normal_stress_MPa, rows.mean_aperture_mm, BRANCH_LINES[branch],
            color=f"C{cycle - 1}", label=f"cycle {cycle}, {branch}",
            zorder=above(cycle, branch),
        )  # fmt: skip
        loaded = rows[rows.normal_stress_MPa >= 0.5 * seating].mean_aperture_mm
        top = max(top, float(np.nanmax(loaded)) if len(loaded) else 0.0)
    axes.set(
        title="mean aperture", xlim=0.0, ylim=(0.0, 1.15 * top or None),
        xlabel="normal stress (MPa)", ylabel="mean aperture (mm)",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)


def _draw_flow(axes, history: xr.Dataset) -> None:
    """Draw hydraulic apertures over stress by direction: loading thick, unloading thin."""
    for (cycle, branch), rows in curve_table(history).groupby(["cycle", "branch"], sort=False):
        for direction, style in (("x", "-"), ("y", ":")):
            label = f"cycle {cycle}, along {direction}" if branch == LOADING else None
            axes.plot(
                rows.normal_stress_MPa, rows[f"hydraulic_aperture_{direction}_mm"], style,
                color=f"C{cycle - 1}", label=label, lw=2.2 if branch == LOADING else 0.9,
                zorder=above(cycle, branch),
            )  # fmt: skip
    axes.set(
        title="hydraulic aperture (unloading thin)", xlim=0.0,
        xlabel="normal stress (MPa)", ylabel="hydraulic aperture (mm)",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)


@styled
def fit_figure(result: Fit, title: str) -> Figure:
    """Draw the curve on the band of the fitted joints; readings and likelihood by the parameter."""
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
    places, names = result.measured.places(), result.measured.names()
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
    axes.set(xlabel="net closure since seating of the cycle (mm)", ylabel="normal stress (MPa)")
    axes.set(xlim=(min(0.0, axes.get_xlim()[0]), None))
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.09))


def _fitted(result: Fit) -> np.ndarray:
    """Return which joints (wavelengths, strengths, joints) are nearest to the most likely values.

    With them are all others within both intervals if these are valid.
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
