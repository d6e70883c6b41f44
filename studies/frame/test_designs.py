"""What holds of every experiment: bad designs are refused by key, and jobs change no bit."""

import pandas as pd
import pytest

from jointclosure.engine.ensembles import close_points
from jointclosure.engine.quantities import QUANTITIES
from studies.frame.configuration import sections
from studies.frame.experiments import checked_design, experiment_named, experiments_in
from studies.frame.files import ConfigurationError
from tests.studied import DEFAULT, checked_study, tiny

TINY = {name: tiny(name) for name in sections()}


def of_inputs(**inputs):
    return {"global_sensitivity": {"inputs": inputs}}


REFUSED = [
    ("assessment", {"assessment": {"joints": 1}}, "assessment.joints = 1: must be at least 2"),
    ("assessment", {"assessment": {"stress_MPa": [0.5]}}, "stress_MPa = 0.5: must be more than"),
    ("global_sensitivity", {"global_sensitivity": {"rows": 48}}, "rows = 48: must be a power of 2"),
    ("global_sensitivity", of_inputs(jrc={"values": [6]}), "inputs.jrc: must have either"),
    ("global_sensitivity", of_inputs(jrc={"between": [9, 6]}), "[9.0, 6.0]: must ascend"),
    ("global_sensitivity", of_inputs(jrc={"between": [6, 60]}), "rocks.dolerite.jrc = 60"),
    (
        "global_sensitivity",
        of_inputs(jrc={"key": "grid.cells_x", "between": [9, 64]}),
        "must begin",
    ),
    ("misalignment", {"misalignment": {"tilt_degrees": [0.1]}}, "tilt_degrees: must have 0 among"),
    ("misalignment", {"misalignment": {"rotation_degrees": [360]}}, "rotation_degrees = 360"),
    ("misalignment", {"grid": {"cells_y": 20}}, "grid.cells_x = 24: must be cells_y (20)"),
    ("mismatch", {"mismatch": {"shift_in_cells": [1]}}, "shift_in_cells = [1]: must contain 0"),
    ("mismatch", {"mismatch": {"wavelength_mm": [-1]}}, "wavelength_mm = -1: must be at least"),
    ("mismatch", {"surface": {"correlation": 0.5}}, "the study sets surface.mismatch_wavelength"),
    ("size", {"size": {"spacing_mm": [0.15, 0.25]}}, "spacing_mm = 0.25: must be a multiple of"),
    ("size", {"size": {"patch_mm": [3, 4]}}, "patch_mm = 3: must be a whole part of 4"),
    ("size", {"size": {"spectra": {"flat": {"roll_off_mm": 0.2}}}}, "spectra.flat: roll_off"),
]


@pytest.mark.parametrize(("name", "change", "reason"), REFUSED)
def test_a_design_that_cannot_be_closed_is_refused_by_its_key(name, change, reason):
    with pytest.raises(ConfigurationError) as error:
        checked_design(name, checked_study(TINY[name], change))
    assert reason in str(error.value)


@pytest.mark.parametrize("name", sections())
def test_a_study_without_the_section_does_not_run_the_experiment_nor_bear_its_name(name):
    assert name not in experiments_in(DEFAULT)
    with pytest.raises(ConfigurationError, match=f"study.name = '{name}'"):
        checked_study({"study": {"name": name}})


@pytest.mark.parametrize("name", sections())
def test_a_point_closed_alone_has_the_bits_that_it_has_in_its_job(name):
    experiment = experiment_named(name)
    assert set(experiment.quantities) <= set(QUANTITIES)
    points = list(next(iter(experiment.design(checked_study(TINY[name])).jobs.values())))[:2]
    together = close_points(points, experiment.quantities).drop(columns="seconds")
    alone = close_points(points[-1:], experiment.quantities).drop(columns="seconds")
    own = together.tail(len(alone)).reset_index(drop=True)
    pd.testing.assert_frame_equal(own[alone.columns], alone, check_exact=True)
