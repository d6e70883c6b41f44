"""The walls of a joint, on a grid, from the points or the grid of a scan."""

import re

import numpy as np
import pytest
import scipy

import jointclosure as jc
from jointclosure.walls.gridding import (
    Cloud,
    Scan,
    grid_nodes,
    node_counts,
    point_distance,
    points_of,
    usual_grid_spacing,
    wall_on_grid,
)
from jointclosure.walls.jrc import rms_slope
from jointclosure.walls.levelling import levelled, levelled_together
from jointclosure.walls.planes import detrended
from jointclosure.walls.point_interpolation import interpolate_heights
from jointclosure.walls.registration import registered
from tests.joints import SPACING


@pytest.fixture
def wall():
    return jc.wall_pair(9.0, (40, 52), SPACING, seed=5)[0]


def tilted(wall, degrees):
    y, x = np.indices(wall.shape) * SPACING
    return wall + np.tan(np.radians(degrees)) * (0.6 * x - 0.8 * y) + 5e-3


def scan(wall, spacing=SPACING, origin=None):
    return Scan(wall, (spacing, spacing), origin)


def test_a_plane_that_was_added_is_removed_also_beside_missing_cells(wall):
    np.testing.assert_allclose(wall_on_grid(scan(tilted(wall, 12.0)), SPACING), wall, atol=1e-15)
    with pytest.raises(jc.InputError, match=r"inclined by 25\.0 degrees: at most 20"):
        wall_on_grid(scan(tilted(wall, 25.0)), SPACING)
    holed = tilted(wall, 12.0)
    holed[:15, :20] = np.nan
    found = wall_on_grid(scan(holed), SPACING)
    assert np.isnan(found).sum() == 300
    known = np.isfinite(found)
    y, x = np.indices(wall.shape)
    left = np.stack([np.ones(known.sum()), x[known], y[known]])
    assert np.abs(left @ found[known]).max() < 1e-12
    assert rms_slope(found[15:], SPACING) == pytest.approx(rms_slope(wall[15:], SPACING), rel=0.02)


def inclined(wall, degrees, azimuth=0.0):
    """Points (n, 3) of a wall that was turned about a horizontal axis."""
    y, x = np.indices(wall.shape) * SPACING
    points = np.stack([part.ravel() for part in (x, y, wall)], axis=1)
    about = scipy.spatial.transform.Rotation.from_euler("zyz", [-azimuth, degrees, azimuth], True)
    return about.apply(points)


@pytest.mark.parametrize("degrees", [3.0, 19.0, 44.0])
@pytest.mark.parametrize("azimuth", [0.0, 30.0])
def test_inclined_points_of_a_regular_wall_become_its_grid(degrees, azimuth, wall):
    level, motion = levelled(Cloud(inclined(wall, degrees, azimuth)))
    assert isinstance(level, Scan)
    assert level.spacing == pytest.approx((SPACING, SPACING), rel=1e-4)
    assert motion.tilt == pytest.approx(degrees, abs=0.05)
    np.testing.assert_allclose(detrended(level.heights), detrended(wall), atol=1e-7)
    assert level.remarks[0].startswith(f"the mean plane is inclined by {degrees:.1f} degrees")


@pytest.mark.parametrize("degrees", [2.5, 15.0, 25.0, 36.87, 44.0])
def test_inclined_points_of_rounded_places_are_levelled(degrees, wall):
    given = np.round(inclined(wall, degrees), 4)  # to 0.1 mm, of 0.25 mm
    level, _ = levelled(Cloud(given))
    points = points_of(level)
    assert len(points) > 0.9 * len(given)
    slope = np.polyfit(points[:, 0], points[:, 2], 1)[0]
    assert abs(slope) < 0.01


