"""Work-precision figures of an accuracy study: error over time."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.settings import BASE
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled, subplots
from studies.accuracy.labels import Label, label_marks
from studies.frame.panels import keys_of, legend_below, point_key

KNOB_TITLES = {
    "steps": "both steps",
    "paper_steps": "both steps",
    "displacement_step": "displacement step",
    "breakage_step": "breakage step",
    "resolved": "resolved breakage, tolerance",
    "paper_resolved": "resolved breakage, tolerance",
    "force_tolerance": "residual of equilibrium",
    "paper_tolerances": "tight tolerances",
    "stress_tolerance": "landing on the maximum",
    "sweep_tolerance": "the paper's loop, change of a sweep",
}
SCENE_TITLES = {
    "contacts_alone": "contacts without interaction",
    "elastic": "nothing breaks",
    "full": "the model as stated",
    "regularised": "radii bounded",
    "paper_size": "the paper's size and stress",
}
_FRONT = "none is faster and more exact; hollow marks count as equal"
_FLOOR = 0.01
_NEAR_TIME, _NEAR_ERROR = 1.15, 1.6
"""Ratios of times and of errors to the star's below which marks are not labelled."""
_HARDLY_SEEN = 0.1
"""Percentage below which a bar is labelled with its value."""


@styled
def work_precision(costs: pd.DataFrame, title: str, paper: str) -> Figure:
    """Draw the error of the mean maximum closure over time, for one variant of the model.

    There is a panel for each rock and cycle. Hollow marks have a confidence interval that
    includes zero: their error is not significantly different from zero. Errors below a hundredth
    of a percent are drawn there. The finest setting, which is the reference, is not drawn. The
    grey line is the Pareto front. Errors that are not significantly different from zero have no
    order, so that it ends at the fastest hollow mark. Marks are labelled with the value of the
    setting if there is room, and if they are not beside the star.
    """
    shown = costs[~costs.other_joints]
    rocks, cycles = shown.rock.unique(), sorted(shown.cycle.unique())
    figure, panels = panel_grid(
        len(cycles), len(rocks), (4.8, 3.4), (0.0, 1.2), sharex=True, sharey=True
    )
    knobs = [knob for knob in shown.knob.unique() if knob != BASE]
    colours = dict(zip(knobs, sns.color_palette("colorblind", len(knobs)), strict=True))
    values = []
    for row, cycle in zip(panels, cycles, strict=True):
        for axes, rock in zip(row, rocks, strict=True):
            part = shown[(shown.rock == rock) & (shown.cycle == cycle)]
            values.append(_draw(axes, part, colours, paper))
            axes.set_title(f"{rock.replace('_', ' ').capitalize()}, cycle {cycle}")
    for axes in panels[-1]:
        axes.set_xlabel("time a simulation / that of the marked setting")
    for row in panels:
        row[0].set_ylabel("error of mean max. closure (%)")
    entries = {str(entry.get_label()): entry for entry in keys_of(panels.flat)}
    entries[paper] = point_key(paper, "*", color="k", ms=13)
    hollow = point_key("not significantly different from zero", color="0.3", mfc="w", ms=5)
    legend_below(figure, [*entries.values(), hollow], 3)
    figure.suptitle(title, x=0.01, ha="left")
    sns.despine(figure)
    for axes, labels in zip(panels.flat, values, strict=True):
        label_marks(axes, labels)
    return figure


