"""Walls that are tilted or rotated: which joints are closed, and the table and figure of them."""

import numpy as np
import pytest

from jointclosure.joint.curves import cycle_table
from jointclosure.joint.simulation import close_walls
from jointclosure.walls.synthesis import wall_pair
from studies.frame.points import gridded
from studies.frame.settings import seeds_of
from studies.misalignment.study import EXPERIMENT
from tests.studied import tiny

TINY = tiny("misalignment")


@pytest.fixture(scope="module")
def run(joints):
    """Over (wavelength, tilt, rotation, realization, cycle); tilted and rotated is not closed."""
    return gridded(joints, ("wavelength", "tilt", "rotation", "realization"), EXPERIMENT.quantities)


def test_every_tilt_and_every_rotation_is_closed_alone(design, joints):
    assert list(design.jobs()) == ["slate.770um", "slate.independent"]
    angles = [
        (point.coordinates["tilt"], point.coordinates["rotation"])
        for point in design.jobs()["slate.770um"]
    ]
    assert angles == [(0.0, 0.0), (3.0, 0.0), (0.0, 45.0)]
    assert joints.wavelength.unique().tolist() == [0.77e-3, np.inf]
    assert (joints.status < 16).all()


def test_aligned_walls_close_as_everywhere(design, run):
    settings = design.jobs()["slate.770um"][0].settings
    surfaces = settings.surfaces
    made = {"mismatch_wavelength": 0.77e-3, "roll_off": surfaces.surface.roll_off}
    spacing, seed = surfaces.grid.spacing, seeds_of(surfaces)[2]
    upper, lower = wall_pair(surfaces.jrc, (24, 24), spacing, seed, **made)
    closed = close_walls(upper, lower, settings.conditions)
    aligned = run.sel(wavelength=0.77e-3, tilt=0.0, rotation=0.0, realization=2)
    np.testing.assert_allclose(aligned.max_closure, closed.max_closure, rtol=1e-6)
    residual = 1e-3 * cycle_table(closed).residual_closure_seated_net_mm
    np.testing.assert_allclose(aligned.residual_closure_seated_net, residual, rtol=1e-6)


def test_a_tilt_is_kept_while_walls_close(run):
    """First touch is at the raised edge: the closure from there grows."""
    first = run.max_closure.sel(cycle=1, rotation=0.0).mean("realization")
    assert (first.sel(tilt=3.0) > 1.05 * first.sel(tilt=0.0)).all()


def test_a_rotation_unmates_walls_that_mate(run):
    first = run.max_closure.sel(cycle=1, tilt=0.0, wavelength=0.77e-3).mean("realization")
    assert first.sel(rotation=45.0) > 1.3 * first.sel(rotation=0.0)


def test_changes_are_those_of_the_same_surfaces(tables, run):
    table = tables["misalignment"]
    here = table[(table.wavelength_mm == np.inf) & (table.tilt_degrees == 3.0) & (table.cycle == 2)]
    independent = run.sel(wavelength=np.inf, rotation=0.0, cycle=2)
    tilted, aligned = (independent.max_closure.sel(tilt=tilt).values for tilt in (3.0, 0.0))
    closure = here[here.response == "max_closure"].iloc[0]
    assert closure.change_percent == pytest.approx(100.0 * (tilted.mean() / aligned.mean() - 1.0))
    scatter = tilted - tilted.mean() / aligned.mean() * aligned
    error = scatter.std(ddof=1) / np.sqrt(4) / aligned.mean()
    assert closure.change_error == pytest.approx(100.0 * error)
    assert closure.samples == 4
    compliance = 1e9 / independent.stiffness_net.sel(tilt=3.0)
    stiffness = here[here.response == "stiffness_net"].iloc[0]
    assert stiffness.value == pytest.approx(1.0 / float(compliance.mean()))
    unmoved = table[(table.tilt_degrees == 0.0) & (table.rotation_degrees == 0.0)]
    assert (unmoved.change_percent == 0.0).all()
