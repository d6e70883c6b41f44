"""What is measured of a wall is what it was made with."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.randomness import generator
from jointclosure.walls.gridding import wall_on_grid
from jointclosure.walls.jrc import RELATIONS, rms_slope
from jointclosure.walls.scans import read_scan
from jointclosure.walls.synthesis import Spectrum, synthetic_wall
from jointclosure.walls.wall_roughness import hurst_of, mean_curvature, measure_wall, peak_cells
from tests.joints import SPACING, TWO_WALLS, bump

MEASURED = TWO_WALLS.parent / "foliation_joint_0p25mm.npz"


def measured(wall):
    return {m.name: m for m in measure_wall(wall, SPACING, resamples=40)}


@pytest.fixture(scope="module")
def rough():
    """A wall, and its measures by name."""
    wall = jc.wall_pair(9.0, (70, 60), SPACING, seed=2)[0]
    return wall, measured(wall)


def test_every_measure_lies_within_its_interval(rough):
    assert all(m.low < m.value < m.high for m in rough[1].values())


def test_the_slope_is_that_of_the_wall(rough):
    wall, found = rough
    exact = np.sqrt(np.mean(np.diff(wall, axis=1) ** 2)) / SPACING
    assert found["Z2 along x"].value == pytest.approx(exact, rel=1e-12)


def test_the_rms_height_is_that_of_the_wall(rough):
    wall, found = rough
    assert found["rms height"].value == pytest.approx(1e3 * wall.std(), rel=1e-12)


@pytest.mark.parametrize("name", RELATIONS)
def test_each_relation_gives_the_jrc_that_a_wall_was_made_with(name):
    relation = RELATIONS[name]
    values = []
    for seed in range(2):
        wall = jc.wall_pair(9.0, (32, 32), relation.interval, seed, jrc_relation=name)[0]
        found = {m.name: m for m in measure_wall(wall, relation.interval, resamples=2)}
        values.append(found[f"JRC, {name}"].value)
        assert f"at its {1e3 * relation.interval:g} mm; holds" in found[f"JRC, {name}"].remark
    assert np.mean(values) == pytest.approx(9.0, abs=0.3)


@pytest.fixture(scope="module", params=[0.6, 1.0])
def self_affine(request):
    """A Hurst exponent, and walls that were made with it."""
    made = 0.2, (80, 80), SPACING, Spectrum(request.param)
    return request.param, [synthetic_wall(*made, generator(seed)) for seed in range(16)]


def test_the_hurst_exponent_is_recovered(self_affine):
    hurst, walls = self_affine
    assert np.mean([hurst_of(wall) for wall in walls]) == pytest.approx(hurst, abs=0.04)


def test_the_interval_of_the_hurst_exponent_covers_it(self_affine):
    hurst, walls = self_affine
    intervals = [measured(wall)["H, both directions"] for wall in walls[:5]]
    assert sum(m.low <= hurst <= m.high for m in intervals) >= 4


def test_a_cap_is_one_peak_of_its_own_curvature():
    wall = bump((41, 41), 10e-3)
    assert np.argwhere(peak_cells(wall)).tolist() == [[20, 20]]
    np.testing.assert_allclose(mean_curvature(wall, SPACING)[1:-1, 1:-1], 100.0, rtol=1e-9)
    found = measured(wall)
    assert found["mean curvature of peaks"].value == pytest.approx(0.1, rel=1e-9)
    assert found["rms curvature along x"].value == pytest.approx(0.1, rel=1e-9)
    assert found["peaks"].value == pytest.approx(1.0 / (39 * 39 * 0.25**2), rel=1e-9)


def test_missing_cells_are_left_out_of_the_measures():
    wall = jc.wall_pair(9.0, (90, 80), SPACING, seed=2)[0]
    holed = wall.copy()
    holed[:30, :30] = np.nan
    whole, part = measured(wall), measured(holed)
    for name, found in part.items():
        assert found.low < whole[name].value < found.high, name


def test_a_wall_too_small_to_be_measured_is_refused():
    with pytest.raises(jc.InputError, match=r"20 x 40 cells .* need at least 24"):
        measure_wall(np.zeros((20, 40)), SPACING)


@pytest.mark.skipif(not MEASURED.is_file(), reason="the scanned wall is not part of the project")
def test_the_measured_wall_has_the_roughness_that_it_was_published_with():
    scan = read_scan(MEASURED, variable="patch63_mm")
    wall = wall_on_grid(scan, SPACING)
    assert wall.shape == (63, 63)
    # rms 0.255 mm and Z2 of 0.115 and 0.152 along its axes, as its README has them
    assert 1e3 * wall.std() == pytest.approx(0.255, abs=5e-4)
    slopes = sorted(np.sqrt(np.mean(np.diff(wall, axis=a) ** 2)) / SPACING for a in (0, 1))
    assert slopes == pytest.approx([0.115, 0.152], abs=6e-4)
    assert rms_slope(wall, SPACING) == pytest.approx(measured(wall)["Z2, both directions"].value)
