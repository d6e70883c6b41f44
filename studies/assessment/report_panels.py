"""Small figures of the assessment in the report of a study, for its first screen."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from jointclosure.joint.status import LARGEST_UNBREAKABLE_SHARE
from jointclosure.plotting.style import decimal_ticks, percent_ticks, styled, subplots
from jointclosure.statistics.number_texts import percent
from studies.assessment.report_tables import (
    ALL_ROCKS,
    EFFECTS,
    SETTING,
)
from studies.frame.panels import key, point_key
from studies.paper.report.verdicts import (
    REFERENCE,
    TOO_FEW,
    WIDEST,
    has_interval,
    is_too_wide,
    verdict_of_cycles,
)
from studies.paper.tables_1_to_3 import figure_text

SIZE = (4.2, 3.6)
"""Size of a figure [inches]: at the width of a phone its smallest letters have 9 pixels."""
SMALL = 8.0
"""Size of the smallest letters [points]."""
WORST = 8
"""Number of pairs of walls that are shown, the worst first."""
LINEAR = 10.0
"""Percentage up to which the axes of effects are linear; beyond, they are logarithmic."""
_MARKS = "sD^vP"
_PALE = {"alpha": 0.35}
_NO_BAR = f"{TOO_FEW}: wider than ±{WIDEST:g} % about 0"
_CLOSURES = {"change_percent": "net", "gross_percent": "gross"}
"""Names of closures by the columns of their changes."""
_LETTERS = 26
"""Largest number of letters in a line of a legend of two columns that fits into the figure."""
_OFFSET = 1.05
"""Ratio of the times at which neighbouring marks of one setting are drawn, so that they do not
overlap."""


def pooled(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a table that are of all rocks together, or of the only rock."""
    return table[table.rock == (ALL_ROCKS if (table.rock == ALL_ROCKS).any() else table.rock)]


def _letters() -> dict[str, Any]:
    return {"fontsize": SMALL}


@styled
def accuracy_panel(table: pd.DataFrame, within: float) -> Figure:
    """Draw the errors of mean closures by each setting of the numerics over the time of a joint.

    Bars are 95 % intervals, marks of gross closure are hollow, and the setting of the study has a
    ring. The marks of a setting are drawn side by side and joined by a line, whose middle is at
    their time. The legend has the verdict on each setting: whether its errors are shown to be
    within the request in all cycles, or beyond it in one. ``table`` is that of
    `studies.assessment.report_tables.assessed_table`, ``within`` the request [1].
    """
    shown = pooled(table[table.kind == SETTING]).astype({"cycle": int})
    figure, axes = subplots(figsize=SIZE)
    limit = 100.0 * within
    axes.axhspan(-limit, limit, color="0.9", lw=0.0, zorder=0)
    axes.axhline(0.0, color="0.5", lw=0.8, zorder=1)
    variants = list(dict.fromkeys(shown.variant))
    cycles = sorted(shown.cycle.unique())
    marks = dict(zip(variants, _MARKS, strict=False))
    # net closures and, hollow, gross ones of each cycle beside each other
    drawn = list(itertools.product(cycles, _CLOSURES))
    joined: dict[str, list[tuple[float, float]]] = {name: [] for name in variants}
    for row in shown.itertuples():
        for number, (cycle, name) in enumerate(drawn):
            if cycle != row.cycle or not _is_drawn(row, name):
                continue
            at = row.seconds * _OFFSET ** (number - 0.5 * (len(drawn) - 1))
            value = getattr(row, name)
            joined[row.variant].append((at, value))
            style: dict[str, Any] = {"color": f"C{cycle - 1}", "marker": marks[row.variant]}
            style |= {} if name == drawn[0][1] else {"mfc": "w"}
            style |= _PALE if _is_pale(row, name) else {}
            axes.errorbar([at], [value], [_half_width(row, name)], ms=5, lw=1.0, **style)
            if row.of_study:
                ring = {"mfc": "none", "mec": "k", "mew": 1.2, "ms": 12, "zorder": 5}
                axes.plot([at], [value], "o", **ring)
    for points in filter(None, joined.values()):
        axes.plot(*zip(*sorted(points), strict=True), color="0.7", lw=0.8, zorder=1)
    reach = max(
        abs(getattr(row, name)) + _half_width(row, name)
        for row in shown.itertuples()
        for name in _CLOSURES
        if _is_drawn(row, name)
    )
    axes.set(xscale="log", xlim=(0.45 * shown.seconds.min(), 2.2 * shown.seconds.max()))
    decimal_ticks(axes.xaxis)
    end = max(1.3 * float(reach), 2.0 * limit)
    scale = percent_ticks(axes.yaxis, limit, -end, end)
    reference = shown.reference.iloc[0]
    axes.set_xlabel("processor time of a joint (s), logarithmic", **_letters())
    lines = ["error of mean closure (%)", f"against {reference}{scale}".replace(", ", ",\n")]
    words = "\n".join(lines)
    axes.set_ylabel(words, **_letters())
    axes.set_title("Error against time", fontsize=10)
    verdicts = {name: verdict_of_cycles(shown[shown.variant == name]) for name in variants}
    handles = [
        point_key(fill(f"{name}: {verdict}", _LETTERS), marks[name], color="0.4", ms=5)
        for name, verdict in verdicts.items()
    ]
    handles += [key(f"cycle {cycle}", color=f"C{cycle - 1}", lw=3) for cycle in cycles]
    handles += [
        point_key("hollow: gross, else net", "o", color="0.4", mfc="w", ms=5),
        point_key("this study", "o", mfc="none", mec="k", mew=1.2, ms=9),
        point_key("95 % interval", "|", color="0.4", ms=8),
        key("joins one setting", color="0.7", lw=0.8),
    ]
    if any(_is_pale(row, name) for row in shown.itertuples() for name in _CLOSURES):
        handles.append(point_key(fill(_NO_BAR, _LETTERS), "o", color="0.4", ms=5, **_PALE))
    joints = int(shown.joints.max())
    title = f"By {joints} joints, within ±{limit:g} % (grey)\nin all cycles or beyond it in one:"
    return _finished(figure, [axes], handles, title=title)


