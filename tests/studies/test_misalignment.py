"""Walls that are tilted or rotated: what is closed, and what is told of it."""

import matplotlib
import numpy as np
import pytest
import xarray as xr

from jointclosure.config.files import ConfigurationError
from jointclosure.engineering.curves import cycle_table
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.surfaces import seeds_of
from jointclosure.plotting.misalignment import misalignment_figure
from jointclosure.studies.misalignment.closing import close_misaligned
from jointclosure.studies.misalignment.design import design_of, settings_of
from jointclosure.studies.misalignment.table import misalignment_table
from jointclosure.surface.synthesis import wall_pair
from tests.studied import checked_study

TINY = {
    "study": {"name": "tiny_misalignment", "rocks": ["slate"], "realizations": 4},
    "grid": {"cells_x": 24, "cells_y": 24},
    "rocks": {"slate": {"max_normal_stress_MPa": 5}},
    "misalignment": {
        "tilt_degrees": [3, 0],
        "rotation_degrees": [0, 45],
        "mismatch_wavelength_mm": [0.77],
    },
}


def settings(label):
    study = checked_study(TINY)
    return settings_of(design_of(study.keys), study.typed, "slate", label)


@pytest.fixture(scope="module")
def run():
    closed = [close_misaligned(settings(label)) for label in ("770um", "independent")]
    return xr.concat(closed, "wavelength")


def test_every_tilt_and_every_rotation_is_closed_alone(run):
    assert run.tilt.values.tolist() == [0.0, 3.0, 0.0]
    assert run.rotation.values.tolist() == [0.0, 0.0, 45.0]
    assert run.wavelength.values.tolist() == [0.77e-3, np.inf]
    assert (run.status < 16).all()


def test_aligned_walls_close_as_everywhere(run):
    told = settings("770um").closures
    upper, lower = wall_pair(
        told.surfaces.jrc,
        (24, 24),
        told.surfaces.grid.spacing,
        seeds_of(told.surfaces)[2],
        mismatch_wavelength=0.77e-3,
        roll_off=told.surfaces.surface.roll_off,
    )
    closed = close_walls(upper, lower, told.conditions())
    own = run.isel(wavelength=0, condition=0, realization=2)
    stays = 1e-3 * cycle_table(closed).residual_net_at_seating_mm
    np.testing.assert_allclose(own.closure, closed.max_closure, rtol=1e-6)
    np.testing.assert_allclose(own.residual_seated_net, stays, rtol=1e-6)


def test_a_tilt_is_kept_while_walls_close(run):
    """First touch is at the raised edge: the closure from there grows."""
    first = run.closure.sel(cycle=1).mean("realization")
    assert (first[:, 1] > 1.05 * first[:, 0]).all()


def test_a_rotation_unmates_walls_that_mate(run):
    first = run.closure.sel(cycle=1).mean("realization")
    assert first[0, 2] > 1.3 * first[0, 0]


def test_changes_are_those_of_the_same_surfaces(run):
    table = misalignment_table({"slate": run})
    here = table[(table.wavelength_mm == np.inf) & (table.tilt_degrees == 3.0) & (table.cycle == 2)]
    own, before = (run.closure.sel(cycle=2).isel(wavelength=1, condition=k).values for k in (1, 0))
    closure = here[here.response == "closure"].iloc[0]
    assert closure.change_percent == pytest.approx(100.0 * (own.mean() / before.mean() - 1.0))
    scatter = own - own.mean() / before.mean() * before
    error = scatter.std(ddof=1) / np.sqrt(4) / before.mean()
    assert closure.change_error == pytest.approx(100.0 * error)
    assert closure.samples == 4
    compliance = 1e9 / run.stiffness_net.sel(cycle=2).isel(wavelength=1, condition=1)
    stiffness = here[here.response == "stiffness_net"].iloc[0]
    assert stiffness.value == pytest.approx(1.0 / float(compliance.mean()))
    aligned = table[(table.tilt_degrees == 0.0) & (table.rotation_degrees == 0.0)]
    assert (aligned.change_percent == 0.0).all()
    figure = misalignment_figure(table)
    assert isinstance(figure, matplotlib.figure.Figure)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"misalignment": {"tilt_degrees": [0.1]}}, "misalignment.tilt_degrees: must have 0 among"),
        ({"misalignment": {"rotation_degrees": [360]}}, "misalignment.rotation_degrees = 360"),
        ({"grid": {"cells_y": 20}}, "grid.cells_x = 24: must be cells_y (20) where walls are rot"),
        ({"surface": {"correlation": 0.5}}, "misalignment: the study sets surface.mismatch_wave"),
        ({"surface": {"normalise": "expectation"}}, "surface.normalise = 'expectation': must be"),
        ({"study": {"name": "misalignment"}, "misalignment": None}, "belongs to another target"),
    ],
)
def test_a_design_that_cannot_be_closed_is_refused(change, said):
    with pytest.raises(ConfigurationError) as error:
        design_of(checked_study(TINY, change).keys)
    assert said in str(error.value)
