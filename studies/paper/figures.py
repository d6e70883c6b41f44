"""Figures of a study: closures, apertures, measured curves, trends, intervals, repetitions."""

import itertools
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import seaborn as sns
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from jointclosure.joint.history import history_of
from jointclosure.joint.laws import CYCLES, barton_bandis, law_holds
from jointclosure.joint.status import LOADING, TARGET_JUMPED, UNLOADING
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.mechanics.strength import strength_factor, von_mises_on_axis
from jointclosure.parameters import PROPERTIES
from jointclosure.parameters.units import in_unit
from jointclosure.plotting.style import BRANCH_LINES, above, panel_grid, styled, subplots, ticks_at
from jointclosure.plotting.walls import FIRST_TOUCH, draw_field
from jointclosure.statistics.number_texts import percent
from studies.frame.joint_tables import since_seating, succeeded
from studies.frame.panels import key, legend_below, legend_keys, point_key
from studies.frame.rocks import StudyRock
from studies.paper.closure_tables import CHANGE, FIT_COLUMNS, best_fits
from studies.paper.simulated_again import simulate_again
from studies.paper.tables_1_to_3 import UNPAIRED_TEST, figure_text, roughness_title, test_name

MOST_DRAWN = 500
"""Largest number of surfaces whose curves are drawn; of larger studies the first are drawn."""
_FEW_LINES = 20
"""Largest number of curves that are drawn in full strength; if there are more, they are fainter."""
_LAW_POINTS = 200
"""Number of stresses at which an empirical law is drawn."""
_OUTLINE = [withStroke(linewidth=3.5, foreground="white")]
_MARKERS = "osD^v"
_DARK = dict(enumerate(sns.color_palette("dark", 8), start=1))


class Measurements(NamedTuple):
    """Measured curves by rock, and the fits of `studies.paper.closure_tables.fit_table`."""

    curves: Mapping[str, MeasuredCurve] = MappingProxyType({})
    fits: pd.DataFrame = pd.DataFrame(columns=FIT_COLUMNS)

    @property
    def cycles(self) -> int:
        """Largest number of a measured cycle; 0 without measured curves."""
        return max((curve.cycles[-1] for curve in self.curves.values()), default=0)

    @property
    def best(self) -> list[int]:
        """Realisations that fit a cycle of a curve best, which are always drawn."""
        return self.fits.best_realization.dropna().astype(int).tolist()


def draw_measured_curve(
    axes,
    measured: Measurements,
    rock: str,
    base: xr.Dataset,
    seating_stress: float,
    cycles: Collection[int],
) -> str:
    """Draw the measured curve of a rock in a panel, and the realisations that fit it best.

    ``base`` are the joints of the rock's base case, ``cycles`` are those of the panel. Return lines
    for the title with the misfit of the best realisation for each cycle; "" without a measured
    curve.
    """
    if rock not in measured.curves:
        return ""
    curve = measured.curves[rock]
    for cycle in set(curve.cycles) & set(cycles):
        closures = [0.0]
        stresses = [seating_stress]
        for _, stress, closure in curve.since_seating(cycle, seating_stress):
            closures += closure.tolist()
            stresses += stress.tolist()
        axes.plot([1e3 * c for c in closures], [1e-6 * s for s in stresses], "k-", lw=1.6, zorder=5)
    misfits = []
    stress = base.stress.values
    for cycle, realization, misfit, misfit_percent in best_fits(measured.fits, rock):
        misfits.append(f"cycle {cycle} {misfit:.2g} mm ({percent(0.01 * misfit_percent)})")
        if cycle in cycles:
            best = 1e3 * since_seating(base).sel(cycle=cycle, realization=realization)
            for branch in BRANCH_LINES:
                closure = best.sel(branch=branch).values
                shown = stress > seating_stress
                axes.plot(closure[shown], 1e-6 * stress[shown], **_style(cycle))
    if not misfits:
        return "\nno realisation reaches all measured stresses"
    of_rock = measured.fits.rock == rock
    joints = int(measured.fits[of_rock].samples.max())
    return f"\nRMS misfit of the best of {joints} joints:\n{', '.join(misfits)}"


def _style(cycle: int) -> dict:
    return {
        "color": _DARK[1 + (cycle - 1) % len(_DARK)],
        "ls": "",
        "marker": _MARKERS[(cycle - 1) % len(_MARKERS)],
        "ms": 3.2,
        "markevery": 2,
        "zorder": 4,
    }


def measured_handles(measured: Measurements) -> list:
    """Return the legend's entries for measured curves and best fits; none without such curves."""
    fits = [
        key(f"surface that fits cycle {cycle} best", **_style(cycle))
        for cycle in range(1, measured.cycles + 1)
    ]
    return [key(color="0.1", lw=1.6, label="measured curve"), *fits] if measured.curves else []