def _half_width(row: Any, name: str = "change_percent") -> float:
    """Return half of the 95 % interval of a change [%]; 0 if it is infinite or too wide to draw."""
    half = getattr(row, f"{name}_high") - getattr(row, name)
    return float(half) if np.isfinite(half) and not is_too_wide(row._asdict(), name) else 0.0


def _is_drawn(row: Any, name: str) -> bool:
    """Return whether a change has a mark: one without an interval would look exact."""
    return row.verdict == REFERENCE or has_interval(row._asdict(), name)


def _is_pale(row: Any, name: str = "change_percent") -> bool:
    """Return whether a mark is pale, as the interval of its change is too wide to be drawn."""
    return row.verdict != REFERENCE and is_too_wide(row._asdict(), name)


@styled
def effects_panel(table: pd.DataFrame, within: float) -> Figure:
    """Draw the changes of mean closures, and of the time of a joint, without each effect.

    ``table`` is that of `studies.assessment.report_tables.assessed_table`. Marks of gross closure
    are hollow. Changes whose intervals are too wide are pale. A change of one joint, which has no
    interval, is named by words. A grey band has the changes up to the request ``within`` [1].
    """
    shown = pooled(table[table.kind == EFFECTS])
    names = list(dict.fromkeys(shown.variant))
    measured = shown.dropna(subset="change_percent").astype({"cycle": int})
    figure, (left, right) = subplots(1, 2, figsize=SIZE, sharey=True, width_ratios=(1.3, 1.0))
    panels = [left, right]
    for axes in panels:
        axes.axvline(0.0, color="0.5", lw=0.8, zorder=1)
    limit = 100.0 * within
    left.axvspan(-limit, limit, color="0.9", lw=0.0, zorder=0)
    cycles = sorted(measured.cycle.unique())
    quantities = [name for name in ("change_percent", "gross_percent") if name in measured]
    marks = list(itertools.product(cycles, quantities))
    ends = [-5.0, 5.0]
    pale = False
    for row in measured.itertuples():
        for number, (cycle, name) in enumerate(marks):
            value = getattr(row, name)
            if cycle != row.cycle or not np.isfinite(value) or not _is_drawn(row, name):
                continue
            at = names.index(row.variant) + 0.16 * (number - 0.5 * (len(marks) - 1))
            error = _half_width(row, name)
            style: dict[str, Any] = {"color": f"C{cycle - 1}", "fmt": "o", "ms": 4, "lw": 1.0}
            style |= {} if name == quantities[0] else {"mfc": "w"}
            style |= _PALE if _is_pale(row, name) else {}
            pale |= _is_pale(row, name)
            left.errorbar([value], [at], xerr=[error], **style)
            ends += [value - error, value + error]
    known = ["time_percent", "time_percent_standard_error"]  # of one joint there is no error
    times = measured.drop_duplicates("variant").dropna(subset=known)
    error = times.time_percent_standard_error
    rows = [names.index(name) for name in times.variant]
    right.errorbar(times.time_percent, rows, xerr=error, fmt="o", ms=4, lw=1.0, color="0.3")
    ends_of_time = [-5.0, 5.0, *(times.time_percent - error), *(times.time_percent + error)]
    left.set_xlabel("change of mean closure (%)", **_letters())
    right.set_xlabel("change of time (%)", **_letters())
    scales = {
        side: percent_ticks(axes.xaxis, LINEAR, 1.5 * min(of), 1.5 * max(of), narrow=True)
        for side, axes, of in (("left", left, ends), ("right", right, ends_of_time))
    }
    effects = [shown[shown.variant == name].iloc[0] for name in names]
    for place, row in enumerate(effects):
        if words := _in_place_of_marks(row):
            panels[0].annotate(
                words, (0.04, place), xycoords=("axes fraction", "data"), va="center",
                color="0.4", **_letters(),
            )  # fmt: skip
    logarithmic = [side for side, words in scales.items() if words]
    axis = "both axes" if len(logarithmic) == 2 else " ".join([*logarithmic, "axis"])
    scale = f"{axis} logarithmic beyond ±{LINEAR:g} %" if logarithmic else ""
    for axes in panels:
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.yaxis.set_minor_locator(NullLocator())
    panels[0].set_yticks(range(len(names)), map(_effect_label, effects))
    figure.suptitle("Changes without each effect", fontsize=10)
    handles = [
        point_key(
            f"{_CLOSURES[name]}, cycle {cycle}",
            color=f"C{cycle - 1}",
            mfc=None if name == quantities[0] else "w",
            ms=4,
        )
        for cycle, name in marks
    ]
    if pale:
        handles.append(point_key(fill(_NO_BAR, _LETTERS), "o", color="0.4", ms=4, **_PALE))
    bars = f"bars: 95 % interval of closure (grey: within ±{limit:g} %),\n± standard error of time"
    title = "\n".join(filter(None, [scale, bars]))
    return _finished(figure, panels, handles, 2, title)