@pytest.mark.parametrize("degrees", [10.0, 19.0, 40.0])
def test_an_inclined_grid_has_the_slopes_of_the_level_wall(degrees):
    y, x = np.indices((60, 70)) * SPACING
    smooth = 2e-4 * np.sin(900.0 * x + 0.3) * np.cos(700.0 * y)
    points = inclined(smooth, degrees)
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    nodes = grid_nodes(low, node_counts(low, high, SPACING), SPACING)
    interpolated = scipy.interpolate.CloughTocher2DInterpolator(points[:, :2], points[:, 2])(nodes)
    given = scan(interpolated, origin=(float(low[1]), float(low[0])))
    level, _ = levelled(given)
    truth = np.std(np.diff(smooth, axis=1))
    assert np.nanstd(np.diff(level.heights, axis=1)) == pytest.approx(truth, rel=0.02)
    assert min(level.heights.shape) >= 56
    if degrees == 19.0:  # as a check of the test
        sheared = wall_on_grid(given, SPACING)
        assert np.nanstd(np.diff(sheared, axis=1)) > 1.08 * truth


def test_a_level_scan_is_left_as_it_is(wall):
    for given in (scan(tilted(wall, 4.0)), Cloud(inclined(wall, 1.5))):
        assert levelled(given) == (given, None)


def test_a_steep_scan_is_refused(wall):
    with pytest.raises(jc.InputError, match=r"inclined by 50\.0 degrees: at most 45"):
        levelled(scan(tilted(wall, 50.0)))


def test_walls_that_lie_on_each_other_are_levelled_to_the_same_cells(wall):
    lower = scan(tilted(wall, 15.0))
    upper = scan(1e-4 * np.cos(900.0 * np.indices(wall.shape)[1] * SPACING) - tilted(wall, 15.0))
    both = levelled_together({"upper": upper, "lower": lower})
    assert both["upper"].heights.shape == both["lower"].heights.shape
    sums = detrended(both["upper"].heights + both["lower"].heights)
    assert np.std(sums) == pytest.approx(np.std(detrended(upper.heights + lower.heights)), rel=0.1)
    level = {"upper": scan(wall), "lower": scan(-wall)}
    assert levelled_together(level) == level


def test_another_spacing_leaves_cells_out_or_keeps_a_smooth_wall(wall):
    found = wall_on_grid(scan(wall), 3 * SPACING)
    np.testing.assert_array_equal(found, wall_on_grid(scan(wall), SPACING)[::3, ::3])

    def smooth(y, x):
        return 1e-4 * np.sin(900.0 * x) * np.cos(700.0 * y)

    fine, coarse = (np.indices(n) * h for n, h in (((80, 90), SPACING), ((57, 64), 1.4 * SPACING)))
    found = wall_on_grid(scan(smooth(*fine)), 1.4 * SPACING)
    assert found.shape == (57, 64)
    # but for the plane, which is that of the finer grid
    np.testing.assert_allclose(detrended(found), detrended(smooth(*coarse)), atol=2e-8)


def test_heights_between_dense_points_are_those_of_all_triangles():
    places = np.random.default_rng(1).uniform(0.0, 0.01, (20_000, 2))
    heights = 1e-4 * np.sin(900.0 * places[:, 0]) * np.cos(700.0 * places[:, 1])
    axis = np.linspace(1e-3, 9e-3, 30)
    nodes = np.stack(np.meshgrid(axis, axis), axis=-1)
    found = interpolate_heights(places, heights, nodes, 1e-3)
    whole = scipy.interpolate.LinearNDInterpolator(places, heights)(nodes)
    difference = np.abs(found - whole)
    assert np.mean(difference < 1e-12) > 0.9
    assert difference.max() < 2e-7  # other triangles of points as near


def test_resampling_gives_no_height_where_a_neighbour_has_none(wall):
    wall[20, 30] = np.nan
    rows, columns = np.nonzero(np.isnan(wall_on_grid(scan(wall), 1.5 * SPACING)))
    assert (np.abs(1.5 * rows - 20) < 1.0).all()
    assert (np.abs(1.5 * columns - 30) < 1.0).all()
    assert len(rows) > 0


