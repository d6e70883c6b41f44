"""Errors of registered walls: displaced within the errors of the fit, and without noise."""

import numpy as np
import pytest
import scipy

import jointclosure as jc
from jointclosure.joint.conditions import Conditions
from jointclosure.uncertainty.sources import sources_of
from jointclosure.uncertainty.variants import Variant
from jointclosure.walls.gridding import Scan
from jointclosure.walls.jrc import rms_slope
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.planes import detrended
from jointclosure.walls.registration import registered
from jointclosure.walls.scan_defects import cut_rim, inspected
from jointclosure.walls.scan_errors import ScanErrors, noise_of, scale_of, scales_differ
from tests.joints import SPACING
from tests.walls.sampled import noisy, sampled_walls, scan_of

SHAPE = (96, 96)


def errors(noise=0.0, offset=(0.0, 0.0, 0.0), shape=SHAPE):
    middle = 0.5 * (np.array(shape[::-1]) - 1.0)
    holes = np.zeros(shape, bool)
    return ScanErrors(np.array(offset), np.zeros((3, 3)), middle, (noise, noise), holes)


@pytest.fixture(scope="module")
def walls():
    return sampled_walls()


def test_walls_are_displaced_as_a_motion_moves_points():
    y, x = np.indices(SHAPE, float)

    def wave(x, y):
        return detrended(np.sin(0.13 * x + 0.05 * y) + np.cos(0.11 * y))

    turn, along_x, along_y = 0.01, 0.4, -0.2
    moved = errors(offset=(turn, along_x, along_y)).displaced(wave(x, y), 1)
    from_x, from_y = x - along_x - 47.5, y - along_y - 47.5  # turned back about the middle
    expected = wave(from_x + turn * from_y + 47.5, from_y - turn * from_x + 47.5)
    np.testing.assert_allclose(moved[4:-4, 4:-4], expected[4:-4, 4:-4], atol=5e-3)


@pytest.fixture(scope="module", params=[5e-6, 15e-6])
def other_noise(request, walls):
    """Deviation of the noise of scans, the scans, and two pairs with other noise."""
    scanned = noisy(walls, request.param)
    known = errors(float(np.sqrt(2.0) * request.param))
    return request.param, scanned, [known.with_other_noise(*scanned, n) for n in (1, 2)]


def test_other_noise_changes_walls_by_its_size(other_noise):
    noise, scanned, draws = other_noise
    for rough, *drawn in zip(scanned, *draws, strict=True):
        for wall in drawn:
            assert 0.5 * noise < np.std(wall - rough) < 1.2 * noise
    assert 0.7 * noise < np.std(draws[0][0] - draws[1][0]) < 1.7 * noise


def test_other_noise_takes_at_most_its_own_power(other_noise, walls):
    _, scanned, draws = other_noise
    for true, rough, *drawn in zip(walls, scanned, *draws, strict=True):
        for wall in drawn:
            slopes = [rms_slope(one, SPACING) for one in (true, wall, rough)]
            assert 0.98 * slopes[0] < slopes[1] < 1.02 * slopes[2]


def test_the_noise_may_be_all_that_keeps_mated_walls_apart():
    wall = jc.wall_pair(8.0, SHAPE, SPACING, 1, roll_off=None, unusual_values=True)[0]
    scanned = noisy((wall, -wall), 10e-6)
    low, high = noise_of(*scanned)
    assert low <= np.std(sum(scanned)) * 1.1
    assert high == pytest.approx(np.std(sum(scanned)), rel=0.1)
    apart = [np.std(sum(errors(high).with_other_noise(*scanned, n))) for n in range(1, 25)]
    assert min(apart) < 0.5 * high < 0.8 * high < max(apart)