def _draw(axes: Axes, part: pd.DataFrame, colours: dict, paper: str) -> list[Label]:
    """Draw a panel and return the labels of its marks."""
    size = part.mean_error_percent.abs().clip(lower=_FLOOR)
    part = part.assign(size=size, known=(part.mean_low > 0.0) | (part.mean_high < 0.0))
    base = part[part.knob == BASE].iloc[0]
    labels = []
    for knob, colour in colours.items():
        line = part[(part.knob == knob) & (part.mean_error_percent != 0.0)]
        if line.empty:
            continue
        # named settings have no order; the table lists them
        numbers = pd.to_numeric(line["value"], errors="coerce").notna().all()
        axes.plot(
            line.relative_time,
            line["size"],
            linestyle="-" if numbers else "none",
            marker="" if numbers else "o",
            color=colour,
            lw=1,
            ms=5,
            label=KNOB_TITLES.get(knob, knob),
        )
        for known, face in ((True, colour), (False, "w")):
            marked = line[line.known == known]
            axes.plot(marked.relative_time, marked["size"], "o", color=colour, mfc=face, ms=5)
        labels += [
            Label(f"{float(entry.value):g}", entry.relative_time, entry.size, colour)
            for entry in (line.itertuples() if numbers else ())
            if not _near(entry, base)
        ]
    axes.plot(
        [base.relative_time], [base["size"]], "k*", ms=13, mfc="k" if base.known else "w", zorder=4,
        label=paper,
    )  # fmt: skip
    # the finest setting is the reference: its error is unknown here
    part = part[part.mean_error_percent != 0.0]
    exact = part["size"].where(part.known, 0.0)  # insignificant errors count as equal
    best = part.iloc[front(part.relative_time.to_numpy(), exact.to_numpy())]
    axes.plot(
        best.relative_time, best["size"], drawstyle="steps-post", color="0.6", lw=4, alpha=0.5,
        zorder=0, label=_FRONT,
    )  # fmt: skip
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        decimal_ticks(axis)
    return labels


def _near(entry, base: pd.Series) -> bool:
    """Return whether a mark is so near to the star that its label would not be read as its own."""
    times, sizes = entry.relative_time / base.relative_time, entry.size / base["size"]
    return abs(np.log(times)) < np.log(_NEAR_TIME) and abs(np.log(sizes)) < np.log(_NEAR_ERROR)


@styled
def error_sources(sources: pd.DataFrame, title: str) -> Figure:
    """Draw the error of the paper's setting, split by its sources."""
    sources = sources.assign(kind=sources.source.str.split(" (", regex=False).str[0])
    kinds = list(dict.fromkeys(sources.kind))
    groups = list(sources.groupby(["rock", "cycle"], sort=False))
    figure, axes = subplots(figsize=(7.2, 3.6))
    width = 0.8 / len(kinds)
    for k, kind in enumerate(kinds):
        places, rows = [], []
        for g, (_, part) in enumerate(groups):
            for row in part[part.kind == kind].itertuples():
                places.append(g + (k - 0.5 * (len(kinds) - 1)) * width)
                rows.append(row)
        sizes = [abs(row.error_percent) for row in rows]
        axes.bar(places, sizes, width, color=f"C{k}", label=kind)
        for x, size, row in zip(places, sizes, rows, strict=True):
            low, high = _span(row)
            if np.isfinite(high):
                axes.plot([x, x], [low, high], color="0.1", lw=1)
            if size < _HARDLY_SEEN:
                top = max(size, high) if np.isfinite(high) else size
                axes.annotate(
                    f"{size:.1g}", (x, top), (0, 2), textcoords="offset points", ha="center",
                    fontsize=7,
                )  # fmt: skip
    names = [f"{rock.replace('_', ' ').capitalize()}\ncycle {cycle}" for (rock, cycle), _ in groups]
    axes.set_xticks(range(len(groups)), names)
    axes.set(ylabel="error, either sign (% of the mean)", title=title)
    axes.legend(frameon=False)
    sns.despine(figure)
    return figure


def _span(row) -> tuple[float, float]:
    """Return the ends of the interval of the size of an error; from 0 if it includes zero."""
    low, high = sorted((abs(row.low), abs(row.high)))
    return (0.0 if row.low * row.high < 0.0 else low), high


def front(seconds: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Return indices of the Pareto front of time and error, by ascending time."""
    order = np.lexsort((errors, seconds))
    best = np.minimum.accumulate(errors[order])
    first = np.concatenate([[True], best[1:] < best[:-1]])
    return order[first]
