"""Experiment on three measured granodiorite joints: the model beside their later loading.

Joints with independent walls, and with walls that mate beyond a wavelength, are simulated with
variants of the choices that the model leaves open, and of the strength of the rock, which was not
published. The wavelength of each measured joint is fitted to the closure of its first loading. All
else is then judged: stiffness and closure of the later loading, the share of it that stays, and the
area of contact.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.ensembles.joints import simulated_joint
from jointclosure.mechanics.strength import strength_factor
from jointclosure.plotting.style import decimal_ticks, styled, subplots, ticks_at
from jointclosure.walls import CrushedWalls, shifted
from studies.frame.configuration import Configuration
from studies.frame.panels import keys_of, legend_below
from studies.frame.points import Experiment, Tables, at_wavelengths
from studies.frame.settings import ClosureSettings, Point, walls_of
from studies.measured_joints.observables import (
    BASE,
    HEADINGS,
    judged_joints,
    observables_of,
    prediction_table,
    score_table,
)
from studies.measured_joints.section import MeasuredJointsSection

FILM_CELL = 0.5e-3
"""Spacing of the measured maps of contact stress [m]."""
QUANTITIES: tuple[str, ...] = ("max_closure_seated_net", "residual_closure_seated_net")
QUANTITIES += ("stiffness_net", "contact_at_max")
_LOGARITHMIC = ("first_closure", "first_stiffness", "later_closure", "later_stiffness")
_OFFSETS = (-0.27, -0.09, 0.09, 0.27)
"""Offsets of independent walls and of walls fitted to three joints from the variant's place."""


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
    conditions = settings.conditions._replace(cycles=1)
    for pair in walls_of(settings):
        crushed = simulated_joint(pair, conditions).final
        yield CrushedWalls(*(shifted(walls, (0, shift)) for walls in (crushed, pair)))


def _hardness(settings: ClosureSettings, ratio: float) -> ClosureSettings:
    """Return settings that limit the mean pressure of a contact to a multiple of the strength.

    Resolved breakage without gouge is the plastic displacement of such a contact. The limit of the
    peak pressure, 3/2 of the mean pressure under a sphere, is sigma_c / c(nu) (`strength_factor`).
    """
    given = settings.conditions
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
    """Draw observables of all variants, with intervals of a single joint, beside measured bands."""
    table = tables["measured_joints"]
    variants = list(dict.fromkeys(table.variant))
    height = 1.0 + 0.32 * len(variants)
    figure, panels = subplots(2, 4, figsize=(14.0, 2.0 * height), sharey=True)
    for axes, (name, title) in zip(panels.flat, HEADINGS.items(), strict=True):
        _panel(axes, table[table.observable == name], variants)
        axes.set_xlabel(title)
        if name in _LOGARITHMIC:
            axes.set_xscale("log")
            decimal_ticks(axes.xaxis)
        else:
            axes.set_xlim(left=0.0)
    for axes in panels[:, 0]:
        ticks_at(axes.yaxis, range(len(variants)), variants)
        axes.set_ylim(len(variants) - 0.5, -0.5)
    legend_below(figure, keys_of(panels.flat), columns=4)
    return figure


def _panel(axes: Axes, table: pd.DataFrame, variants: list[str]) -> None:
    """Draw one observable over the variants."""
    joints = list(dict.fromkeys(table.joint))
    ranges = table.groupby("joint", sort=False)[["measured_low", "measured_high"]].first()
    if ranges.drop_duplicates().shape[0] == 1:
        axes.axvspan(*ranges.iloc[0], color="0.88", lw=0.0, label="measured, range of the joints")
    else:
        for i, (low, high) in enumerate(ranges.to_numpy()):
            band = f"measured, joint {joints[i]}"
            axes.axvspan(low, high, color=f"C{i}", alpha=0.25, lw=0.8, label=band)
    for i, joint in enumerate(joints):
        mated = table[(table.walls == "mated") & (table.joint == joint)]
        _bars(axes, mated, variants, _OFFSETS[i + 1], f"C{i}", f"mated, fitted to joint {joint}")
    free = table[(table.walls == "independent") & (table.joint == joints[0])]
    _bars(axes, free, variants, _OFFSETS[0], "0.55", "independent walls")


def _bars(
    axes: Axes, table: pd.DataFrame, variants: list[str], offset: float, colour: str, label: str
) -> None:
    """Draw means with the intervals of a single joint."""
    places = [variants.index(name) + offset for name in table.variant]
    bars = np.maximum(0.0, [table.value - table.low, table.high - table.value])
    axes.errorbar(table.value, places, xerr=bars, fmt="o", ms=3, lw=1.0, color=colour, label=label)


EXPERIMENT = Experiment(
    title="the model beside measured joints",
    quantities=QUANTITIES,
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