def test_scattered_points_of_a_smooth_wall_give_its_heights_but_not_in_holes():
    points = np.random.default_rng(4).random((20000, 3)) * 10e-3
    x, y = points[:, :2].T
    points[:, 2] = 1e-4 * np.sin(600.0 * x) * np.cos(500.0 * y)
    cloud = Cloud(points)
    assert point_distance(cloud) == pytest.approx(10e-3 / np.sqrt(20000), rel=0.01)
    found = wall_on_grid(cloud, SPACING)
    rows, columns = np.indices(found.shape)
    at_x, at_y = x.min() + columns * SPACING, y.min() + rows * SPACING
    exact = 1e-4 * np.sin(600.0 * at_x) * np.cos(500.0 * at_y)
    known = np.isfinite(found)
    assert known.mean() > 0.93
    plane = np.stack([np.ones(known.sum()), rows[known], columns[known]], axis=1)
    left = np.linalg.lstsq(plane, (found - exact)[known], rcond=None)[1]
    assert np.sqrt(left[0] / known.sum()) < 1e-6
    holed = Cloud(points[np.hypot(x - 5e-3, y - 5e-3) > 2e-3])
    found = wall_on_grid(holed, SPACING)
    assert np.isnan(found[np.hypot(at_y - 5e-3, at_x - 5e-3) < 1.7e-3]).all()


@pytest.mark.parametrize(
    ("shift", "interpolated"), [((0.0, 0.0), False), ((0.5, 0.5), True), ((0.0, 0.3), True)]
)
def test_interpolation_is_warned_of_with_the_slope_that_is_lost(shift, interpolated):
    upper, lower = jc.wall_pair(9.0, (64, 64), SPACING, seed=2, roll_off=None, correlation=0.9)
    origin = 7 * SPACING + shift[0] * SPACING, shift[1] * SPACING
    scans = scan(-upper[7:], origin=origin), scan(lower, origin=(0.0, 0.0))
    pair = registered(*scans, orientation="common_frame", shift="scanned", spikes="keep")
    lost = [line for line in pair.warnings if "the grid smoothed the wall" in line]
    assert len(lost) == interpolated
    for line in lost:
        slopes = re.search(r"is ([\d.]+) instead of ([\d.]+)", line).groups()
        kept, measured = map(float, slopes)
        assert kept < 0.985 * measured


@pytest.fixture(scope="module")
def cloud():
    """400 points at random places."""
    return Cloud(np.random.default_rng(6).random((400, 3)) * [10e-3, 10e-3, 1e-4])


def test_grids_are_no_finer_than_their_points(cloud):
    regular = scan(1e-4 * cloud.points[:, 2].reshape(20, 20))
    for of, least in ((cloud, 0.8 * point_distance(cloud)), (regular, 0.99 * SPACING)):
        assert np.isfinite(wall_on_grid(of, 1.01 * least)).any()
        with pytest.raises(jc.InputError, match="finer than the scan"):
            wall_on_grid(of, 0.98 * least)


def test_grids_are_not_far_larger_than_their_points(cloud):
    """100 cells for each of 400 points."""
    distance = point_distance(cloud)
    boxes = [np.array([[0.0, 0.0], [side * 100 * distance] * 2]) for side in (1.9, 2.1)]
    assert wall_on_grid(cloud, distance, boxes[0]).size < 100 * 400
    with pytest.raises(jc.InputError, match="at most 100 cells for each point"):
        wall_on_grid(cloud, distance, boxes[1])


def test_three_heights_are_too_few_for_a_wall():
    with pytest.raises(jc.InputError, match="3 heights: too few for a wall"):
        wall_on_grid(scan(np.array([[0.0, 1e-5, 2e-5], [np.nan] * 3, [np.nan] * 3])), SPACING)


@pytest.mark.parametrize(
    ("distance", "spacing"), [(0.25e-3, 0.25e-3), (0.1e-3, 0.2e-3), (0.6e-3, 0.6e-3), (5e-3, 5e-3)]
)
def test_the_usual_grid_is_a_multiple_of_the_points_distance_next_to_the_papers(distance, spacing):
    assert usual_grid_spacing(distance) == pytest.approx(spacing)
