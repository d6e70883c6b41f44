"""Experiment on three measured granodiorite joints: the model beside their later loading.

Joints with independent walls, and with walls that mate beyond a wavelength, are simulated with
variants of the choices that the model leaves open, and of the strength of the rock, which was not
published. The wavelength of each measured joint is fitted to the closure of its first loading. All
else is then judged: stiffness and closure of the later loading, the share of it that stays, and the
area of contact.
"""

from collections.abc import Iterator, Mapping
from textwrap import fill
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.ensembles.simulation import simulated_joint
from jointclosure.mechanics.strength import strength_factor
from jointclosure.plotting.style import decimal_ticks, styled, subplots, ticks_at
from jointclosure.walls import CrushedWalls, shifted
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Tables, at_wavelengths
from studies.frame.panels import key, point_key
from studies.frame.settings import ClosureSettings, Point, walls_of
from studies.measured_joints.observables import (
    AGREES,
    BASE,
    FITTED,
    HEADINGS,
    judged_joints,
    observables_of,
    prediction_table,
    score_table,
)
from studies.measured_joints.section import MeasuredJointsSection

FILM_CELL = 0.5e-3
"""Spacing of the measured maps of contact stress [m]."""
COMPARED_QUANTITIES = (
    "max_closure_seated_net",
    "residual_closure_seated_net",
    "stiffness_net",
    "contact_at_max",
)
_LOGARITHMIC = ("first_stiffness", "later_closure", "later_stiffness")
_BEST = 5
"""Number of variants of highest score that are drawn beside the default choices."""
_LANES = (-0.27, 0.0, 0.27)
"""Offsets of the lines of three joints from the place of their row."""
_JOINTS = (
    {"color": "#0173b2", "marker": "o"},
    {"color": "#de8f05", "marker": "s"},
    {"color": "0.15", "marker": "^"},
)
"""Colour and marker of each joint; readers with any kind of colour vision distinguish them."""


def measured_joints_jobs(study: Configuration) -> dict[str, list[Point]]:
    """Make a job for each mismatch wavelength, with the points of all variants."""
    section = study.section(MeasuredJointsSection)
    at = at_wavelengths(study, section.mismatch_wavelength)
    return {
        label: [
            point._replace(coordinates={**point.coordinates, "variant": name, "wavelength": length})
            for name, point in _variants(settings, section).items()
        ]
        for _, label, length, settings in at
    }


def _variants(settings: ClosureSettings, section: MeasuredJointsSection) -> dict[str, Point]:
    """Make the points of all variants for walls of one wavelength, by name of the variant."""
    rocks = {BASE: settings}
    for value in section.compressive_strength:
        case = settings.case.changed("compressive_strength", value)
        rocks[f"strength {1e-6 * value:g} MPa"] = settings._replace(case=case)
    points = dict(rocks)
    for value in section.peak_modulus_ratio:
        choices = settings.conditions.choices._replace(peak_modulus_ratio=value)
        points[f"peak modulus ratio {value:g}"] = settings.under(choices=choices)
    for value in section.largest_radius:
        choices = settings.conditions.choices._replace(largest_radius=value)
        points[f"radii up to {1e3 * value:g} mm"] = settings.under(choices=choices)
    for value in section.hardness_over_strength:
        points[f"pressure up to {value:g} times the strength"] = _hardness(settings, value)
    variants = {name: Point({"loaded_as": name}, changed) for name, changed in points.items()}
    for rock, of_rock in rocks.items():
        for value in section.crushed_strength_ratio:
            choices = of_rock.conditions.choices._replace(crushed_strength_ratio=value)
            name = f"crushed rock {value:g} as strong"
            name = name if rock == BASE else f"{rock}, {name}"
            variants[name] = Point({"loaded_as": rock}, of_rock.under(choices=choices))
        for shift in section.reseating_shift_in_cells:
            name = f"reseated, {1e3 * shift * settings.grid.spacing:g} mm off"
            name = name if rock == BASE else f"{rock}, {name}"
            once = of_rock.under(cycles=1)
            variants[name] = Point(
                {"loaded_as": rock}, once, f"{__name__}:reseated", {"shift": shift}
            )
    return variants


def reseated(settings: ClosureSettings, shift: int) -> Iterator[CrushedWalls]:
    """Generate walls after a load cycle, the upper one shifted along x by a number of cells."""
    conditions = settings.under(cycles=1).conditions
    for pair in walls_of(settings):
        crushed = simulated_joint(pair, conditions).final
        yield CrushedWalls(*(shifted(walls, (0, shift)) for walls in (crushed, pair)))


def _hardness(settings: ClosureSettings, ratio: float) -> ClosureSettings:
    """Return settings that limit the mean pressure of a contact to a multiple of the strength.

    Resolved breakage without gouge is the plastic displacement of such a contact. The limit of the
    peak pressure, 3/2 of the mean pressure under a sphere, is sigma_c / c(nu) (`strength_factor`).
    """
    given = settings.case.conditions
    strength = 1.5 * ratio * strength_factor(given.rock.poisson_ratio)
    strength *= given.rock.compressive_strength
    return settings.under(
        rock=given.rock._replace(compressive_strength=float(strength)),
        effects=given.effects._replace(gouge=False),
        numerics=given.numerics._replace(breakage="resolved"),
    )


