"""Figures of a joint: closure and its range, stiffness, laws and apertures."""

import textwrap
from collections.abc import Mapping

import numpy as np
import pandas as pd
import seaborn as sns
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from jointclosure.ensembles.quantities import CURVES
from jointclosure.joint.history import GROSS, NET, Branch, History, history_of
from jointclosure.joint.laws import LAWS, BartonBandis, loading_hyperbolas
from jointclosure.joint.result_tables import (
    WATER,
    columns_of,
    has_bands,
    stress_table,
    wider_columns_of,
)
from jointclosure.joint.status import LOADING
from jointclosure.plotting.style import BRANCH_LINES, above, decimal_ticks, styled, subplots
from jointclosure.uncertainty.budget import Budget
from jointclosure.uncertainty.numerical_error import limits_of_error
from jointclosure.uncertainty.ranged_results import CLOSURE_GROSS, CLOSURE_NET
from jointclosure.uncertainty.ranges import MEANT, NUMBERS, WIDER
from jointclosure.uncertainty.sources import ALL, TITLES

DECADES = 9  # of transmissivity that are drawn at most
SAME = 0.01  # difference of two branches over their largest value, below which they are one line
_SAME_TEXT = " (same as loading)"
_BOUND = "upper bound of the transmissivity"
_FLOW = "transmissivity_m2_per_s"
_BANDS_END = (
    "bands of transmissivity are left out at stresses at which some joints of the range are blocked"
)
_OF_CYCLES = ["Barton-Bandis", _BOUND]
"""Curves that have the colours of their cycles, and one entry of a neutral colour in a legend."""
_SEEN = ["normal_stiffness_net_MPa_per_mm", "mean_aperture_mm"]
"""Columns whose branches are compared."""
_CHOICES = "with other choices of the model"
"""End of the names of wider bands."""
_KINDS = (*BRANCH_LINES, "range", _CHOICES)
"""Curves and bands of a cycle, in the order of a column of the legend."""
LOGARITHMIC = 3.0
"""Ratio of the largest to the smallest result of a figure from which its axis is logarithmic."""
AS_REGISTERED = "as registered, usual values"
"""Name of the joint itself beside its range, in whose middle it need not be."""


@styled
def closure_curve(closed: xr.Dataset, title: str, ranges: pd.DataFrame | None = None) -> Figure:
    """Draw stress [MPa] over gross and net closure [mm] since seating, in two panels.

    ``ranges`` are as in `Budget.ranges`. They are drawn at the maximum stress, each cycle above the
    one before.
    """
    figure, panels = subplots(1, 2, figsize=(10.4, 4.8), title=title, sharex=True, sharey=True)
    columns = {GROSS: CLOSURE_GROSS, NET: CLOSURE_NET}
    for axes, (of, column) in zip(panels, columns.items(), strict=True):
        if ranges is not None:
            # at the largest stress, each cycle above the one before
            for row, (cycle, ends) in enumerate(ranges.xs(column, level=1).iterrows(), start=1):
                stress = 1e-6 * float(closed.normal_stress.max())
                axes.errorbar(
                    ends.best, stress * (1.0 + 0.03 * row),
                    xerr=[[ends.best - ends.low], [ends.high - ends.best]], fmt="o", ms=4,
                    capsize=3, color=f"C{cycle - 1}", label=f"cycle {cycle}, range",
                )  # fmt: skip
        draw_curves(axes, closed, "seating", of)
    panels[1].set(ylabel="")
    if panels[0].get_legend():  # below the panels, where no curve is
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        for axes in panels:
            axes.get_legend().remove()
    sns.despine(figure)
    return figure