@pytest.fixture(scope="module")
def filled_holes(walls):
    """Holes, the upper wall which is out of contact there, and two pairs with drawn heights."""
    holes = np.zeros(SHAPE, bool)
    for y, x in np.ndindex(4, 4):
        holes[20 * y + 5 : 20 * y + 11, 20 * x + 5 : 20 * x + 11] = True
    upper = np.where(holes, walls[0] - 0.5e-3, walls[0])
    known = errors()._replace(holes=holes)
    return holes, upper, [known.with_filled_holes(upper, walls[1], n) for n in (1, 2)]


def test_only_heights_in_holes_are_drawn(filled_holes, walls):
    holes, upper, drawn = filled_holes
    for pair in drawn:
        np.testing.assert_array_equal(pair[1], walls[1])
        np.testing.assert_array_equal(pair[0][~holes], upper[~holes])


def test_heights_in_holes_are_as_high_as_the_walls_around_them(filled_holes, walls):
    holes, _, drawn = filled_holes
    for pair in drawn:
        apart = (sum(pair) - sum(walls))[holes]
        assert abs(apart.mean()) < 0.1e-3


def test_heights_in_holes_are_as_rough_as_the_walls_around_them(filled_holes, walls):
    holes, _, drawn = filled_holes
    true = sum(walls)
    for pair in drawn:
        steps = [rms_slope(np.where(holes, field, true), SPACING) for field in (sum(pair), true)]
        assert steps[0] == pytest.approx(steps[1], rel=0.1)


def test_heights_in_holes_differ_between_draws_as_from_the_true_ones(filled_holes, walls):
    holes, _, drawn = filled_holes
    apart = (sum(drawn[1]) - sum(walls))[holes]
    between = (drawn[0][0] - drawn[1][0])[holes].std()
    assert 0.7 * apart.std() < between < 2.0 * apart.std()


def mean_square_step(wall):
    """Mean square difference of neighbouring heights, along both axes."""
    return np.mean([np.mean(np.diff(wall, axis=axis) ** 2) for axis in (0, 1)])


def test_short_waves_that_interpolation_took_from_a_wall_are_restored(walls):
    scanned = scipy.ndimage.gaussian_filter(walls[0], 0.6, mode="mirror"), walls[1]
    steps = [mean_square_step(wall) for wall in (walls[0], scanned[0])]
    known = errors(5e-6)._replace(lost_square=steps[0] - steps[1])
    drawn = known.with_other_noise(*scanned, 1)
    short = np.hypot(*np.ogrid[0.0:1.0:96j, 0.0:1.0:96j]) > 0.5
    lost, restored, true = (
        sum((scipy.fft.dctn(wall, norm="ortho")[short] ** 2).mean() for wall in pair)
        for pair in (scanned, drawn, walls)
    )
    assert lost < 0.7 * true
    assert restored == pytest.approx(true, rel=0.15)


def test_walls_without_noise_are_themselves(walls):
    for wall, drawn in zip(walls, errors().with_other_noise(*walls, 1), strict=True):
        np.testing.assert_allclose(drawn, wall, atol=1e-12)
    flat = np.zeros(SHAPE)
    upper, lower = errors(1e-5).with_other_noise(flat, walls[1], 1)
    assert not upper.any()
    assert 0.0 < np.std(lower - walls[1]) < 3e-5


@pytest.mark.parametrize("noise", [0.0, 5e-6, 15e-6])
def test_the_noise_is_found_beside_the_waves_that_are_shorter_than_the_grid(walls, noise):
    low, high = noise_of(*noisy(walls, noise))
    assert np.sqrt(2.0) * noise * 0.8 <= low <= high < np.sqrt(2.0) * noise + 12e-6


