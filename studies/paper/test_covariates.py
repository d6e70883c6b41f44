"""Covariates of pairs of walls: those of the walls that are closed, and their known means."""

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.walls.jrc import z2_of_jrc
from studies.frame.cases import block_settings, cases_of, joint_grid, synthesis
from studies.frame.settings import walls_of
from studies.paper.covariates import (
    Covariates,
    as_dataset,
    covariates_of_pair,
    known_covariates,
    measure_covariates,
    read_covariates,
)
from tests.studied import study_of
from tests.world import world

SMALL = {
    "study": {"rocks": ["slate", "dolerite"], "realizations": 4, "pool": None},
    "grid": {"cells_x": 24, "cells_y": 20},
}


def made_by(configuration):
    """Return grid and synthesis of the walls of a study."""
    return joint_grid(configuration), synthesis(configuration)


def test_covariates_are_those_of_the_walls_that_were_closed():
    configuration = study_of(SMALL)
    values = measure_covariates(world(configuration), *made_by(configuration))
    for i, case in enumerate(cases_of(configuration)):
        z2 = z2_of_jrc(case.jrc, configuration.grid.spacing, configuration.surface.hurst)
        walls = walls_of(block_settings(configuration, case, range(4)))
        for j, (upper, lower) in enumerate(walls):
            expected = covariates_of_pair(upper, lower, z2)
            np.testing.assert_array_equal(values[i, j], expected)
            # of 480 cells 1 % end between the fourth and fifth highest, 5 % at the 24th
            highest = np.sort((upper + lower).ravel())[::-1]
            depth = highest[0] - highest[[3, 4]]
            at_five = highest[0] - highest[23]
            assert depth[0] <= z2 * expected[0] <= depth[1]
            assert z2 * expected[1] == pytest.approx(at_five, rel=1e-12)


@pytest.mark.parametrize("normalise", ["wall", "expectation"])
def test_covariates_of_one_noise_are_the_same_at_every_jrc(normalise):
    changes = {"study": {"draws": "common"}, "surface": {"normalise": normalise}}
    configuration = study_of(SMALL, changes)
    study = world(configuration)
    values = measure_covariates(study, *made_by(configuration))
    for rock in ("slate", "dolerite"):
        here = (study.rock == rock).values
        own = values[here]
        assert len(set(study.jrc.values[here])) == 3
        np.testing.assert_allclose(own, np.broadcast_to(own[0], own.shape), rtol=1e-10)


def test_means_are_known_within_the_error_that_they_tell():
    configuration = study_of(SMALL)
    one, other = (known_covariates(400, seed, *made_by(configuration)) for seed in (1, 2))
    off = one.means - other.means
    error = np.sqrt(sum(np.diag(each.covariance) / each.surfaces for each in (one, other)))
    assert np.all((off != 0.0) & (np.abs(off) < 4.0 * error))
    assert np.all(error < 0.05 * one.means)


def test_covariates_come_back_from_their_file(tmp_path):
    configuration = study_of(SMALL)
    study = world(configuration)
    known = known_covariates(20, 1, *made_by(configuration))
    values = measure_covariates(study, *made_by(configuration))
    study.attrs["key"] = "of this study"
    file = tmp_path / "covariates.nc"
    write_netcdf(as_dataset(Covariates(values, known), study), file)
    with pytest.raises(InputError, match=f"{file}: is not of this study"):
        read_covariates(file, study.assign_attrs(key="of another one"))
    again = read_covariates(file, study)
    np.testing.assert_array_equal(again.values, values)
    for one, other in zip(again.known, known, strict=True):
        np.testing.assert_array_equal(one, other)
    first = again.of_cycle(1)
    later = again.of_cycle(2)
    assert (first.values.shape[-1], later.values.shape[-1]) == (2, 1)
    assert first.known.means.tolist() == known.means[:2].tolist()
    assert later.known.covariance.tolist() == [[known.covariance[2, 2]]]