@styled
def range_figure(budget: Budget, title: str) -> Figure:
    """Draw how far each source of uncertainty moves the net closure of the first and last cycle.

    Above the sources are the range and the joints with random values of all sources. The legend
    says what the percentages are.
    """
    ranges = budget.ranges.xs(CLOSURE_NET, level="quantity")
    cycles = list(dict.fromkeys(ranges.index[[0, -1]]))
    figure, panels = subplots(
        1, len(cycles), figsize=(6.4 * len(cycles), 4.4), title=title, squeeze=False
    )
    limits = limits_of_error(budget.numerical)
    for axes, cycle in zip(panels[0], cycles, strict=True):
        row = ranges.loc[cycle]
        results = budget.results[budget.results.cycle == cycle]
        shares = row.drop(NUMBERS).astype(float).dropna()
        hidden = shares.index.isin(budget.undetermined_shares(cycle, CLOSURE_NET))
        shares = shares.iloc[np.lexsort((hidden, shares))]  # above those that have no share
        for place, name in enumerate(shares.index):
            values = results.loc[results.source == name, CLOSURE_NET].to_numpy()
            axes.plot([row.best, *values], [place] * (1 + values.size), "-", color="0.6")
            label = (
                None if place else "one source alone at an end of its range, or with random inputs"
            )
            axes.plot(values, [place] * values.size, "o", color="C0", label=label)
        drawn = results.loc[results.source == ALL, CLOSURE_NET].to_numpy()
        limit = limits.get((cycle, CLOSURE_NET))
        if limit is not None and "breakage" in shares.index:
            ends = [row.best / (1.0 + limit), row.best * (1.0 + limit)]
            place = shares.index.get_loc("breakage")
            label = "limit of the numerical error, which the range contains"
            axes.plot(ends, [place] * 2, "|-", color="C0", lw=1, ms=8, label=label)
        label = f"range, {MEANT}"
        axes.plot([row.low, row.high], [len(shares)] * 2, "-", color="C1", lw=3, label=label)
        if budget.choices:
            label = "with other choices of the model"
            axes.plot(row[WIDER], [len(shares)] * 2, "-", color="C1", lw=1, label=label)
        label = "joints with random values of all sources"
        axes.plot(drawn, [len(shares) + 0.35] * drawn.size, "|", color="C1", ms=5, label=label)
        axes.plot(row.best, len(shares), "o", color="C1", label=AS_REGISTERED)
        axes.axvline(row.best, color="0.8", lw=0.8, zorder=0)
        labels = [
            f"{TITLES[name]} ({budget.share_text(cycle, CLOSURE_NET, name)})"
            for name in shares.index
        ]
        axes.set_yticks(range(len(shares) + 1), [*labels, "all together"])
        xlabel = f"net closure since seating, cycle {cycle} (mm)"
        shown = np.concatenate([np.ravel(line.get_xdata()) for line in axes.lines[:-1]])
        if 0.0 < LOGARITHMIC * shown.min() < shown.max():
            axes.set(xscale="log", xlim=(0.85 * shown.min(), shown.max() / 0.85))
            decimal_ticks(axes.xaxis)
            xlabel += ", logarithmic"
        axes.set(xlabel=xlabel)
    named = panels[0, 0].get_legend_handles_labels()
    about = textwrap.fill(
        f"in brackets, shares of sources: {budget.about_shares()}", 60 * len(cycles)
    )
    figure.legend(*named, loc="outside lower center", ncols=len(cycles), frameon=False, title=about)
    sns.despine(figure)
    return figure


def draw_curves(axes: Axes, closed: xr.Dataset, since: str = "touch", of: str = NET) -> None:
    """Draw stress [MPa] over the closure [mm] of a joint, a colour for each cycle.

    ``of`` is `NET` or `GROSS`. Loading is solid and unloading dashed. Closure counts ``since``
    first "touch", "seating" on the loading of each cycle, or the start of the "cycle". Up to five
    cycles have a legend.
    """
    history = history_of(closed)
    curve = history.curve(of)
    seating = history.seating_stress
    for cycle in history.cycles:
        zero = 0.0
        if since == "seating":
            zero = curve.seat(cycle.number, LOADING)
        elif since == "cycle":
            zero = curve.values[cycle.loading.steps[0]]
        for branch in cycle.branches:
            closure = curve.values[branch.steps]
            stress = history.stress[branch.steps]
            if since == "seating":  # from its point at the seating stress
                over = stress > seating
                end = 0 if branch.name == LOADING else int(over.sum())
                seat = curve.seat(cycle.number, branch.name)
                closure = np.insert(closure[over], end, seat)
                stress = np.insert(stress[over], end, seating)
            axes.plot(
                1e3 * (closure - zero),
                1e-6 * stress,
                BRANCH_LINES[branch.name],
                color=f"C{cycle.number - 1}",
                zorder=above(cycle.number, branch.name),
                label=f"cycle {cycle.number}, {branch.name}{_hidden(history, of, branch)}",
            )
    words = {"touch": "from first touch", "cycle": "from the cycle's start"}
    words["seating"] = f"since seating at {1e-6 * seating:g} MPa"
    kind = "net" if of == NET else "gross"
    axes.set(xlabel=f"{kind} closure {words[since]} (mm)")
    axes.set(ylabel="normal stress (MPa)", ylim=0.0)
    if history.begun <= 5:
        axes.legend(frameon=False)


