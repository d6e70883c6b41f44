"""Trends, indifference intervals and predictions of a study as figures."""

import numpy as np
import pandas as pd
import seaborn as sns
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from jointclosure.parameters import PROPERTIES
from jointclosure.plotting.style import panel_grid, styled
from studies.frame.panels import key, keys_of, legend_below, point_key, ticks_at
from studies.frame.rocks import StudyRock
from studies.paper.layout import UNPAIRED_TEST, test_name


@styled
def interval_figure(table: pd.DataFrame, rocks: dict[str, StudyRock]) -> Figure:
    """Draw indifference intervals of this study and of the paper, by parameter and cycle."""
    parameters = list(dict.fromkeys(table.parameter))
    cycles = sorted(table.cycle.unique())
    shape, margin = (len(cycles), len(parameters)), (0.0, 0.8)
    figure, panels = panel_grid(*shape, (3.1, 2.9), margin, sharex=True)
    names = list(rocks)
    for row, cycle in zip(panels, cycles, strict=True):
        for axes, parameter in zip(row, parameters, strict=True):
            part = table[(table.parameter == parameter) & (table.cycle == cycle)].set_index("rock")
            _draw_intervals(axes, part.reindex(names))
            axes.set_xticks(range(len(names)), [rocks[n].title for n in names], rotation=35)
            axes.set_title(f"{PROPERTIES[parameter].title}, cycle {cycle}", fontsize=9)
            axes.set_ylabel(f"length{PROPERTIES[parameter].in_brackets if len(part) else ''}")
    handles: list[Artist] = [
        point_key(f"this study, {test_name(table)}, with 95 % bootstrap", color="C0"),
        point_key("the same, extrapolated root", mfc="none", color="C0"),
        point_key("net of bulk indentation", "s", color="C2", ms=4),
        point_key("no real root", "x", color="0.4"),
        key("bar extends beyond the panel", marker="^", color="C0"),
    ]
    if "paper_length" in table:
        handles.insert(3, point_key(f"the paper, {UNPAIRED_TEST}", "D", color="C1"))
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
        else:
            ends = [row.length_low, min(row.length_high, top)]
            axes.plot([i - 0.12] * 2, ends, color="C0", lw=1.0)
            if row.length_high > top:  # the bar extends beyond the panel
                axes.plot(i - 0.12, top, "^", color="C0", ms=6, clip_on=False, zorder=3)
            fill = "none" if row.extrapolated else "C0"
            axes.plot(i - 0.12, row.length, "o", color="C0", mfc=fill, ms=6)
        if pd.notna(row.length_net):
            axes.plot(i + 0.05, row.length_net, "s", color="C2", ms=4)
    axes.set_ylim(0.0, top)
    axes.set_xlim(-0.6, len(part) - 0.4)


@styled
def trend_figure(closures: pd.DataFrame, study: xr.Dataset, rocks: dict[str, StudyRock]) -> Figure:
    """Draw mean maximum closure over each parameter, relative to the base case."""
    parameters = [p for p in PROPERTIES if (closures.parameter == p).any()]
    cycles = sorted(closures.cycle.unique())
    figure, panels = panel_grid(
        len(cycles), len(parameters), (3.1, 2.8), sharex="col", sharey="row"
    )
    values = {p: dict(zip(study.case.values, study[p].values, strict=True)) for p in parameters}
    for row, cycle in zip(panels, cycles, strict=True):
        for axes, parameter in zip(row, parameters, strict=True):
            here = (closures.cycle == cycle) & closures.parameter.isin([parameter, "base"])
            for i, (name, rock) in enumerate(rocks.items()):
                part = closures[here & (closures.rock == name)]
                if len(part) < 2:
                    continue
                part = part.assign(at=part.case.map(values[parameter])).sort_values("at")
                at = part["at"] / part["at"][part.parameter == "base"].iloc[0]
                mean, label = part.max_closure_mean_mm, f"{rock.title}, ± standard error"
                error, style = part.max_closure_mean_mm_standard_error, {"color": f"C{i}"}
                axes.errorbar(at, mean, error, fmt="o-", ms=4, capsize=2, label=label, **style)
                axes.plot(at, part.max_closure_net_mean_mm, "--", lw=1.0, **style)
            axes.set_title(f"{PROPERTIES[parameter].title}, cycle {cycle}", fontsize=9)
            if cycle == cycles[-1]:
                axes.set_xlabel("value / the rock's value")
        row[0].set_ylabel("mean maximum closure (mm)")
    net = key("net of bulk indentation", color="0.4", ls="--", lw=1.0)
    legend_below(figure, [*keys_of([panels[0][0]]), net], max(1, len(parameters)))
    sns.despine(figure)
    return figure


_OURS, _NULL = "#2a6f97", "0.82"
_RANGE = (0.5, 500.0)
"""Range of the axis, in percent of the rock's value."""
_DASH = 900.0
"""Position of the column of dashes on that axis, beyond the range."""
_BINS = np.geomspace(*_RANGE, 61)
_TICKS = (1, 3, 10, 30, 100, 300)


@styled
def predictive_figure(
    drawn: xr.Dataset, paper: pd.DataFrame, rocks: dict[str, StudyRock], draws: int
) -> Figure:
    """Draw predicted lengths over repetitions of the study, of the null model, and of the paper."""
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
            axes.set_yticks([-i for i in range(len(names))], [rocks[n].title for n in names])
            axes.tick_params(axis="y", length=0)
            axes.set_ylim(-len(names) + 0.38, 0.62)
            _scale(axes)
    for axes in panels[-1]:
        axes.set_xlabel("interval, % of the rock's value")
    compared = bool(len(published.index.intersection(entries)))
    legend_below(figure, _handles(draws, compared), 1, fontsize=9.5)
    return figure


def _draw_entry(axes, y: float, ours: np.ndarray, null: np.ndarray) -> None:
    """Draw one rock's row: densities, median and 90 % range of the model, and shares of dashes."""
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
    share = 100.0 * np.mean(np.isinf(ours))
    axes.text(_DASH, y - 0.26, f"{share:.0f} %", color=_OURS, ha="center", va="center", fontsize=9)


def _draw_published(axes, y: float, percent: float) -> None:
    at = (_DASH, y + 0.12) if np.isnan(percent) else (np.clip(percent, *_RANGE), y - 0.3)
    axes.plot(*at, "D", color="k", mec="w", mew=1.0, ms=7.5, zorder=6, clip_on=False)


def _scale(axes) -> None:
    axes.set_xscale("log")
    axes.set_xlim(_RANGE[0], 1500.0)
    axes.axvline(_RANGE[1] * 1.12, color="0.5", lw=0.7)
    ticks_at(axes.xaxis, [*_TICKS, _DASH], [*(str(tick) for tick in _TICKS), "–"])
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.grid(axis="x", color="0.92", lw=0.8, zorder=0)
    axes.set_axisbelow(True)


def _handles(draws: int, compared: bool) -> list:
    handles = [
        Patch(fc="none", ec=_OURS, lw=1.1, label=f"studies of {draws} draws, unpaired t test"),
        key(color=_OURS, lw=3.2, label="their 5 to 95 % range; upright: median"),
        Patch(fc=_NULL, lw=0, label="if the property had no effect"),
    ]
    if compared:
        handles.append(point_key("the paper", "D", color="k", mec="w", ms=7.5))
    text = "column –: no real root (share in this study)"
    handles.append(key(text, ls="", color=_OURS))
    return handles