def _in_place_of_marks(row: pd.Series) -> str:
    """Return the words in a row of the effects panel without marks; "" of one with marks."""
    if has_interval(row, "change_percent"):
        return ""
    joints = row.get("joints", 0.0)
    return row.state or (f"{joints:.0f} joint" if joints == 1 else TOO_FEW)


def _effect_label(row: pd.Series) -> str:
    """Return the name of an effect, and below it the verdict if its changes were measured."""
    name = row.variant.removeprefix("without ")
    return f"{name}:\n{row.verdict}" if has_interval(row, "change_percent") else name


@styled
def hardness_panel(table: pd.DataFrame, titles: Mapping[str, str]) -> Figure:
    """Draw the hardness of the worst pairs of walls of a study.

    ``table`` is that of `studies.assessment.report_tables.hardness_table`, and ``titles`` are those
    of the rocks. A bar is the force on contacts that cannot break, in the worst case of a pair of
    walls; a line is the range of this force over all cases of the pair; and a diamond is the
    largest jump in the worst case. All are over their limits.
    """
    pairs = [rows for _, rows in table.groupby(["rock", "walls"], sort=False)][:WORST]
    worst = [next(rows.itertuples()) for rows in pairs]
    figure, axes = subplots(figsize=SIZE)
    rocks = list(titles)
    forces = np.nan_to_num([row.unbreakable_over_limit for row in worst])
    judged = bool(table.jump_over_limit.notna().any())
    jumps = np.nan_to_num([row.jump_over_limit for row in worst])
    colours = [f"C{rocks.index(row.rock)}" for row in worst]
    axes.barh(range(len(worst)), forces, color=colours, height=0.6)
    if judged:
        axes.plot(jumps, range(len(worst)), "D", color="0.2", mfc="w", ms=5, clip_on=False)
    axes.axvline(1.0, color="0.3", ls="--", lw=1.0)
    ends = []
    for place, (row, rows) in enumerate(zip(worst, pairs, strict=True)):
        shares = rows.unbreakable_over_limit.fillna(0.0)
        if len(rows) > 1:
            axes.plot([shares.min(), shares.max()], [place, place], "|-", color="0.2", lw=1.0)
        ends.append(max(float(shares.max()), jumps[place]))
        words = row.verdict if isinstance(row.verdict, str) and row.verdict else "no remark"
        axes.annotate(
            fill(words, 18), (ends[place], place), xytext=(7, 0), textcoords="offset points",
            va="center", color="0.2", bbox={"fc": "w", "ec": "none", "pad": 0.5},
            in_layout=False, **_letters(),
        )  # fmt: skip
    labels = [_joint_title(row, titles, len(rows)) for row, rows in zip(worst, pairs, strict=True)]
    axes.set_yticks(range(len(worst)), labels)
    axes.set(xlim=(0.0, 1.7 * max([1.25, *ends])), ylim=(len(worst) - 0.4, -0.6))
    jump_limit = percent(0.01 * table.jump_limit_percent.iloc[0])
    lines = [
        "measure of hardness over its limit (dashed)",
        f"bar: force on contacts that cannot break ({percent(LARGEST_UNBREAKABLE_SHARE)})",
        f"diamond: largest closure jump under load control ({jump_limit})"
        if judged
        else "jumps are not judged: the paper's steps make some of their own",
    ]
    if any(len(rows) > 1 for rows in pairs):
        marks = "bar and diamond" if judged else "bar"
        lines.append(f"{marks}: worst case of a pair of walls, line: its other cases")
    figure.supxlabel("\n".join(lines), **_letters())
    total = int(table.ranked.iloc[0]) if len(table) else 0
    known = len(table) == total
    of = f"{table.groupby(['rock', 'walls']).ngroups} pairs of walls ({total} joints)"
    title = f"The {len(worst)} hardest of {of if known else f'{total} joints'}"
    figure.suptitle(title, fontsize=10)
    axes.tick_params(labelsize=SMALL)
    axes.tick_params(axis="y", length=0)
    sns.despine(figure, left=True)
    _make_room(figure, axes, ends)
    return figure