def test_errors_of_a_pair_are_those_of_its_fit():
    upper, lower = jc.wall_pair(8.0, SHAPE, SPACING, 1, roll_off=None, mismatch_wavelength=1e-3,
                                unusual_values=True)  # fmt: skip
    upper, lower = noisy((upper, lower), 3e-6)
    scans = [Scan(z, (SPACING, SPACING), (0.0, 0.0)) for z in (-upper + 2e-3, lower)]
    pair = registered(*scans)
    assert pair.errors.covariance[1, 1] == pytest.approx(pair.motion.covariance[1, 1] / SPACING**2)
    np.testing.assert_allclose(pair.errors.middle, 47.5, atol=0.5)
    nodes = pair.errors.offset  # the walls were laid on nodes, off the best fit
    np.testing.assert_allclose(nodes[1:], (pair.mated.place - pair.motion.place)[:2] / SPACING,
                               atol=1e-3)  # fmt: skip
    left = registered(*scans, shift="scanned")
    assert not left.errors.covariance.any()
    assert not left.errors.offset.any()


def as_scanned(upper, lower, **stated):
    return registered(
        scan_of(upper), scan_of(lower), orientation="towards", shift="scanned", **stated
    )


def rows_aside(wall):
    for row in (20, 45, 70):
        wall[row] = np.roll(wall[row], 1)


def every_second_row_aside(wall):
    wall[1::2] = np.roll(wall[1::2], -1, axis=1)


def a_raised_rim(wall):
    inner = wall[2:-2, 2:-2].copy()
    wall += 4.0 * SPACING * rms_slope(wall, SPACING)
    wall[2:-2, 2:-2] = inner


def a_filled_hole(wall):
    hole = np.zeros(wall.shape, bool)
    hole[30:40, 50:60] = True
    wall[:] = fill_missing(np.where(hole, np.nan, wall), "linear", 1.0)


@pytest.mark.parametrize(
    "damage", [rows_aside, every_second_row_aside, a_raised_rim, a_filled_hole]
)
def test_defects_of_a_grid_are_undone_with_a_warning(damage, walls):
    true, damaged = walls[1], walls[1].copy()
    damage(damaged)
    scan = inspected(scan_of(damaged))
    assert len(scan.remarks) == 1
    y, x = (round(place / SPACING) for place in scan.origin)
    ny, nx = scan.heights.shape
    shares = []
    for shift in (-1, 0, 1):  # of every second row either half may be moved
        shifted = np.roll(true, shift, axis=1)[y : y + ny, x : x + nx]
        same = (scan.heights - shifted)[:, 2:-2]  # rows were rolled over the edge
        known = np.isfinite(same)
        assert known.mean() > 0.9
        shares.append((np.abs(same[known]) < 1e-12).mean())
    assert max(shares) > 0.985  # up to the rim of a filled hole


@pytest.mark.parametrize("height", [-1e-3, 2e-3])
def test_a_patch_near_an_edge_is_not_taken_for_a_raised_rim(height):
    wall = jc.wall_pair(8.0, (44, 52), SPACING, 1, mismatch_wavelength=2e-3, roll_off=None)[0]
    wall = np.array(wall)
    wall[2:9, 20:28] = height
    assert cut_rim(scan_of(wall)).heights.shape == wall.shape


def test_blocks_of_equal_heights_are_one_height_each(walls):
    scan = inspected(scan_of(np.kron(walls[1][1::2, 1::2], np.ones((2, 2)))[1:, :]))
    np.testing.assert_array_equal(scan.heights, walls[1][3::2, 1::2])
    assert scan.spacing == (2.0 * SPACING, 2.0 * SPACING)
    assert scan.origin == pytest.approx((1.5 * SPACING, 0.5 * SPACING))
    assert "blocks of 2 x 2" in scan.remarks[0]


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_lost_waves_are_drawn_with_the_power_of_wall_and_mate(share, walls):
    scanned = tuple(scipy.ndimage.gaussian_filter(wall, 1.0 + share) for wall in walls)
    lost = 7.55 * (1.0 + share)
    known = errors()._replace(waves=(lost, lost))
    for field in (0, 1):  # a wall, and the sum of both
        slopes = [
            rms_slope(sum(pair) if field else pair[0], SPACING)
            for pair in (scanned, *(known.with_lost_waves(*scanned, n) for n in range(1, 9)), walls)
        ]
        assert slopes[0] < 0.8 * slopes[-1]
        assert 0.7 * slopes[-1] < np.median(slopes[1:-1]) < 1.4 * slopes[-1]