def _hidden(history: History, of: str, branch: Branch) -> str:
    """Return what the legend adds to an unloading that lies on the loading of its cycle.

    It is empty for a loading, and if the two closures ``of`` the joint differ by more than `SAME`.
    """
    if branch.name == LOADING:
        return ""
    up, down = history.curve(of).at(history.table_levels())[branch.cycle - 1]
    known = np.isfinite(up) & np.isfinite(down)
    apart = np.abs(down - up)[known]
    same = apart.size > 0 and apart.max() <= SAME * np.ptp(up[known])
    return _SAME_TEXT if same else ""


def draw_stiffness(axes: Axes, curves: pd.DataFrame) -> None:
    """Draw the net tangent stiffness over stress from a `stress_table`, with its bands if known."""
    _draw_along(axes, curves, "normal_stiffness_net_MPa_per_mm")
    axes.set(yscale="log")
    axes.legend(frameon=False, fontsize=8)
    decimal_ticks(axes.yaxis)


def _draw_along(axes: Axes, curves: pd.DataFrame, name: str, across: bool = False) -> None:
    """Draw the column ``name`` of a `stress_table` over stress, by cycle and branch.

    Loadings have their bands. With ``across`` the stress is the vertical axis; the labels are those
    of a horizontal one, and the caller changes them.
    """
    fill = axes.fill_betweenx if across else axes.fill_between
    cycles = int(curves.cycle.max())
    for (cycle, branch), rows in curves.groupby(["cycle", "branch"], sort=False):
        # later cycles are thinner and above, so that equal curves are all seen
        order = 2.0 + 0.01 * cycle
        colour = f"C{cycle - 1}"
        width = 1.2 + 1.4 * (cycles - cycle) / max(1, cycles - 1)
        stress = rows.normal_stress_MPa
        label = _branch_label(curves, cycle, branch)
        if has_bands(curves) and branch == LOADING:
            low, high = (rows[f"{name}_{end}"] for end in ("low", "high"))
            wider = wider_columns_of(curves, name)
            if wider:  # thin lines along it, not across: dashes are unloadings
                outer = [rows[end] for end in wider]
                pale: dict = {"color": colour, "alpha": 0.1, "lw": 0.0, "zorder": 0.5}
                fill(stress, *outer, label=f"cycle {cycle}, {_CHOICES}", **pale)
                edges = [
                    np.column_stack((end, stress) if across else (stress, end)) for end in outer
                ]
                thin = LineCollection(edges, colors=colour, linewidths=0.6, zorder=0.6)
                axes.add_collection(thin, autolim=False)
            band = f"cycle {cycle}, range"
            fill(stress, low, high, color=colour, alpha=0.4, lw=0.0, label=band)
        at = (rows[name], stress) if across else (stress, rows[name])
        line = {"color": colour, "label": label, "zorder": order, "lw": width}
        axes.plot(*at, BRANCH_LINES[branch], **line)
    axes.set(xlabel="normal stress (MPa)", ylabel=CURVES[name][0], xlim=0.0)


