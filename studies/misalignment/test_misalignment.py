"""Joints whose walls are tilted or rotated."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.inputs import InputError
from jointclosure.walls.jrc import rms_slope, z2_of_jrc
from jointclosure.walls.planes import detrended
from jointclosure.walls.synthesis import spectrum_of, wall_pair
from studies.frame.joint_tables import gridded
from studies.frame.settings import seeds_of
from studies.misalignment.study import EXPERIMENT, mean_changes, rotated_pair, tilted
from tests.joints import SPACING


@pytest.fixture(scope="module")
def run(joints):
    """Joints over (wavelength, tilt, rotation, realization, cycle); none is tilted and rotated."""
    return gridded(joints, ("wavelength", "tilt", "rotation", "realization"), EXPERIMENT.quantities)


@pytest.fixture(scope="module")
def first_closures(run):
    return run.max_closure.sel(cycle=1).mean("realization")


def test_a_tilt_is_kept_while_walls_close(first_closures):
    """First touch is at the raised edge: the closure from there grows."""
    aligned = first_closures.sel(tilt=0.0, rotation=0.0)
    assert (first_closures.sel(tilt=3.0, rotation=0.0) > 1.05 * aligned).all()


def test_a_rotation_unmates_walls(first_closures):
    mated = first_closures.sel(tilt=0.0, wavelength=0.77e-3)
    assert mated.sel(rotation=45.0) > 1.3 * mated.sel(rotation=0.0)


def test_changes_are_those_of_the_same_surfaces(tables, run):
    table = tables["misalignment"]
    angles = table[["tilt_degrees", "rotation_degrees"]].drop_duplicates().to_numpy()
    assert angles.tolist() == [[0.0, 0.0], [3.0, 0.0], [0.0, 45.0]]
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


SHAPE, ROLL_OFF = (40, 40), 3e-3
Z2 = z2_of_jrc(8.0, SPACING, 0.8)
SPECTRUM = spectrum_of(0.8, "self_affine", ROLL_OFF, SPACING)


def rotated(seed, rotation=0.0, wavelength=1.03e-3):
    return rotated_pair(Z2, SHAPE, SPACING, SPECTRUM, seed, wavelength, rotation)


def test_aligned_walls_are_those_of_every_other_study(jobs):
    aligned = jobs["slate.770um"][0]
    settings = aligned.settings
    made = {"mismatch_wavelength": 0.77e-3}
    made["roll_off"] = settings.surface.roll_off
    spacing = settings.grid.spacing
    seed = seeds_of(settings)[0]
    stated = wall_pair(settings.case.jrc, settings.grid.shape, spacing, seed, **made)
    for mine, other in zip(next(aligned.walls()), stated, strict=True):
        np.testing.assert_allclose(mine, other, atol=1e-11 * other.std())


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_puts_cells_on_cells(quarters):
    _, before = rotated(5)
    _, after = rotated(5, 90.0 * quarters)
    turned = np.rot90(before, -quarters)  # rows are y, which points down in rot90's picture
    np.testing.assert_allclose(after / after.std(), turned / turned.std(), atol=1e-10)


def test_a_rotation_damps_no_wave():
    """Slopes and second differences stay; a cubic spline takes 5 and 10 % of them."""
    ratios = []
    for seed in range(24):
        upper, lower = rotated(seed, 45.0, np.inf)
        bend = [np.mean(np.diff(wall, 2, axis=1) ** 2) for wall in (upper, lower)]
        ratios.append((rms_slope(lower, SPACING) / rms_slope(upper, SPACING), bend[1] / bend[0]))
    slope, bend = np.mean(ratios, axis=0)
    assert slope == pytest.approx(1.0, abs=0.02)
    assert np.sqrt(bend) == pytest.approx(1.0, abs=0.04)


def test_a_tilt_is_a_plane_of_its_angle_about_the_middle():
    wall = detrended(np.random.default_rng(1).standard_normal((5, 8)))
    leaning = tilted(wall, SPACING, 0.5)
    np.testing.assert_allclose(np.diff(leaning - wall, axis=1), SPACING * np.tan(np.pi / 360.0))
    assert leaning.mean() == pytest.approx(wall.mean(), abs=1e-15)
    np.testing.assert_allclose(detrended(leaning), wall, atol=1e-12)


def test_a_wall_that_is_not_square_is_not_rotated():
    with pytest.raises(InputError, match=r"shape = \(40, 30\): a wall is rotated on a square"):
        rotated_pair(Z2, (40, 30), SPACING, SPECTRUM, 1)


def test_a_change_is_of_the_surfaces_that_closed_both_ways():
    rows = [
        {"tilt": tilt, "realization": i, "cycle": 1, "max_closure": value}
        for tilt, values in ((0.0, (1.0, 2.0, 4.0, np.nan)), (1.0, (1.5, 3.0, np.nan, 9.0)))
        for i, value in enumerate(values)
    ]
    table = mean_changes(pd.DataFrame(rows), ["tilt"], ["max_closure"], {"tilt": 0.0})
    changed = table.iloc[1]
    assert changed.samples == 2
    assert changed.change_percent == pytest.approx(50.0)
    assert changed.change_error == pytest.approx(0.0, abs=1e-12)
    assert table.iloc[0].samples == 3
