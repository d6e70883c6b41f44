"""Experiment that assesses a study's rocks by the variants of `jointclosure.assess`.

A condition is a rock with a JRC (or scanned walls) and a maximum stress. A variant is a setting of
the numerics, or the simulation without some effects.
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import pandas as pd
import seaborn as sns
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.assessment.assess import READ, assessed_variants
from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.assessment.assessment import Assessment as Assessed
from jointclosure.assessment.effect_names import lacks_effects
from jointclosure.assessment.hardness import HARD_CASES, worst_first
from jointclosure.assessment.verdicts import is_given_up
from jointclosure.joint.status import FAILURE, LARGEST_UNBREAKABLE_SHARE
from jointclosure.plotting.assessment import draw_effects
from jointclosure.plotting.style import (
    decimal_ticks,
    panel_grid,
    percent_ticks,
    styled,
    ticks_at,
)
from jointclosure.storage.files import read_csv
from jointclosure.uncertainty.variants import COPIES
from jointclosure.walls import Walls
from studies.assessment.larger_assessment import base_conditions
from studies.assessment.section import AssessmentSection
from studies.frame.cases import base_case
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Tables, settings_of
from studies.frame.joint_tables import grouped
from studies.frame.panels import key, legend_below, point_key
from studies.frame.scanned_walls import cut_walls, walls_of_files
from studies.frame.settings import Case, ClosureSettings, Point, walls_of
from studies.paper.tables_1_to_3 import figure_text

_COLUMNS = 2
"""Largest number of panels in a row."""
_LEAST_SPREAD = 1e-5
"""Least spread [1] on the axis; smaller spreads are drawn there."""
_SETTINGS = "osD^v"
"""Markers of the settings of the numerics, in their order."""
_FILLED: dict[str, dict[str, Any]] = {
    "easy": {},
    "hard": {"mfc": "none"},
    "not stable": {"fillstyle": "left"},
}
"""Filling of the markers of joints, by the verdict on the joint."""
_JOINT: dict[str, Any] = {"ms": 4.5, "mew": 1.0, "alpha": 0.8}
"""Style of the markers of joints."""
_BESIDE = 0.2
"""Distance between neighbouring marks of one setting, over the distance between two settings."""
_LINEAR_SHARE = 1.0
"""Percentage up to which axes of shares are linear; beyond, they are logarithmic."""


def _panels(
    table: pd.DataFrame, titles: Mapping[str, str], panel: tuple, sharex: bool = True
) -> Iterator[tuple[Axes, pd.DataFrame]]:
    """Generate for each condition a panel of one new figure, and the rows that are drawn there.

    Panels share their vertical axes, and their horizontal ones too if ``sharex``. ``panel`` is the
    size [inches] of a panel.
    """
    shown = table[table.quantity.isin(JUDGED) & (table.variant != table.reference)]
    conditions = list(grouped(shown, "rock", "jrc", "stress_MPa"))
    columns = min(len(conditions), _COLUMNS)
    rows = -(-len(conditions) // columns)
    _, grid = panel_grid(rows, columns, panel, (1.2, 0.0), sharex=sharex, sharey=True)
    for axes in grid.flat[len(conditions) :]:
        axes.remove()
    for axes, (at, part) in zip(grid.flat, conditions, strict=False):
        axes.set_title(figure_text(condition(titles, **at)))
        yield axes, part


def condition(titles: Mapping[str, str], rock: str, jrc: float, stress_MPa: float) -> str:
    """Return words on a condition: the rock's title, its JRC (NaN: scanned walls) and stress."""
    walls = "scanned" if math.isnan(jrc) else f"JRC {jrc:g}"
    return f"{titles[rock]}, {walls}, {stress_MPa:g} MPa"