def _surfaces_label(study: xr.Dataset, seating_stress: float | None) -> str:
    """Return the legend's text for the thin lines: the joints drawn by their stored stresses."""
    number = study.sizes["realization"]
    lowest = 1e-6 * float(study.stress[1])
    every = "every joint" if number < MOST_DRAWN else f"each of the first {number} joints"
    if seating_stress is None:
        every += f" from {lowest:.2g} MPa,\nand ticks where it starts and ends at zero stress"
    return every


@styled
def equivalent_stress() -> Figure:
    """Draw the maximum of the equivalent stress, Eq. (21), over Poisson's ratio, and Eq. (23)."""
    ratios = np.linspace(0.0, 0.5, 101)
    depths = np.linspace(0.2, 0.8, 6001)
    along = np.array([[von_mises_on_axis(z, nu) for z in depths] for nu in ratios[::5]])
    figure, axes = subplots(figsize=(5.2, 3.8))
    axes.plot(ratios[::5], along.max(axis=1), "o", label="maximum of Eq. (21)", zorder=3)
    fit = [strength_factor(nu) for nu in ratios]
    axes.plot(ratios, fit, "-", color="0.3", label="Eq. (23), the paper's fit")
    axes.set(
        xlabel="Poisson's ratio ν", ylabel="maximum equivalent stress / $p_0$", xlim=(-0.01, 0.51)
    )
    axes.legend(frameon=False)
    sns.despine(figure)
    return figure


@styled
def wall_pair_figure(upper: np.ndarray, lower: np.ndarray, spacing: float, title: str) -> Figure:
    """Draw the heights of both walls (y, x) [m] at a ``spacing`` [m], and the opening between them.

    The opening is that at first touch, whose place is marked.
    """
    figure, panels = subplots(1, 3, figsize=(10.5, 4.3), sharey=True)
    summed = 1e3 * (upper + lower)
    reach = 1e3 * max(np.abs(upper).max(), np.abs(lower).max())
    for axes, field in zip(panels[:2], (upper, lower), strict=True):
        image = draw_field(axes, 1e3 * field, spacing, cmap="cividis", vmin=-reach, vmax=reach)
    bar: dict[str, Any] = {"location": "bottom", "aspect": 30}
    label = "height towards the other wall (mm)"
    figure.colorbar(image, ax=panels[:2], label=label, shrink=0.4, **bar)
    image = draw_field(panels[2], summed.max() - summed, spacing, cmap="mako")
    y, x = (1e3 * (i + 0.5) * spacing for i in np.unravel_index(np.argmax(summed), summed.shape))
    panels[2].plot(x, y, "o", ms=9, **FIRST_TOUCH)
    figure.colorbar(image, ax=panels[2], label="opening (mm)", shrink=0.8, **bar)
    titles = ("upper wall", "lower wall", "opening at first touch (circle)")
    for axes, name in zip(panels, titles, strict=True):
        axes.set_title(name)
        axes.label_outer()
    figure.suptitle(title, parse_math=False)  # a title is no formula
    return figure


def _curves(base: xr.Dataset, seating_stress: float | None) -> xr.DataArray:
    """Return the curves of closure [m] that are drawn: net closures since seating.

    If the seating stress is None, they are gross closures since the start of the cycle.
    """
    if seating_stress is not None:
        return since_seating(base)
    return base.closure - base.residual_closure.shift(cycle=1, fill_value=0.0)


def closest_to_mean(study: xr.Dataset, case: str, seating_stress: float | None) -> int:
    """Return the realisation of a case whose first cycle is closest (RMS) to the mean curve.

    If all have failed, it is the first.
    """
    base = study.sel(case=case).where(succeeded(study).sel(case=case))
    curves = _curves(base, seating_stress).isel(cycle=0)
    curves = curves.where(curves.stress > (seating_stress or 0.0))
    distance = ((curves - curves.mean("realization")) ** 2).mean(("branch", "stress"))
    return int(study.realization.values[int(distance.fillna(np.inf).argmin("realization"))])


_WIDTH_OF_ONE = 7.0
"""Width [inches] of the figure of closure of one rock, with its legend below the panels."""