def _branch_label(curves: pd.DataFrame, cycle: int, branch: str) -> str:
    """Return the entry of a branch in a legend, such as "cycle 1, loading".

    An unloading whose stiffness and aperture in the `stress_table` differ from those of the loading
    by at most `SAME` is said to be the same.
    """
    label = f"cycle {cycle}, {branch}"
    of_cycle = curves[curves.cycle == cycle].set_index("normal_stress_MPa")
    up, down = (of_cycle.loc[of_cycle.branch == name, _SEEN] for name in (LOADING, branch))
    apart = (down - up).abs().max() > SAME * up.abs().max()
    return label if branch == LOADING or apart.any() else f"{label}{_SAME_TEXT}"


@styled
def engineering_figure(
    joint: xr.Dataset,
    title: str,
    curves: pd.DataFrame | None = None,
    laws: Mapping[int, BartonBandis] = {},
) -> Figure:
    """Draw closure with its laws, tangent stiffness, aperture and transmissivity over stress.

    ``curves`` is the `stress_table` of the joint, with bands if they are known; by default it is
    made without them. ``laws`` are those of Barton and Bandis, by cycle. The transmissivity is
    drawn if the joint has flow.
    """
    curves = stress_table(joint) if curves is None else curves
    has_flow = history_of(joint).has_flow
    shape, size = ((2, 2), (10.4, 9.2)) if has_flow else ((1, 3), (13.5, 6.0))
    figure, panels = subplots(*shape, figsize=size, title=title)
    panels = panels.ravel()
    _draw_closure(panels[0], joint, curves, laws)
    draw_stiffness(panels[1], curves)
    panels[1].set_title("tangent stiffness")
    _draw_along(panels[2], curves, "mean_aperture_mm")
    panels[2].set(title="mean aperture", ylim=(0.0, None))
    if has_flow:
        _draw_flow(panels[3], curves)
        panels[3].set_xlim(panels[2].get_xlim())  # also where nothing flows
    named: dict[str, Artist] = {}
    for axes in panels:
        sns.despine(ax=axes)
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            named.setdefault(label, handle)
        if axes.get_legend():
            axes.get_legend().remove()
    for label in named.keys() & set(_OF_CYCLES):
        drawn = named[label]
        if isinstance(drawn, Line2D):
            style, width = drawn.get_linestyle(), drawn.get_linewidth()
            named[label] = Line2D([], [], color="0.25", ls=style, lw=width)
    _legend_of_cycles(figure, named, int(curves.cycle.max()), _about_bands(curves))
    return figure


def _about_bands(curves: pd.DataFrame) -> str:
    """Return the title of a legend that says what the bands contain; empty without bands."""
    if not has_bands(curves):
        return ""
    about = f"dark bands: ranges, which are {MEANT}"
    if wider_columns_of(curves, "mean_aperture_mm"):
        about += f"\npale bands: the same {_CHOICES}"
    loading = curves[curves.branch == LOADING].dropna(subset="closure_net_since_seating_mm")
    if not all((loading[low] > 0.0).all() for low, _ in _bands_of_flow(curves)):
        about += f"\n{_BANDS_END}"
    return about


def _bands_of_flow(curves: pd.DataFrame) -> list[list[str]]:
    """Return the columns of both ends of each band of transmissivity; none without bands."""
    bands = columns_of(curves, _FLOW)[1:], wider_columns_of(curves, _FLOW)
    return [ends for ends in bands if ends]


def _open_bands(curves: pd.DataFrame) -> pd.DataFrame:
    """Return curves with bands of transmissivity only where their low ends are above 0.

    A lower end of 0, of a joint whose flow is blocked, has no place on a logarithmic axis.
    """
    above = {_FLOW: curves[_FLOW].where(curves[_FLOW] > 0.0)}
    for low, high in _bands_of_flow(curves):
        above |= {end: curves[end].where(curves[low] > 0.0) for end in (low, high)}
    return curves.assign(**above)