def judge_measured_joints(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compare the observables of all variants with those of the measured joints."""
    return judged_joints(_observables(joints, settings), settings["root_seed"])


def score_measured_joints(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Count for each variant of mated walls the observables that agree with the measured ones."""
    loaded = joints.groupby("variant").loaded_as.first()
    constants = (loaded != BASE).astype(int) + (loaded != loaded.index)
    return score_table(judge_measured_joints(joints, settings), constants)


def predict_measured_joints(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Predict the measured joints from each other, by the model with its default choices."""
    return prediction_table(_observables(joints, settings))


def _observables(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    return observables_of(joints, (FILM_CELL / settings["spacing"]) ** 2)


@styled
def draw_measured_joints(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the judged observables of the default choices, and of the variants of highest score.

    Each row has a line for each measured joint: a broad bar is the measured range, a thin bar the
    interval of a single simulated joint. Markers of values that agree are filled. The last
    row has independent walls with the default choices. The fitted observable is not drawn.
    """
    table = tables["measured_joints"]
    scores = tables["measured_joints_scores"].set_index("variant")
    rows = _shown_rows(table, scores)
    judged = [name for name in HEADINGS if name != FITTED]
    figure, panels = subplots(4, 2, figsize=(7.4, 14.0), sharey=True)
    for axes, name in zip(panels.flat, judged, strict=False):
        _panel(axes, name, {label: part[part.observable == name] for label, part in rows.items()})
    for axes in panels[:, 0]:
        ticks_at(axes.yaxis, range(len(rows)), [fill(label, 26) for label in rows])
        axes.tick_params(axis="y", labelsize="small")
        axes.set_ylim(len(rows) - 0.5, -0.5)
    entries = _keys(list(dict.fromkeys(table.joint)))
    if any(line.get_marker() == ">" for axes in panels.flat for line in axes.lines):
        entries.append(point_key("interval is longer", ">", color="0.4", ms=6.0))
    agreeing = f"({scores.score[BASE]}): values that agree,\nof {scores.of.max()}"
    corner = panels.flat[-1]
    corner.axis("off")
    corner.legend(handles=[*entries, key(agreeing, ls="")], loc="center", frameon=False)
    return figure


def _shown_rows(table: pd.DataFrame, scores: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the parts of a table that are drawn, by the label of their row."""
    best = scores.drop(BASE).sort_values(["score", "constants"], ascending=[False, True])
    names = [BASE, *best.index[:_BEST]]
    mated = table[table.walls == "mated"]
    rows = {f"{name} ({scores.score[name]})": mated[mated.variant == name] for name in names}
    free = (table.walls == "independent") & (table.variant == BASE)
    return rows | {"independent walls": table[free]}


def _panel(axes: Axes, name: str, rows: Mapping[str, pd.DataFrame]) -> None:
    """Draw one observable, with its measured ranges."""
    axes.set_xlabel(HEADINGS[name])
    whole = pd.concat(rows.values())
    ends = whole[["low", "high", "measured_low", "measured_high"]].to_numpy()
    if name in _LOGARITHMIC:
        axes.set_xscale("log")
        axes.set_xlim(0.9 * ends.min(), 1.1 * ends.max())
        decimal_ticks(axes.xaxis)
    else:
        share = whole.unit.iloc[0] == "%"
        axes.set_xlim(*((-3.0, 103.0) if share else (0.0, 1.05 * ends.max())))
    for place, part in enumerate(rows.values()):
        if place:
            axes.axhline(place - 0.5, color="0.85", lw=0.8)
        for lane, row in enumerate(part.itertuples()):
            _joint(axes, row, place + _LANES[lane], _JOINTS[lane])


def _joint(axes: Axes, row: Any, place: float, look: Mapping[str, Any]) -> None:
    """Draw the measured range of a joint, and over it the interval of a simulated one."""
    colour = look["color"]
    ends = [row.measured_low, row.measured_high]
    axes.plot(ends, [place, place], color=colour, alpha=0.35, lw=6.0, solid_capstyle="butt")
    axes.plot(ends, [place, place], color=colour, alpha=0.7, ls="", marker="|", ms=7.0)
    axes.plot([row.low, row.high], [place, place], color=colour, lw=1.2)
    fill_colour = colour if row.judgement == AGREES else "white"
    axes.plot([row.value], [place], ms=5.0, mfc=fill_colour, **look)
    end = axes.get_xlim()[1]
    if row.high > end:
        axes.plot([end], [place], color=colour, marker=">", ms=6.0, clip_on=False)


def _keys(joints: list) -> list[Artist]:
    """Return the legend: joints, and what bars and filled markers are."""
    entries: list[Artist] = [
        point_key(f"joint {joint}", ms=5.0, **look)
        for joint, look in zip(joints, _JOINTS, strict=True)
    ]
    entries.append(key("measured range", color="0.4", alpha=0.35, lw=6.0))
    entries.append(key("simulated joint,\n95 % interval", color="0.4", lw=1.2))
    entries.append(point_key("filled: agrees", color="0.4", ms=5.0))
    entries.append(point_key("hollow: does not", color="0.4", mfc="white", ms=5.0))
    return entries


EXPERIMENT = Experiment(
    title="the model beside measured joints",
    quantities=COMPARED_QUANTITIES,
    jobs=measured_joints_jobs,
    tables={
        "measured_joints.csv": judge_measured_joints,
        "measured_joints_scores.csv": score_measured_joints,
        "measured_joints_predictions.csv": predict_measured_joints,
    },
    figures={"measured_joints": draw_measured_joints},
    settings=lambda study: {
        "root_seed": study.study.root_seed,
        "spacing": study.grid.spacing,
    },
)