@styled
def closure_figure(
    study: xr.Dataset,
    rocks: dict[str, StudyRock],
    seating_stress: float | None,
    strength_ratio: float,
    measured: Measurements = Measurements(),
    history: Callable[[xr.Dataset, str, int], xr.Dataset | None] = simulate_again,
) -> Figure:
    """Draw the closure curves of each rock's base case, with the law and measured curves.

    Closures are net since ``seating_stress`` [Pa]; if it is None, they are gross as in the paper,
    and measured curves are left out. The surface closest to the mean is drawn by all its steps.
    ``history`` simulates these from study, label of the case and realisation; if it returns None,
    this surface is drawn at the stored stresses like the others. ``strength_ratio`` is the strength
    of the rock over that of the walls in the Barton-Bandis law.
    """
    columns = min(2, len(rocks))
    rows = -(-len(rocks) // columns)
    cycles = [int(c) for c in study.cycle.values]
    split = [cycles[:1], cycles[1:]] if len(cycles) > 1 else [cycles]
    widths = [1.7, 1.0][: len(split)] * columns
    figure, panels = subplots(
        rows, len(widths), figsize=(5.6 * columns, 4.2 * rows),
        squeeze=False, width_ratios=widths, sharey="row",
    )  # fmt: skip
    for part in range(len(split)):  # the same range of closure for all rocks
        for axes in panels[:, part :: len(split)].flat[1:]:
            axes.sharex(panels[0, part])
    for axes in panels.flat[len(rocks) * len(split) :]:
        axes.set_visible(False)
    measured = Measurements() if seating_stress is None else measured
    for number, (name, rock) in enumerate(rocks.items()):
        row, column = divmod(number, columns)
        for part, shown in enumerate(split):
            axes = panels[row, column * len(split) + part]
            title = _draw_rock(
                axes, study, name, rock, shown, seating_stress, strength_ratio, measured, history
            )
            axes.set_title(title if part == 0 else _cycles_in_words(shown))
            if part:
                axes.set(xlabel="the same (mm)", ylabel="")
                axes.xaxis.set_major_locator(MaxNLocator(4))  # small closures have long labels
            axes.tick_params(labelleft=part == 0)
    handles: list[Artist] = [key(f"cycle {c}", color=f"C{c - 1}", lw=2) for c in cycles]
    handles += [
        key(color="0.5", lw=2, label="joint closest to the mean, all steps of loading"),
        key(color="0.5", lw=2, ls="--", label="the same, unloading"),
        key(color="0.5", lw=0.6, alpha=0.6, label=_surfaces_label(study, seating_stress)),
        Rectangle((0, 0), 1, 1, color="0.5", alpha=0.25, label="mean ± 1 standard deviation"),
    ]
    if seating_stress is not None:
        handles.append(key("mean of all joints, loading and unloading", **_mean_style(1)))
    if any(map(_lawful, rocks.values())):
        label = "Barton-Bandis law (empirical, mated joints)"
        label += "" if seating_stress is None else ",\nwhich may leave the frame"
        handles.append(key(color="0.2", lw=1.2, ls=(0, (1, 1.5)), label=label))
    handles += measured_handles(measured)
    place: dict[str, Any] = {"loc": "outside lower center", "ncols": 3}
    if columns == 1:  # one rock: narrow, so that letters can be read on a phone
        place = {"loc": "outside lower center", "ncols": 2, "fontsize": 9}
        figure.set_size_inches(_WIDTH_OF_ONE, 4.2 + 0.2 * -(-len(handles) // 2))
    figure.legend(handles=handles, frameon=False, **place)
    sns.despine(figure)
    return figure


def _lawful(rock: StudyRock) -> bool:
    """Return whether the Barton-Bandis law is drawn: it holds for the JRC of random walls."""
    return law_holds(rock.jrc) and not rock.walls


def _draw_rock(
    axes, study: xr.Dataset, name: str, rock: StudyRock, cycles: list[int],
    seating_stress: float | None, strength_ratio: float, measured: Measurements,
    history: Callable[[xr.Dataset, str, int], xr.Dataset | None],
) -> str:  # fmt: skip
    """Draw some cycles of a rock's base case in a panel, and return the panel's title.

    Arguments are as for `closure_figure`.
    """
    case = study.case[(study.rock == name) & (study.parameter == "base")].item()
    chosen = closest_to_mean(study, case, seating_stress)
    base = study.sel(case=case).where(succeeded(study).sel(case=case))
    steps = history(study, case, chosen)
    for cycle in cycles:
        _draw_cycle(axes, base, cycle, chosen, seating_stress, steps)
    for cycle in cycles if seating_stress is not None else ():
        _draw_mean(axes, base, cycle, seating_stress)
    if _lawful(rock):
        first = seating_stress or 0.0
        stress = np.linspace(first, max(first, float(study.stress.max())), _LAW_POINTS)
        for cycle in set(cycles) & set(CYCLES):
            law = barton_bandis(rock.jrc, rock.intact.compressive_strength, strength_ratio, cycle)
            closure = 1e3 * (law.closure(stress) - law.closure(first))
            line = Line2D(closure, 1e-6 * stress, color="0.2", lw=1.2, ls=(0, (1, 1.5)))
            if seating_stress is None:
                axes.add_line(line)
            else:
                axes.add_artist(line)  # the axis has the range of the study's curves
    if seating_stress is None:
        fitted = ""
        closure_of = "gross closure since the start of the cycle (mm)"
    else:
        fitted = draw_measured_curve(axes, measured, name, base, seating_stress, cycles)
        closure_of = f"net closure since seating at {1e-6 * seating_stress:g} MPa (mm)"
    axes.set(ylim=(0.0, 1.02 * 1e-6 * rock.max_normal_stress), ylabel="normal stress (MPa)")
    axes.set_xlabel(closure_of)
    assumed = ""
    if rock.max_normal_stress_is_assumed:
        assumed = f"\n(maximum of {1e-6 * rock.max_normal_stress:g} MPa is an assumption)"
    title = f"{figure_text(rock.title)}, {roughness_title(rock)}"
    return f"{title}, {_cycles_in_words(cycles)}{assumed}{fitted}"


def _cycles_in_words(cycles: list[int]) -> str:
    return f"cycle {cycles[0]}" if len(cycles) == 1 else f"cycles {cycles[0]} to {cycles[-1]}"


class _Branches(NamedTuple):
    """Curves of surfaces on one branch (loading or unloading) of a cycle, by ascending stress."""

    closures: np.ndarray  # (surfaces, points) [mm]
    stresses: np.ndarray  # (points,) [MPa]


def _stored(base: xr.Dataset, cycle: int, branch: str, seating_stress: float | None) -> _Branches:
    """Return a branch of all surfaces at the stored stresses and at its least and largest stress.

    ``base`` are the joints of a base case. Below the first stored stress a gross closure rises by
    half of its maximum: a NaN follows the point at zero stress, so that no line is drawn from it.
    """
    curves = 1e3 * _curves(base, seating_stress).sel(cycle=cycle, branch=branch)
    first = seating_stress or 0.0
    stress = base.stress.values
    shown = (stress > first) & np.isfinite(curves.values).any(axis=0)
    columns = [curves.values[:, shown]]
    stresses = [stress[shown]]
    end = _end_of(base, cycle, branch, seating_stress)
    gap = np.full((len(curves), 1), np.nan)
    low = [1e3 * end[:, None], *([gap] if seating_stress is None else [])]
    maximum = float(base.max_normal_stress)
    top = base["max_closure" if seating_stress is None else "max_closure_seated_net"]
    reached = ((base.status.fillna(0).astype(int) & TARGET_JUMPED) == 0).values
    high = np.where(reached, 1e3 * top.sel(cycle=cycle).values, np.nan)[:, None]
    if not np.isclose(stress, maximum).any():  # the maximum is between the stored stresses
        columns = [*columns, high]
        stresses = [*stresses, [maximum]]
    columns = [*low, *columns]
    stresses = [[first] * len(low), *stresses]
    return _Branches(np.column_stack(columns), 1e-6 * np.concatenate(stresses))


def _end_of(base: xr.Dataset, cycle: int, branch: str, seating_stress: float | None) -> np.ndarray:
    """Return the closures (surfaces,) [m] at the least stress of a branch, NaN if failed."""
    if branch == LOADING:
        return 0.0 * base.residual_closure.sel(cycle=cycle).values  # NaN of joints that failed
    if seating_stress is not None:
        return base.residual_closure_seated_net.sel(cycle=cycle).values
    start = base.residual_closure.shift(cycle=1, fill_value=0.0)
    return (base.residual_closure - start).sel(cycle=cycle).values


def _by_steps(
    joint: xr.Dataset, cycle: int, branch: str, seating_stress: float | None
) -> _Branches:
    """Return a branch of one joint at all of its steps, and at seating if closure is net."""
    history = history_of(joint)
    here = history.branch(cycle, branch).steps
    stress = history.stress[here]
    if seating_stress is None:
        start = history.branch(cycle, LOADING).steps[0]
        closure = history.gross.values[here] - history.gross.values[start]
    else:  # from the first step above the seating stress, or to the last one
        seat = history.net.seat(cycle, LOADING)
        end = history.net.seat(cycle, branch)
        above = np.flatnonzero(stress > seating_stress)
        above = np.arange(above[0], here.size) if branch == LOADING else np.arange(above[-1] + 1)
        place = 0 if branch == LOADING else above.size
        closure = np.insert(history.net.values[here[above]], place, end) - seat
        stress = np.insert(stress[above], place, seating_stress)
    upwards = slice(None, None, 1 if branch == LOADING else -1)
    return _Branches(1e3 * closure[None, upwards], 1e-6 * stress[upwards])


def _draw_cycle(
    axes, base: xr.Dataset, cycle: int, chosen: int, seating_stress: float | None,
    history: xr.Dataset | None,
) -> None:  # fmt: skip
    """Draw a cycle of a base case: every surface, a band for loading, and the surface ``chosen``.

    The band is one standard deviation to each side of the mean. The chosen realisation, which is
    closest to the mean, is drawn by the steps of its ``history``; without it at stored stresses.
    """
    faint = 0.25 * min(1.0, _FEW_LINES / base.sizes["realization"]) ** 0.5
    colour = f"C{cycle - 1}"
    for branch, line in BRANCH_LINES.items():
        x, y = _stored(base, cycle, branch, seating_stress)
        if branch == LOADING:
            known = np.isfinite(x).any(axis=0)
            mean = np.nanmean(x[:, known], axis=0)
            spread = np.nanstd(x[:, known], axis=0, ddof=1)
            along = y[known]
            if seating_stress is None:  # as no line joins it to zero stress
                mean = mean[1:]
                spread = spread[1:]
                along = along[1:]
            axes.fill_betweenx(along, mean - spread, mean + spread, color=colour, alpha=0.18, lw=0)
        mark: dict[str, Any] = {"marker": "|", "ms": 6, "mew": 0.6, "markevery": [0]}
        axes.plot(x.T, y, color=colour, lw=0.4, alpha=faint, **mark)
        one = int(np.flatnonzero(base.realization.values == chosen)[0])
        bold = _Branches(x[one : one + 1], y)
        if history is not None:
            bold = _by_steps(history, cycle, branch, seating_stress)
        thick: dict[str, Any] = {"color": colour, "lw": 2.0, "ls": line}
        axes.plot(bold.closures[0], bold.stresses, path_effects=_OUTLINE, **thick)


def _mean_style(cycle: int) -> dict[str, Any]:
    return {"color": _DARK[1 + (cycle - 1) % len(_DARK)], "lw": 1.5, "ls": (0, (5, 1, 1, 1))}


def _draw_mean(axes, base: xr.Dataset, cycle: int, seating_stress: float | None) -> None:
    """Draw the mean closure of a cycle at those stresses that the most surfaces reach."""
    for branch in BRANCH_LINES:
        closures, stresses = _stored(base, cycle, branch, seating_stress)
        count = np.isfinite(closures).sum(axis=0)
        reached = count == count.max()
        mean = np.nanmean(closures[:, reached], axis=0)
        axes.plot(mean, stresses[reached], zorder=4, **_mean_style(cycle))


_QUANTITIES = {
    "hydraulic_aperture": ("_mm", "hydraulic aperture (mm)"),
    "ratio": ("", "hydraulic / mechanical aperture"),
}


@styled
def flow_figure(table: pd.DataFrame, rocks: dict[str, StudyRock], seating_stress: float) -> Figure:
    """Draw mean hydraulic apertures, and their ratios to mean apertures, for each rock's base case.

    ``table`` is that of `studies.paper.apertures.flow_table`; stresses below ``seating_stress``
    [Pa] are left out.
    """
    directions = list(dict.fromkeys(table.direction))
    kinds = [(name, direction) for name in _QUANTITIES for direction in directions]
    figure, panels = panel_grid(len(rocks), len(kinds), (3.5, 3.1), (0.0, 0.7), sharex="row")
    base = table[(table.parameter == "base") & (table.stress_MPa >= 1e-6 * seating_stress)]
    for row, (name, rock) in zip(panels, rocks.items(), strict=True):
        rows = base[base.rock == name]
        for axes, (quantity, direction) in zip(row, kinds, strict=True):
            _draw(axes, rows[rows.direction == direction], quantity)
            axes.set(
                title=f"{figure_text(rock.title)}, flow along {direction}",
                xlabel="normal stress (MPa)", ylabel=_QUANTITIES[quantity][1],
                xlim=(0.0, 1e-6 * rock.max_normal_stress),
            )  # fmt: skip
        for pair in (row[: len(directions)], row[len(directions) :]):
            top = max(axes.get_ylim()[1] for axes in pair)
            for axes in pair:
                axes.set_ylim(0.0, top)
    handles: list[Artist] = [
        key(color=f"C{cycle - 1}", lw=2, label=f"cycle {cycle}")
        for cycle in sorted(table.cycle.unique())
    ]
    handles += [
        *(key(f"mean, {name}", color="0.5", lw=2, ls=ls) for name, ls in BRANCH_LINES.items()),
        key(color="0.5", lw=1.2, ls=":", label="mechanical (mean) aperture, loading"),
        Rectangle((0, 0), 1, 1, color="0.5", alpha=0.25, label="loading ± 1 standard deviation"),
    ]
    legend_below(figure, handles)
    sns.despine(figure)
    return figure


def _draw(axes, table: pd.DataFrame, quantity: str) -> None:
    """Draw in a panel the mean of a quantity on each branch of each cycle; loading has a band."""
    unit = _QUANTITIES[quantity][0]
    # at stresses that only some joints reach, their mean would not represent all joints
    table = table[table.samples == table.samples.max()]
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        colour = f"C{cycle - 1}"
        stress = rows.stress_MPa.to_numpy()
        mean = rows[f"{quantity}_mean{unit}"].to_numpy()
        axes.plot(
            stress, mean, BRANCH_LINES[branch], color=colour, lw=2.0, zorder=above(cycle, branch)
        )
        if branch == UNLOADING:
            continue
        spread = np.nan_to_num(rows[f"{quantity}_standard_deviation{unit}"].to_numpy())
        low = np.maximum(mean - spread, 0.0)
        high = mean + spread
        axes.fill_between(stress, low, high, color=colour, alpha=0.18, lw=0)
        if quantity == "hydraulic_aperture":
            axes.plot(stress, rows.mean_aperture_mean_mm, ":", color=colour, lw=1.2)


def _panels(parameters: list[str], cycles: list[int], panel: tuple, margin=(0.0, 0.0), **shared):
    """Return a figure with a panel for each cycle (row) and parameter, and its panels by both.

    ``panel`` and ``margin`` are sizes [inches], see `panel_grid`.
    """
    shape = (len(cycles), len(parameters))
    figure, grid = panel_grid(*shape, panel, margin, **shared)
    named = dict(zip(itertools.product(cycles, parameters), grid.flat, strict=True))
    for (cycle, parameter), axes in named.items():
        axes.set_title(f"{PROPERTIES[parameter].title}, cycle {cycle}", fontsize=9)
    return figure, named


@styled
def interval_figure(table: pd.DataFrame, rocks: dict[str, StudyRock]) -> Figure:
    """Draw the lengths of indifference intervals, gross and net, for each rock, and the paper's.

    ``table`` is that of intervals, with those of the paper beside if it has these rocks.
    """
    parameters = list(dict.fromkeys(table.parameter))
    cycles = sorted(table.cycle.unique())
    figure, panels = _panels(parameters, cycles, (3.1, 2.9), (0.0, 0.8), sharex=True)
    names = list(rocks)
    for (cycle, parameter), axes in panels.items():
        part = table[(table.parameter == parameter) & (table.cycle == cycle)].set_index("rock")
        _draw_intervals(axes, part.reindex(names))
        axes.set_xticks(
            range(len(names)), [figure_text(rocks[n].title) for n in names], rotation=35
        )
        about = PROPERTIES[parameter]
        axes.set_ylabel(f"length of the interval of\n{about.title}{about.in_brackets}")
    handles: list[Artist] = [
        point_key(f"this study, {test_name(table)}, with 95 % bootstrap", color="C0"),
        point_key("net of bulk indentation, likewise", "s", color="C2", ms=4),
        point_key("hollow: extrapolated root", mfc="none", color="0.4"),
        point_key("no real root", "x", color="0.4"),
        key("bar extends beyond the panel", marker="^", color="0.4"),
    ]
    if "paper_length" in table:
        handles.insert(2, point_key(f"the paper, {UNPAIRED_TEST}", "D", color="C1"))
        handles.append(point_key("no real root in the paper", "x", color="C1"))
    legend_below(figure, handles)
    sns.despine(figure)
    return figure


def _draw_intervals(axes, part: pd.DataFrame) -> None:
    drawn = part.columns.intersection(["length", "length_net", "paper_length"])
    highest = np.nanmax(part[drawn].to_numpy(dtype=float), initial=0.0)
    top = 1.35 * highest if highest > 0.0 else 1.0
    for i, row in enumerate(part.itertuples()):
        if pd.isna(row.unit):  # the parameter is not varied for that rock
            continue
        if pd.notna(getattr(row, "paper_length", np.nan)):
            axes.plot(i + 0.22, row.paper_length, "D", color="C1", ms=5)
        elif getattr(row, "in_paper", False):
            axes.plot(i + 0.22, 0.97 * top, "x", color="C1")
        if pd.isna(row.length):
            axes.plot(i - 0.12, 0.97 * top, "x", color="0.4")
        for suffix, at, marker, colour in (
            ("", i - 0.12, "o", "C0"),
            ("_net", i + 0.05, "s", "C2"),
        ):
            length, low, high, extrapolated = (
                getattr(row, f"{name}{suffix}")
                for name in ("length", "length_low", "length_high", "extrapolated")
            )
            if pd.isna(length):
                continue
            axes.plot([at] * 2, [low, min(high, top)], color=colour, lw=1.0)
            if high > top:  # the bar extends beyond the panel
                axes.plot(at, top, "^", color=colour, ms=5, clip_on=False, zorder=3)
            fill = "none" if extrapolated else colour
            axes.plot(at, length, marker, color=colour, mfc=fill, ms=6 if suffix == "" else 4)
    axes.set_ylim(0.0, top)
    axes.set_xlim(-0.6, len(part) - 0.4)


@styled
def trend_figure(closures: pd.DataFrame, study: xr.Dataset, rocks: dict[str, StudyRock]) -> Figure:
    """Draw mean maximum gross closure, and closure net of bulk indentation, over each parameter.

    Values of the parameter are relative to the rock's own value; if there is one rock only, they
    are in the unit of the parameter. If cases have common surfaces, errors are those of the change
    from the base case on the same surfaces, in which the scatter of surfaces largely cancels.
    ``closures`` is the table of `max_closure_table`.
    """
    parameters = [p for p in PROPERTIES if (closures.parameter == p).any()]
    cycles = sorted(closures.cycle.unique())
    figure, panels = _panels(parameters, cycles, (3.1, 2.8), sharex="col", sharey="row")
    values = {p: dict(zip(study.case.values, study[p].values, strict=True)) for p in parameters}
    paired = CHANGE in closures
    for (cycle, parameter), axes in panels.items():
        here = (closures.cycle == cycle) & closures.parameter.isin([parameter, "base"])
        for i, (name, rock) in enumerate(rocks.items()):
            part = closures[here & (closures.rock == name)]
            if len(part) < 2:
                continue
            part = part.assign(at=part.case.map(values[parameter])).sort_values("at")
            base = part[part.parameter == "base"].iloc[0]
            scale = 1.0 / base["at"]
            if len(rocks) == 1:
                scale = in_unit(1.0, PROPERTIES[parameter].unit)
            mean = part.max_closure_mean_mm
            error = part.max_closure_mean_mm_standard_error
            if paired:  # the change from the base case, which itself has no error of a change
                mean = base.max_closure_mean_mm + part[CHANGE].where(part.parameter != "base", 0.0)
                error = part[f"{CHANGE}_standard_error"].where(part.parameter != "base", 0.0)
            style = {"color": f"C{i}"}
            label = figure_text(rock.title)
            axes.errorbar(
                scale * part["at"],
                mean,
                error,
                fmt="o-",
                ms=4,
                capsize=2,
                label=label,
                **style,
            )
            axes.plot(scale * part["at"], part.max_closure_net_mean_mm, "--", lw=1.0, **style)
        if cycle == cycles[-1]:
            about = PROPERTIES[parameter]
            own = f"{about.title}{about.in_brackets}"
            axes.set_xlabel(own if len(rocks) == 1 else "value / the rock's value")
        if parameter == parameters[0]:
            axes.set_ylabel("mean maximum\ngross closure (mm)")
    bar = "bar: ± standard error"
    if paired:
        bar += " of the change from\nthe rock's value (none there), on the same surfaces"
    handles = [
        *legend_keys([panels[cycles[0], parameters[0]]]),
        key("net of bulk indentation", color="0.4", ls="--", lw=1.0),
        point_key(bar, "|", color="0.4", ms=9),
    ]
    legend_below(figure, handles, max(1, len(parameters)))
    sns.despine(figure)
    return figure


_OURS, _NULL = "#2a6f97", "0.82"
"""Colours of repetitions of this study, and of studies in which no property has an effect."""
_RANGE = (0.5, 500.0)
"""Range of lengths on the axis [% of the rock's value]."""
_DASH = 900.0
"""Position of the column of dashes on that axis, beyond the range."""
_BINS = np.geomspace(*_RANGE, 61)
_TICKS = (1, 3, 10, 30, 100, 300)


@styled
def predictive_figure(
    drawn: xr.Dataset, paper: pd.DataFrame, rocks: dict[str, StudyRock], draws: int
) -> Figure:
    """Draw the distributions of lengths over repetitions, by the model and by the null model.

    The lengths of the paper are drawn too. ``drawn`` is the dataset of `lengths_dataset`, ``draws``
    is the number of surfaces of a repetition at each level.
    """
    parameters = [p for p in PROPERTIES if p in set(drawn.parameter.values.tolist())]
    cycles = sorted(set(drawn.cycle.values.tolist()))
    names = [name for name in rocks if name in set(drawn.rock.values.tolist())]
    panel = (3.6, 0.62 + 0.36 * len(names))
    figure, panels = panel_grid(
        len(parameters), len(cycles), panel, (0.0, 1.5), sharex=True, sharey="row"
    )
    columns = (drawn[name].values.tolist() for name in ("rock", "parameter", "cycle"))
    entries = list(zip(*columns, strict=True))
    published = paper.set_index(["rock", "parameter", "cycle"]).paper_percent
    for row, parameter in zip(panels, parameters, strict=True):
        for axes, cycle in zip(row, cycles, strict=True):
            for place, name in enumerate(names):
                entry = (name, parameter, cycle)
                if entry in entries:
                    one = drawn.isel(entry=entries.index(entry))
                    _draw_entry(axes, -place, one.percent.values, one.null_percent.values)
                    if entry in published.index:
                        _draw_published(axes, -place, float(published[entry]))
            axes.set_title(f"{PROPERTIES[parameter].title}, cycle {cycle}", fontsize=10)
            axes.set_yticks(
                [-i for i in range(len(names))], [figure_text(rocks[n].title) for n in names]
            )
            axes.tick_params(axis="y", length=0)
            axes.set_ylim(-len(names) + 0.38, 0.62)
            _scale(axes)
    for axes in panels[-1]:
        axes.set_xlabel("indifference interval,\n% of the rock's value")
    compared = bool(len(published.index.intersection(entries)))
    legend_below(figure, _handles(draws, compared), 1, fontsize=9.5)
    return figure


def _draw_entry(axes, y: float, ours: np.ndarray, null: np.ndarray) -> None:
    """Draw the lengths [%] of one rock at the height ``y`` of a panel.

    These are the densities of ``ours`` and of ``null`` (repetitions,), the median and 90 % range of
    ours, and the shares of dashes of both.
    """
    centres = np.sqrt(_BINS[:-1] * _BINS[1:])
    for values, style, zorder in (
        (null, {"color": _NULL, "lw": 0}, 1),
        (ours, {"facecolor": "none", "edgecolor": _OURS, "lw": 1.1}, 2),
    ):
        roots = values[(values >= _RANGE[0]) & (values <= _RANGE[1])]
        if roots.size:
            counts = np.histogram(roots, _BINS)[0] / values.size
            smooth = np.convolve(counts, (0.25, 0.5, 0.25), mode="same")
            top = y - 0.3 + 0.75 * smooth / smooth.max() * (roots.size / values.size)
            axes.fill_between(centres, y - 0.3, top, zorder=zorder, **style)
    low, middle, high = np.quantile(ours, [0.05, 0.5, 0.95], method="nearest")
    ends = np.clip([low, high], *_RANGE)
    axes.plot(ends, [y - 0.3] * 2, color=_OURS, lw=3.2, solid_capstyle="butt", zorder=3)
    if np.isfinite(middle):
        axes.plot([middle] * 2, [y - 0.38, y - 0.14], color=_OURS, lw=2.2, zorder=4)
    for values, place, colour in ((ours, y - 0.1, _OURS), (null, y - 0.4, "0.5")):
        share = 100.0 * np.mean(np.isinf(values))
        text = {"color": colour, "va": "center", "fontsize": 8.5}
        axes.text(1.45 * _DASH, place, f"{share:.0f} %", ha="center", **text)
        below = 100.0 * np.mean(values < _RANGE[0])
        if below >= 0.5:  # zeros too, which have no place on a logarithmic axis
            axes.text(1.05 * _RANGE[0], place, f"← {below:.0f} %", ha="left", **text)


def _draw_published(axes, y: float, percent: float) -> None:
    at = 0.78 * _DASH if np.isnan(percent) else np.clip(percent, *_RANGE)
    axes.plot(at, y - 0.3, "D", color="k", mec="w", mew=1.0, ms=7.5, zorder=6, clip_on=False)


def _scale(axes) -> None:
    axes.set_xscale("log")
    axes.set_xlim(_RANGE[0], 2000.0)
    axes.axvline(_RANGE[1] * 1.12, color="0.5", lw=0.7)
    ticks_at(axes.xaxis, [*_TICKS, _DASH], [*(str(tick) for tick in _TICKS), "–"])
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.grid(axis="x", color="0.92", lw=0.8, zorder=0)
    axes.set_axisbelow(True)


def _handles(draws: int, compared: bool) -> list:
    handles = [
        Patch(
            fc="none", ec=_OURS, lw=1.1, label=f"studies of {draws} pairs of walls, unpaired t test"
        ),
        key(color=_OURS, lw=3.2, label="their 5 to 95 % range; upright: median"),
        Patch(fc=_NULL, lw=0, label="if the property had no effect"),
    ]
    if compared:
        handles.append(point_key("the paper", "D", color="k", mec="w", ms=7.5))
    text = (
        "column –: no real root; shares of these studies,\nand (grey) if the property had no effect"
    )
    handles.append(point_key(text, r"$\%$", color=_OURS, ms=9))
    return handles


def study_figures(
    study: xr.Dataset,
    surfaces: xr.Dataset,
    intervals: pd.DataFrame,
    closures: pd.DataFrame,
    rocks: dict[str, StudyRock],
    seating_stress: float,
    wall_strength_ratio: float,
    *,
    curves: Mapping[str, MeasuredCurve] = MappingProxyType({}),
    fits: pd.DataFrame | None = None,
    flow: pd.DataFrame | None = None,
    report: Callable[[str], object] = lambda line: None,
) -> dict[str, Figure]:
    """Return the figures of a study by the names of their files.

    ``surfaces`` are those of its first case, ``intervals`` and ``closures`` its tables. ``curves``
    are the measured curves by rock, ``fits`` is the table of `fit_table`, and ``flow`` is that of
    `flow_table`; without these their figures are left out. ``report`` is called with a line on how
    many surfaces are drawn.
    """
    measured = Measurements() if fits is None else Measurements(curves, fits)
    drawn = np.union1d(study.realization.values[:MOST_DRAWN], measured.best)
    shown = study.sel(realization=drawn.astype(int)).load()
    report(f"curves of {shown.sizes['realization']} of {study.sizes['realization']} surfaces")
    first = next(iter(rocks.values()))
    walls = surfaces.isel(realization=0)
    title = f"{first.title}, {roughness_title(first)}, realisation 0"
    pair = walls.upper.values, walls.lower.values, surfaces.attrs["spacing_m"]
    figures = {
        "fig_3_equivalent_stress": equivalent_stress(),
        "fig_5_closure": closure_figure(shown, rocks, None, wall_strength_ratio),
        "closure_since_seating": closure_figure(
            shown, rocks, seating_stress, wall_strength_ratio, measured
        ),
        "wall_pair": wall_pair_figure(*pair, title),
    }
    if flow is not None:
        figures["hydraulic_aperture"] = flow_figure(flow, rocks, seating_stress)
    if any(rock.levels for rock in rocks.values()):
        figures["table_3_intervals"] = interval_figure(intervals, rocks)
        figures["trends_max_closure"] = trend_figure(closures, shown, rocks)
    return figures