@pytest.fixture(scope="module")
def smooth(walls):
    """A joint of scans that resolve no short waves: by itself, and at the usual spacing."""
    scans = [scipy.ndimage.uniform_filter(wall, 3) for wall in walls]
    return as_scanned(*scans), as_scanned(*scans, spacing=SPACING)


def test_a_joint_has_a_spacing_that_its_scans_resolve(smooth):
    pair, stated = smooth
    assert pair.waves[0] == pytest.approx(6.4 * SPACING, rel=0.25)
    assert pair.spacing >= 0.5 * max(pair.waves) > stated.spacing == SPACING
    assert "which the scans resolve" in " ".join(pair.warnings)


def test_the_range_of_a_smooth_joint_has_the_usual_spacing(smooth):
    pair, stated = smooth
    np.testing.assert_allclose(pair.fine.upper, stated.upper)
    conditions = Conditions(pair.spacing, "granite", 10e6, 1).checked()
    sources = sources_of(conditions, pair.upper.shape, {}, pair.errors)
    assert {"spacing", "resolution"} <= set(sources)
    (usual,) = sources["spacing"].values[1:]
    changed = Variant("", "", conditions).changed("spacing", usual)
    assert changed.conditions.spacing == pytest.approx(SPACING)
    fine = changed.walls(*pair.finest[:2], pair.errors)
    np.testing.assert_array_equal(fine[0], stated.upper)


def test_the_range_of_a_smooth_joint_has_rougher_walls(smooth):
    pair, _ = smooth
    conditions = Conditions(pair.spacing, "granite", 10e6, 1).checked()
    changed = Variant("", "", conditions).changed("resolution", 1)
    drawn = changed.walls(*pair.finest[:2], pair.errors)
    assert drawn[0].shape == pair.upper.shape
    assert rms_slope(sum(drawn), 1.0) > 1.2 * rms_slope(pair.upper + pair.lower, 1.0)


@pytest.fixture(scope="module")
def sharp(walls):
    return as_scanned(*walls)


def test_sharp_scans_have_the_usual_spacing(sharp):
    assert (sharp.spacing, sharp.fine) == (SPACING, None)
    assert not sharp.warnings
    assert (sharp.errors.step, sharp.errors.scale) == (1, 1.0)


def test_sharp_scans_have_no_lost_waves(sharp):
    assert sharp.waves == sharp.errors.waves == (0.0, 0.0)


@pytest.fixture(scope="module", params=[1.0, 1.1])
def scaled(request, walls):
    """A factor of the heights of the upper wall, and the joint."""
    return request.param, as_scanned(request.param * walls[0], walls[1])


def test_heights_of_one_wall_in_another_scale_are_warned_of(scaled):
    scale, pair = scaled
    assert ("calibrate both scans" in " ".join(pair.warnings)) == (scale != 1.0)


def test_heights_of_one_wall_in_another_scale_are_in_the_range(scaled):
    scale, pair = scaled
    assert pair.errors.scale == pytest.approx(scale, rel=0.02)
    one, other = pair.errors.with_one_scale(pair.upper, pair.lower, 1)
    assert scale_of(one, other)[0] == pytest.approx(1.0, rel=0.02)


def test_walls_that_do_not_mate_have_no_scale():
    upper, lower = jc.wall_pair(8.0, SHAPE, SPACING, 1, correlation=0.0)
    assert not scales_differ(*scale_of(1.5 * upper, lower))


def test_rounding_that_changes_the_sum_of_the_walls_is_in_the_noise_of_the_range(walls):
    step = 1e-4
    pair = as_scanned(*(np.round(wall / step) * step for wall in walls))
    assert min(pair.errors.noise) >= 0.99 * step * np.sqrt(2.0 / 12.0)