def _legend_of_cycles(figure: Figure, named: Mapping[str, Artist], cycles: int, title: str) -> None:
    """Put a legend below all panels, with a column for each cycle and one for everything else.

    ``named`` are its entries by label. Four cycles and more have as many columns as fit.
    """
    of_cycle: dict[int, list[str]] = {number: [] for number in range(1, cycles + 1)}
    others: list[str] = []
    for label in named:
        number = next((one for one in of_cycle if label.startswith(f"cycle {one}, ")), None)
        (others if number is None else of_cycle[number]).append(label)
    for column in of_cycle.values():
        column.sort(key=_kind)
    columns = [*of_cycle.values(), *([others] if others else [])]
    rows = max(map(len, columns))
    blank = Line2D([], [], ls="")
    entries = [
        (named[label], label) if label else (blank, "")
        for column in columns
        for label in (*column, *[""] * (rows - len(column) if cycles < 4 else 0))
    ]
    handles, labels = zip(*entries, strict=True)
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(len(columns), 4), frameon=False,
        fontsize=9, title=title or None, title_fontsize=9,
    )  # fmt: skip


def _kind(label: str) -> int:
    """Return the place of an entry of the legend among the entries of its cycle, from 0."""
    words = label.partition(", ")[2].removesuffix(_SAME_TEXT)
    return _KINDS.index(words)


def _draw_closure(
    axes, joint: xr.Dataset, curves: pd.DataFrame, laws: Mapping[int, BartonBandis]
) -> None:
    """Draw the loading of each cycle with its fitted hyperbola, and the empirical ``laws``.

    Closures count from the seating of their cycle; the laws are those of Barton and Bandis.
    """
    loading = curves[curves.branch == LOADING]
    _draw_along(axes, loading, "closure_net_since_seating_mm", across=True)
    history = history_of(joint)
    seating = 1e-6 * history.seating_stress
    stress = np.linspace(seating, float(loading.normal_stress_MPa.max()), 100)
    middle = "closure_net_since_seating_mm"
    law = LAWS["hyperbolic"]
    cycles = loading.dropna(subset=middle).cycle.unique()
    for number, (cycle, constants) in enumerate(loading_hyperbolas(joint, cycles).iterrows()):
        fitted = law.closure(stress, seating, *constants)
        label = None if number else "hyperbolas fitted"
        if np.isfinite(fitted).all():  # not beyond a former maximum, or of a curve without bend
            axes.plot(fitted, stress, ":", color="0.25", lw=1.0, label=label)
        if cycle in laws:
            empirical = 1e3 * laws[cycle].closure(1e6 * (stress - seating))
            style = {"label": None if number else "Barton-Bandis", "lw": 1.0}
            axes.plot(empirical, stress, "-.", color=f"C{cycle - 1}", **style)
    axes.autoscale(axis="x")  # all curves and laws are inside
    axes.set(title="closure on loading", ylim=0.0, ylabel="normal stress (MPa)", xlim=0.0)
    axes.set(xlabel=f"net closure since seating at {seating:g} MPa (mm)")


def _draw_flow(axes, curves: pd.DataFrame) -> None:
    """Draw the transmissivity over stress where it is known and above 0, and its upper bound.

    The bound is dotted. Bands end where joints of the range are blocked (`_open_bands`). The axis
    is logarithmic, with the limits of what is drawn, and at most `DECADES` below the largest value;
    if no transmissivity is above 0, it is left as it is.
    """
    shown = _open_bands(curves)
    _draw_along(axes, shown, _FLOW)
    axes.set(ylabel=CURVES[_FLOW][0].replace("m2", "m²"))
    for cycle, rows in curves[curves.branch == LOADING].groupby("cycle"):
        bound = WATER * (1e-3 * rows[columns_of(curves, "largest_hydraulic_mm")[-1]]) ** 3
        label = _BOUND if cycle == 1 else None
        axes.plot(rows.normal_stress_MPa, bound, ":", color=f"C{cycle - 1}", label=label)
    axes.set(title="transmissivity")
    if not (curves[_FLOW] > 0.0).any():
        return
    drawn = np.concatenate([np.ravel(line.get_ydata()) for line in axes.lines])
    if has_bands(curves):
        ends = shown.loc[shown.branch == LOADING, columns_of(curves, _FLOW)]
        drawn = np.append(drawn, ends.to_numpy())
    drawn = drawn[drawn > 0.0]
    least = max(drawn.min(), 10.0**-DECADES * drawn.max())
    axes.set(yscale="log", ylim=(0.7 * least, 1.4 * drawn.max()))
