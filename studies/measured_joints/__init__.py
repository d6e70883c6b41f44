"""Experiment on three measured granodiorite joints: the model beside their later loading.

Joints with independent walls, and with walls that mate beyond a wavelength, are closed with the
choices that the model leaves open. The wavelength of each measured joint is fitted to the closure
of its first loading. All else is then judged: stiffness and closure of the later loading, the
share of it that stays, and the area of contact. The strength of the rock was not published either.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.engine.points import Point
from jointclosure.engine.settings import ClosureSettings
from jointclosure.mechanics.strength import strength_factor
from jointclosure.parameters.units import to_si
from studies.frame.config.configuration import Configured, refuse
from studies.frame.config.keys.measured_joints import MeasuredJointsKeys
from studies.frame.ensemble.cases import base_case
from studies.frame.ensemble.wavelengths import labelled_wavelengths
from studies.frame.experiments import Design, Experiment, Tables, settings_of
from studies.measured_joints.figures import measured_joints_figure
from studies.measured_joints.observables import BASE, FILM_CELL, judged_joints, observables_of
from studies.measured_joints.prediction import prediction_table


def measured_joints_design(configured: Configured) -> Design:
    """Make a job for each mismatch wavelength: all choices of the model.

    Raises
    ------
    ConfigurationError
        If the study has several rocks, or sets walls that the experiment sets.
    """
    configuration = configured.typed
    section = MeasuredJointsKeys.model_validate(configured.keys["measured_joints"])
    refuse(_problems(configured.keys))
    si = to_si(section.model_dump())
    ((rock, of_rock),) = configuration.rocks.items()
    case = base_case(rock, of_rock)
    jobs = {}
    for label, wavelength in labelled_wavelengths(sorted(si["mismatch_wavelength"])).items():
        settings = settings_of(configuration, case, mismatch_wavelength=wavelength)
        length = np.inf if wavelength is None else wavelength
        jobs[label] = [
            point._replace(coordinates=point.coordinates | {"variant": name, "wavelength": length})
            for name, point in _variants(settings, si).items()
        ]
    spacing = configuration.grid.spacing
    parameters = {
        "film_cells": (FILM_CELL / spacing) ** 2,
        "root_seed": configuration.study.root_seed,
    }
    tables = ("measured_joints", "measured_joints_predictions")
    return Design(jobs, tables, ("measured_joints",), parameters)


def _problems(keys: dict) -> Iterator[str]:
    """Generate the reasons why the joints of a configuration cannot be closed."""
    surface, rocks = keys["surface"], keys["study"]["rocks"]
    if len(rocks) != 1:
        yield f"study.rocks = {rocks}: must be one rock (measured_joints)"
    given = (surface["mismatch_wavelength_mm"], surface["correlation"], surface["shift_in_cells"])
    if given != (None, 0.0, 0):
        yield (
            "measured_joints: the study sets surface.mismatch_wavelength_mm; it, correlation and "
            "shift_in_cells must be null, 0 and 0"
        )
    if keys["study"]["cycles"] < 2:
        yield f"study.cycles = {keys['study']['cycles']}: must be at least 2 (measured_joints)"
    largest = max(keys["measured_joints"]["reseating_shift_in_cells"], default=0)
    if largest > keys["grid"]["cells_x"] - 8:
        yield (
            f"measured_joints.reseating_shift_in_cells = {largest}: must leave at least 8 of "
            f"grid.cells_x = {keys['grid']['cells_x']}"
        )


def _variants(settings: ClosureSettings, si: Mapping[str, Any]) -> dict[str, Point]:
    """Make the points of all choices for walls of one wavelength, by name of the choice."""
    rocks = {BASE: settings}
    for value in si["compressive_strength"]:
        intact = settings.case.intact._replace(compressive_strength=value)
        case = settings.case._replace(intact=intact)
        rocks[f"strength {1e-6 * value:g} MPa"] = settings._replace(case=case)
    points = dict(rocks)
    for value in si["peak_modulus_ratio"]:
        choices = settings.choices._replace(peak_modulus_ratio=value)
        points[f"peak modulus ratio {value:g}"] = settings._replace(choices=choices)
    for value in si["largest_radius"]:
        choices = settings.choices._replace(largest_radius=value)
        points[f"radii up to {1e3 * value:g} mm"] = settings._replace(choices=choices)
    for value in si["hardness_over_strength"]:
        points[f"pressure up to {value:g} times the strength"] = _hardness(settings, value)
    variants = {name: Point({"loaded_as": name}, changed) for name, changed in points.items()}
    for rock, of_rock in rocks.items():
        for shift in si["reseating_shift_in_cells"]:
            name = f"reseated, {1e3 * shift * settings.surfaces.grid.spacing:g} mm off"
            name = name if rock == BASE else f"{rock}, {name}"
            once = of_rock._replace(cycles=1)
            variants[name] = Point({"loaded_as": rock}, once, "reseated", {"shift": shift})
    return variants


def _hardness(settings: ClosureSettings, ratio: float) -> ClosureSettings:
    """Return settings that limit the mean pressure of a contact to a multiple of the strength.

    Resolved breakage takes off just what brings a contact back to its limit. Without gouge this is
    the plastic displacement of a contact whose pressure is limited. The limit of the peak pressure,
    3/2 of the mean pressure under a sphere, is sigma_c / c(nu) (`strength_factor`).
    """
    case = settings.case
    intact = case.intact
    strength = 1.5 * ratio * strength_factor(intact.poisson_ratio) * intact.compressive_strength
    limited = case._replace(
        intact=intact._replace(compressive_strength=float(strength)),
        effects=case.effects._replace(gouge=False),
    )
    numerics = settings.numerics._replace(breakage="resolved")
    return settings._replace(case=limited, numerics=numerics)


def measured_joints_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return all tables by name."""
    observables = observables_of(joints, parameters["film_cells"])
    return {
        "measured_joints": judged_joints(observables, parameters["root_seed"]),
        "measured_joints_predictions": prediction_table(observables),
    }


EXPERIMENT = Experiment(
    title="the model beside measured joints",
    quantities=(
        "max_closure_seated_net",
        "residual_closure_seated_net",
        "stiffness_net",
        "contact_at_max",
    ),
    design=measured_joints_design,
    tabulate=measured_joints_tables,
    draw=lambda name, tables, parameters: measured_joints_figure(tables[name]),
)