def _make_room(figure: Figure, axes: Axes, ends: Sequence[float]) -> None:
    """Set the upper end of the x axis so that the words to the right of ``ends`` are not cut."""
    figure.draw_without_rendering()  # lays the figure out, which determines lengths in pixels
    width = axes.get_window_extent().width
    gap = 9.0 * figure.dpi / 72.0
    rooms = [max(width - gap - text.get_window_extent().width, 1.0) for text in axes.texts]
    spans = [width * end / room for end, room in zip(ends, rooms, strict=True)]
    axes.set_xlim(0.0, max([1.25, *spans]))


def _joint_title(row: Any, titles: Mapping[str, str], cases: int) -> str:
    """Return the title of the worst joint of a pair of walls: its rock and number.

    A second line says what its case changes; if the pair has several ``cases``, it is called the
    worst of so many.
    """
    changed = row.changed if isinstance(row.changed, str) else ""  # empty in a file
    if cases > 1:
        changed = f"worst of {cases}: {changed or 'base case'}"
    first = figure_text(f"{titles[row.rock]}, joint {row.joint}")
    return first + (f"\n{changed}" if changed else "")


def _finished(
    figure: Figure, panels: Iterable[Axes], handles: list, columns: int = 2, title: str = ""
) -> Figure:
    for axes in panels:
        axes.tick_params(labelsize=SMALL)
    place: dict[str, Any] = {"loc": "outside lower center", "ncols": columns, "frameon": False}
    figure.legend(handles=handles, title=title, title_fontsize=SMALL, **place, **_letters())
    sns.despine(figure)
    return figure


def first_panels(
    hardness: pd.DataFrame,
    titles: Mapping[str, str],
    differences: pd.DataFrame | None,
    within: float | None,
) -> dict[str, Figure]:
    """Return the figures of the assessment by the names of their files.

    ``hardness`` is the table of `hardness_table`, ``differences`` that of `assessed_table`. Without
    the latter, or without the requested error ``within`` [1], only hardness is drawn. ``titles``
    are those of the rocks.
    """
    panels = {"study_hardness": hardness_panel(hardness, titles)}
    if differences is not None and within is not None:
        panels["study_accuracy"] = accuracy_panel(differences, within)
        panels["study_effects"] = effects_panel(differences, within)
    return panels