@styled
def draw_assessment_price(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the errors of mean closures by each setting of the numerics, for each condition.

    Errors are differences to the finest setting, with their 95 % intervals; the finest setting is
    not drawn. The time of a joint stands below the name of its setting. Colours are cycles, shapes
    are settings, and hollow marks are gross closures.
    """
    assessment = tables["assessment"]
    percent = 100.0 * settings["within"]
    numerics = assessment[assessment.verdict.isna() | (assessment.verdict == "")]
    drawn = numerics[numerics.quantity.isin(JUDGED) & (numerics.variant != numerics.reference)]
    alone = drawn[list(_CONDITION)].drop_duplicates().shape[0] == 1
    size = (5.5, 3.8) if alone else (3.3, 2.7)
    for axes, part in _panels(numerics, settings["titles"], size, sharex=False):
        _draw_price(axes, part, percent)
    largest = 1.2 * max(drawn.high_percent.max(), -drawn.low_percent.min(), 4.0 * percent)
    scale = percent_ticks(axes.yaxis, percent, -largest, largest)
    bar = f"95 % interval of the change from {drawn.reference.iloc[0]}"
    axes.plot([], [], "|", color="0.5", ms=9, label=bar)
    axes.axhspan(0.0, 0.0, color="0.9", label=f"within the request of {percent:g} %")
    words = f"change of mean closure (%){scale}"
    return _finished(axes, "setting, and processor time of a joint with it", words)


def _draw_price(axes: Axes, settings: pd.DataFrame, within: float) -> None:
    """Draw in a panel the errors [%] of settings, side by side in their order.

    Ticks are the names of settings and the times of joints. Marks of gross closure are hollow. A
    grey band has the errors up to the request ``within`` [%].
    """
    axes.axhspan(-within, within, color="0.9", lw=0.0, zorder=0)
    axes.axhline(0.0, color="0.5", lw=0.8, zorder=1)
    variants = list(dict.fromkeys(settings.variant))
    seconds = settings.groupby("variant", sort=False).seconds.first()
    groups = list(itertools.product(JUDGED, sorted(settings.cycle.unique())))
    for number, (quantity, cycle) in enumerate(groups):
        rows = settings[(settings.quantity == quantity) & (settings.cycle == cycle)]
        apart = _BESIDE * (number - 0.5 * (len(groups) - 1))
        for row in rows.itertuples():
            bars = [[row.value_percent - row.low_percent], [row.high_percent - row.value_percent]]
            style: dict[str, Any] = {"color": f"C{cycle - 1}", "ms": 4.5, "lw": 1.0}
            style |= {"marker": _SETTINGS[variants.index(row.variant)]}
            style |= {} if quantity == JUDGED[0] else {"mfc": "w"}
            at = seconds.index.get_loc(row.variant) + apart
            axes.errorbar([at], [row.value_percent], bars, **style)
    for place in range(1, len(seconds)):
        axes.axvline(place - 0.5, color="0.8", lw=0.8, zorder=1)
    for mark, name in zip(_SETTINGS, variants, strict=False):
        axes.plot([], [], mark, color="0.5", label=name)
    for quantity, cycle in groups:
        fill = None if quantity == JUDGED[0] else "w"
        name = f"{ASSESSED[quantity]}, cycle {cycle}"
        axes.plot([], [], "o", color=f"C{cycle - 1}", mfc=fill, label=name)
    axes.set_xlim(-0.5, len(seconds) - 0.5)
    ticks = [f"{name.removeprefix('the ')}\n{value:.2g} s" for name, value in seconds.items()]
    ticks_at(axes.xaxis, range(len(seconds)), ticks)


@styled
def draw_assessment_effects(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the changes of mean closures without each group of effects, for each condition."""
    assessment = tables["assessment"]
    without = assessment[lacks_effects(assessment.variant)]
    shown = without[without.quantity.isin(JUDGED)]
    for axes, part in _panels(without, settings["titles"], (3.1, 3.0)):
        scale = draw_effects(axes, part, 100.0 * settings["within"], shown)
    return _finished(axes, f"change of mean closure (%){scale}", "")


def _finished(axes: Axes, x: str, y: str) -> Figure:
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.supxlabel(x, fontsize="medium")
    figure.supylabel(y.replace(", ", ",\n"), fontsize="medium")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", frameon=False, ncols=2)
    sns.despine(figure)
    return figure


@styled
def draw_assessment_hardness(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw features of joints, in front of those of the hard cases, with the limits of easy joints.

    Each rock has a row of two panels, so that its joints are not hidden by those of another rock.
    Colours and shapes stand for maximum stresses.
    """
    hardness = tables["hardness"]
    shares = ["spread", "unbreakable_share", "largest_jump"]
    least = [_LEAST_SPREAD, 0.0, 0.0]
    joints, cases = (
        part.assign(**100.0 * part[shares].clip(lower=least, axis=1))
        for part in (hardness, read_csv(HARD_CASES))
    )
    rocks = list(dict.fromkeys(joints.rock))
    verdicts = [name for name in _FILLED if (joints.verdict == name).any()]
    marks = {
        stress: _JOINT | {"color": f"C{i}", "marker": "osD^vP"[i % 6]}
        for i, stress in enumerate(sorted(joints.stress_MPa.unique()))
    }
    _, grid = panel_grid(len(rocks), 2, (3.3, 2.3), (0.2, 1.2), sharex="col", sharey="col")
    for (left, right), rock in zip(grid, rocks, strict=True):
        of_rock = joints[joints.rock == rock]
        for axes, x, y in ((left, *shares[:2]), (right, "contacts_at_max", shares[2])):
            axes.plot(cases[x], cases[y], "o", color="0.82", ms=3.0, zorder=1)
            for (verdict, stress), part in of_rock.groupby(["verdict", "stress_MPa"]):
                style = marks[stress] | _FILLED[verdict]
                axes.plot(part[x], part[y], ls="", zorder=3, **style)
            axes.set_title(figure_text(settings["titles"][rock]))
            axes.set_xscale("log")
            axes.set_yscale("symlog", linthresh=_LINEAR_SHARE, linscale=0.5)
            axes.set_ylim(-0.4, 130.0)
            ticks_at(axes.yaxis, (0.0, 1.0, 3.0, 10.0, 30.0, 100.0))
        left.set_ylabel("force on contacts\nthat cannot break (%)")
        right.set_ylabel("largest jump\n(% of closure)")
        left.axvline(50.0 * settings["within"], color="0.5", ls="--", zorder=0)
        left.axhline(100.0 * LARGEST_UNBREAKABLE_SHARE, color="0.5", ls="--", zorder=0)
        right.axhline(100.0 * settings["within"], color="0.5", ls="--", zorder=0)
    left, right = grid[-1]
    decimal_ticks(right.xaxis)
    low = 100.0 * _LEAST_SPREAD
    left.set_xlim(0.5 * low, 200.0)
    decades = [low, 0.1, 1.0, 10.0, 100.0]
    ticks_at(left.xaxis, decades, [f"≤ {low:g}", *(f"{value:g}" for value in decades[1:])])
    left.set_xlabel("scatter of net closure over copies\nthat should give equal results (%)")
    right.set_xlabel("cells in contact")
    handles: list[Artist] = [
        *(point_key(f"{stress:g} MPa", **look) for stress, look in marks.items()),
        *(point_key(name, **_JOINT | _FILLED[name], color="0.3") for name in verdicts),
        point_key("hard cases", color="0.82", ms=3.0),
        key("largest value of easy joints", color="0.5", ls="--"),
    ]
    figure = left.get_figure(root=True)
    assert figure is not None
    legend_below(figure, handles, columns=4)
    sns.despine(figure)
    return figure


_CONDITION = ("rock", "jrc", "stress_MPa")
_VALUES = ["value", "low", "high"]


def assessment_jobs(study: Configuration) -> dict[str, list[Point]]:
    """Return the points of the assessment by job: one job for each condition and variant.

    The variant with the settings of the study has a point for each of `COPIES` of the walls, other
    variants only one for the walls as they are.
    """
    section = study.section(AssessmentSection)
    jobs = {}
    for number, case in enumerate(_conditions(study, section)):
        settings = settings_of(study, case)
        count = section.joints
        if settings.walls:  # a scan has room for a number of joints
            count = min(count, study.study.realizations)
        settings = settings._replace(realizations=count)
        stated, _, variants = assessed_variants(settings.conditions)
        options = {"unusual_values": study.study.unusual_values == "allow"}
        for name, conditions in variants.items():
            varied = settings.under(numerics=conditions.numerics, effects=conditions.effects)
            at = {"rock": case.rock, "jrc": case.jrc, "stress": case.max_normal_stress}
            jobs[f"{case.rock}.{number}.{name.replace(' ', '_').replace(chr(39), '')}"] = [
                Point(
                    at | {"variant": name, "copy_of_walls": copy},
                    varied,
                    f"{__name__}:copies",
                    options | {"copy": copy},
                )
                for copy in (COPIES if name == stated else ["as it is"])
            ]
    return jobs


def ladders_of(study: Configuration) -> dict[str, tuple]:
    """Return by rock the name of the study's setting of numerics, and the names of all settings.

    All settings are in the order of their accuracy: the finest is last.
    """
    return {
        name: assessed_variants(base_case(study, name).checked_conditions)[:2]
        for name in study.rocks
    }


def _conditions(configuration: Configuration, section: AssessmentSection) -> Iterator[Case]:
    """Generate the base case of each rock at each JRC and maximum stress of the section.

    Scanned walls have no other JRC; without stated ones those of the rock are taken.
    """
    for name, rock in configuration.rocks.items():
        base = base_case(configuration, name)
        roughnesses = (not rock.walls and section.jrc) or (base.jrc,)
        for jrc, stress in itertools.product(
            roughnesses, section.stress or (base.max_normal_stress,)
        ):
            yield base.changed("jrc", jrc).under(max_normal_stress=stress)


def copies(settings: ClosureSettings, copy: str, unusual_values: bool) -> Iterator[Walls]:
    """Generate the walls (y, x) [m] of each realisation of a block, changed as a copy of them is.

    ``copy`` is a name in `COPIES`. Walls are made from seeds or cut out of scans.
    """
    if settings.walls:
        about = settings.grid.spacing, settings.surface.jrc_relation, unusual_values
        pairs = cut_walls(_scanned(settings.walls, *about), settings)
    else:
        pairs = walls_of(settings)
    for upper, lower in pairs:
        yield COPIES[copy](upper), COPIES[copy](lower)


_scanned = lru_cache(maxsize=1)(walls_of_files)


def _assessed(
    joints: pd.DataFrame, settings: Mapping[str, Any]
) -> Iterator[tuple[dict[str, Any], Assessed]]:
    """Generate each condition (rock, jrc, stress_MPa), and the assessment of its joints."""
    closures = joints.rename(columns={"realization": "joint"}).assign(error="")
    for at, part in grouped(closures, "rock", "jrc", "stress"):
        stated, ladder = settings["ladders"][at["rock"]]
        yield at, Assessed(part, ladder, stated, settings["within"])


def tabulate_assessment(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Tabulate the differences [%] of variants at each condition, with verdicts on effects.

    ``needed_by`` names the results that make an effect needed, and ``joints`` is the number of
    pairs of walls. ``failed`` of these have no result with the variant, and are not in the
    differences; ``given_up`` are those among them that took too many breakage steps.
    ``seconds_standard_error`` is the standard error of the mean time of a joint. ``study_key``
    identifies the settings of the condition of a base case (`base_conditions`); elsewhere it is "".
    """
    differences = []
    for at, found in _assessed(joints, settings):
        percent = (100.0 * found.differences[_VALUES]).add_suffix("_percent")
        verdicts = {name: found.verdict(name) for name in found.effects.index}
        table = found.differences.drop(columns=_VALUES).join(percent)
        by = {name: found.needed_by(name) for name in found.effects.index}
        columns = {"verdict": verdicts, "needed_by": by}
        named = {name: table.variant.map(of).fillna("") for name, of in columns.items()}
        times = found.closures[found.closures.copy_of_walls == "as it is"]
        times = times.drop_duplicates(["variant", "joint"]).groupby("variant").seconds.sem()
        named["seconds_standard_error"] = table.variant.map(times)
        base = settings["base_conditions"][at["rock"]]
        named["joints"] = found.closures.joint.nunique()
        lost = {"failed": found.closures.status >= FAILURE}
        lost["given_up"] = is_given_up(found.closures.status)
        for name, those in lost.items():
            counts = found.closures[those].groupby("variant").joint.nunique()
            named[name] = table.variant.map(counts).fillna(0).astype(int)
        named["study_key"] = base.key if base.is_at(at) else ""
        differences.append(table.assign(**at, **named))
    return _first(differences, *_CONDITION, "variant", "reference")


def tabulate_hardness(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Tabulate the hardness of each joint at each condition, the worst joint first."""
    parts = [found.hardness.assign(**at) for at, found in _assessed(joints, settings)]
    return worst_first(_first(parts, *_CONDITION))


HARDNESS_OF = (
    "Hardness of a joint: the scatter is that of its copies with {stated}; the force on contacts "
    "that cannot break is the largest of these copies; the largest jump is that of the joint as it "
    "is with {finest}. With another setting or on another copy the same joint has other values."
)
"""Settings and copies of walls from which the features of `Assessment.hardness` are taken."""


def describe_assessment(joints: pd.DataFrame, settings: Mapping[str, Any]) -> str:
    """Return the assessment of each condition as Markdown: tables and sentences."""
    lines = ["# Assessment", ""]
    for at, found in _assessed(joints, settings):
        lines += [f"## {condition(settings['titles'], **at)}", ""]
        for table in (found.price, found.effects):
            rows = table.rename_axis("variant").reset_index()
            cells = [rows.columns, ["---"] * rows.shape[1], *rows.to_numpy()]
            lines += [f"| {' | '.join(map(str, row))} |" for row in cells] + [""]
        lines += [*(f"- {line}" for line in found.sentences), ""]
        lines += [HARDNESS_OF.format(stated=found.stated, finest=found.ladder[-1]), ""]
    return "\n".join(lines)


def _first(tables: list[pd.DataFrame], *names: str) -> pd.DataFrame:
    table = pd.concat(tables)
    return table[[*names, *(name for name in table if name not in names)]]


EXPERIMENT = Experiment(
    title="accuracy and its cost, hardness, and effects that are needed",
    quantities=tuple(name for name in READ if name not in ("status", "timing_simulation")),
    jobs=assessment_jobs,
    tables={
        "assessment.csv": tabulate_assessment,
        "hardness.csv": tabulate_hardness,
        "assessment.md": describe_assessment,
    },
    figures={
        "assessment_price": draw_assessment_price,
        "assessment_effects": draw_assessment_effects,
        "assessment_hardness": draw_assessment_hardness,
    },
    settings=lambda study: {
        "ladders": ladders_of(study),
        "titles": study.titles,
        "within": study.section(AssessmentSection).within,
        "base_conditions": base_conditions(study),
    },
)
