"""From a scan to the walls of a joint."""

import re

import numpy as np
import pytest
import scipy
from threadpoolctl import threadpool_info, threadpool_limits

import jointclosure as jc
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.measured import (
    Cloud,
    Scan,
    filled,
    heights_between,
    point_distance,
    wall_on_grid,
)
from jointclosure.walls.plausibility import smoothing_of
from jointclosure.walls.registration import registered
from jointclosure.walls.roughness import detrended, rms_slope
from jointclosure.walls.synthesis import synthetic_wall
from studies.frame.ensemble.walls import Cutter, MeasuredWalls, windows
from tests.joints import SPACING


@pytest.fixture
def wall():
    return jc.wall_pair(9.0, (40, 52), SPACING, seed=5)[0]


def tilted(wall, degrees, spacing=SPACING):
    y, x = np.indices(wall.shape) * spacing
    return wall + np.tan(np.radians(degrees)) * (0.6 * x - 0.8 * y) + 5e-3


def scan(wall, spacing=SPACING):
    return Scan(wall, (spacing, spacing))


def test_a_plane_that_was_added_is_removed(wall):
    found = wall_on_grid(scan(tilted(wall, 12.0)), SPACING)
    np.testing.assert_allclose(found, wall, atol=1e-15)


def test_a_plane_is_found_beside_missing_cells(wall):
    holed = tilted(wall, 12.0)
    holed[:15, :20] = np.nan
    found = wall_on_grid(scan(holed), SPACING)
    assert np.isnan(found).sum() == 300
    known = np.isfinite(found)
    y, x = np.indices(wall.shape)
    left = np.stack([np.ones(known.sum()), x[known], y[known]])
    assert np.abs(left @ found[known]).max() < 1e-12
    assert rms_slope(found[15:], SPACING) == pytest.approx(rms_slope(wall[15:], SPACING), rel=0.02)


def test_a_scan_that_stands_on_edge_is_refused(wall):
    with pytest.raises(jc.InputError, match=r"inclined by 25\.0 degrees: at most 20"):
        wall_on_grid(scan(tilted(wall, 25.0)), SPACING)


def test_a_spacing_that_is_a_multiple_leaves_cells_out(wall):
    found = wall_on_grid(scan(wall), 3 * SPACING)
    np.testing.assert_array_equal(found, wall_on_grid(scan(wall), SPACING)[::3, ::3])


def test_a_smooth_wall_survives_another_spacing():
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
    found = heights_between(places, heights, nodes, 1e-3)
    whole = scipy.interpolate.LinearNDInterpolator(places, heights)(nodes)
    difference = np.abs(found - whole)
    assert np.mean(difference < 1e-12) > 0.9
    assert difference.max() < 2e-7  # other triangles of points as near


def test_a_grid_at_its_places_is_not_triangulated(monkeypatch):
    """Four triangulations of 500 x 500 points took 21 of 22 s of bringing scans together."""
    wall = jc.wall_pair(8.0, (12, 15), SPACING, seed=1)[0]
    places = np.stack(np.meshgrid(np.arange(15), np.arange(12)), axis=-1) * SPACING
    monkeypatch.setattr(scipy.spatial, "Delaunay", None)
    found = heights_between(places.reshape(-1, 2), wall.ravel(), places + 1e-12, SPACING)
    np.testing.assert_array_equal(found, wall)


def test_triangles_are_not_shared_among_threads(monkeypatch):
    """Scipy solves two equations for each; where processors are busy each took milliseconds."""
    whole, threads = scipy.spatial.Delaunay, []

    class Counted(whole):
        def find_simplex(self, *arguments, **options):
            threads.extend(library["num_threads"] for library in threadpool_info())
            return super().find_simplex(*arguments, **options)

    monkeypatch.setattr(scipy.spatial, "Delaunay", Counted)
    with threadpool_limits(limits=2, user_api="blas"):
        heights_between(np.eye(3, 2), np.zeros(3), np.full((1, 2), 0.3), 1.0)
        assert {library["num_threads"] for library in threadpool_info()} == {2}
    assert threads
    assert set(threads) == {1}


def test_resampling_gives_no_height_where_a_neighbour_has_none(wall):
    wall[20, 30] = np.nan
    found = wall_on_grid(scan(wall), 1.5 * SPACING)
    rows, columns = np.nonzero(np.isnan(found))
    touched = np.abs(1.5 * rows - 20) < 1.0
    assert touched.all()
    assert (np.abs(1.5 * columns - 30) < 1.0).all()
    assert len(rows) > 0


def test_scattered_points_of_a_smooth_wall_give_its_heights():
    rng = np.random.default_rng(4)
    x, y = rng.random((2, 20000)) * 10e-3
    smooth = lambda x, y: 1e-4 * np.sin(600.0 * x) * np.cos(500.0 * y)  # noqa: E731
    cloud = Cloud(np.stack([x, y, smooth(x, y)], axis=1))
    assert point_distance(cloud) == pytest.approx(10e-3 / np.sqrt(20000), rel=0.01)
    found = wall_on_grid(cloud, SPACING)
    rows, columns = np.indices(found.shape)
    exact = smooth(x.min() + columns * SPACING, y.min() + rows * SPACING)
    known = np.isfinite(found)
    assert known.mean() > 0.93
    offset = np.linalg.lstsq(
        np.stack([np.ones(known.sum()), rows[known], columns[known]], axis=1),
        (found - exact)[known],
        rcond=None,
    )
    assert np.sqrt(offset[1][0] / known.sum()) < 1e-6


def test_a_hole_in_scattered_points_is_not_bridged():
    rng = np.random.default_rng(4)
    points = rng.random((20000, 3)) * [10e-3, 10e-3, 1e-5]
    centre = np.hypot(points[:, 0] - 5e-3, points[:, 1] - 5e-3)
    found = wall_on_grid(Cloud(points[centre > 2e-3]), SPACING)
    rows, columns = np.indices(found.shape)
    deep = np.hypot(rows * SPACING - 5e-3, columns * SPACING - 5e-3) < 1.7e-3
    assert np.isnan(found[deep]).all()


def test_missing_cells_are_refused_with_their_number_and_place(wall):
    wall[4, 7] = wall[4, 8] = np.nan
    printed = r"2 of 2080 cells have no height, the first at \(y, x\) = \(4, 7\)"
    with pytest.raises(jc.InputError, match=printed):
        filled(wall, "refuse")
    assert filled(wall, "avoid") is wall


def test_linear_filling_follows_a_slope_and_nearest_does_not():
    y, x = np.indices((30, 30))
    slope = 2e-5 * x + 1e-5 * y
    holed = slope.copy()
    holed[10:14, 20:23] = np.nan
    np.testing.assert_allclose(filled(holed, "linear"), slope, atol=1e-15)
    near = filled(holed, "nearest")
    assert np.isfinite(near).all()
    assert np.abs(near - slope).max() > 1e-5
    # beyond all cells there is nothing to go on but the nearest
    holed[:2] = np.nan
    assert np.isfinite(filled(holed, "linear", 0.1)).all()


def test_no_more_is_filled_than_was_allowed(wall):
    wall[:4] = np.nan
    with pytest.raises(jc.InputError, match=r"208 of 2080 .* 0.100, at most 0.05 may be filled"):
        filled(wall, "nearest")
    assert np.isfinite(filled(wall, "nearest", 0.1)).all()


def test_windows_are_all_places_without_a_missing_cell(wall):
    wall[12, 9] = wall[30, 40] = np.nan
    found = {tuple(offset) for offset in windows(wall, (11, 13)).tolist()}
    naive = {
        (y, x)
        for y in range(40 - 10)
        for x in range(52 - 12)
        if np.isfinite(wall[y : y + 11, x : x + 13]).all()
    }
    assert found == naive


def test_no_room_says_what_there_is_room_for(wall):
    wall[:, 30] = np.nan
    printed = r"no room for 32 x 32 cells \(y, x\): the wall has 40 x 52 .* full square is 30 x 30"
    with pytest.raises(jc.InputError, match=printed):
        windows(wall, (32, 32))


def cutter(measured, partner, shape=(16, 20), order=1):
    return Cutter(MeasuredWalls(measured, partner, SPACING, 0.2, 0.8), shape, order)


@pytest.mark.parametrize(
    ("partner", "turned"), [("rotated", np.s_[::-1, ::-1]), ("mirrored", np.s_[:, ::-1])]
)
def test_a_single_wall_meets_itself_turned(wall, partner, turned):
    joint = cutter({"lower": wall}, partner).joint(2, seed=1)
    for side in ("upper", "lower"):
        y, x = getattr(joint, f"{side}_origin")
        cut = detrended(wall[y : y + 16, x : x + 20])
        expected = cut[turned] if side == "upper" else cut
        np.testing.assert_array_equal(getattr(joint, side), expected)
    assert joint.upper_origin != joint.lower_origin


def test_two_scans_are_cut_at_the_same_place(wall):
    other = wall[::-1].copy()
    other[0, 0] = np.nan
    whole = cutter({"upper": wall, "lower": other}, "")
    assert [0, 0] not in whole.windows.tolist()
    joint = whole.joint(3, seed=1)
    assert joint.upper_origin == joint.lower_origin
    y, x = joint.upper_origin
    np.testing.assert_array_equal(joint.upper, detrended(wall[y : y + 16, x : x + 20]))
    np.testing.assert_array_equal(joint.lower, detrended(other[y : y + 16, x : x + 20]))


def test_a_synthetic_partner_is_another_for_each_seed(wall):
    whole = cutter({"upper": wall}, "synthetic")
    one, same, other = (whole.joint(0, seed).lower for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.0
    assert rms_slope(one, SPACING) == pytest.approx(0.2, rel=1e-12)
    assert whole.joint(0, 1).lower_origin == (-1, -1)
    # a renamed stream would draw other walls for the same study
    drawn = synthetic_wall(0.2, (16, 20), SPACING, 0.8, generator(seed_of(1, "matching")))
    np.testing.assert_array_equal(one, drawn)


def test_realisations_have_different_windows_whatever_their_number(wall):
    whole = cutter({"lower": wall}, "rotated")
    count = len(whole.windows)
    origins = [whole.joint(number, 0).lower_origin for number in range(count)]
    assert len(set(origins)) == count == 25 * 33
    assert origins == [
        cutter({"lower": wall}, "rotated").joint(n, 0).lower_origin for n in range(count)
    ]
    assert origins[:9] != [
        cutter({"lower": wall}, "rotated", order=2).joint(n, 0).lower_origin for n in range(9)
    ]


def test_more_realisations_than_windows_are_refused_unless_walls_are_drawn(wall):
    whole = cutter({"lower": wall}, "mirrored", (39, 52))
    whole.check(2)
    with pytest.raises(jc.InputError, match=r"study.realizations = 3: must be at most 2"):
        whole.check(3)
    cutter({"lower": wall}, "synthetic", (39, 52)).check(3)


@pytest.mark.parametrize(
    ("shift", "interpolated"), [((0.0, 0.0), False), ((0.5, 0.5), True), ((0.0, 0.3), True)]
)
def test_interpolation_is_warned_of_with_the_slope_that_is_lost(shift, interpolated):
    upper, lower = jc.wall_pair(9.0, (64, 64), SPACING, seed=2, roll_off=None, correlation=0.9)
    origin = 7 * SPACING + shift[0] * SPACING, shift[1] * SPACING
    scans = (
        Scan(-upper[7:], (SPACING, SPACING), origin),
        Scan(lower, (SPACING, SPACING), (0.0, 0.0)),
    )
    pair = registered(*scans, orientation="common_frame", shift="scanned", cut_spikes=False)
    lost = [line for line in pair.warnings if "heights were interpolated" in line]
    assert len(lost) == interpolated
    for line in lost:
        side = "upper" if "upper" in line else "lower"
        kept, measured = map(
            float, re.search(r"is ([\d.]+), between points ([\d.]+)", line).groups()
        )
        whole = {"upper": upper[7:], "lower": lower}[side]
        assert kept == pytest.approx(rms_slope(getattr(pair, side), SPACING), rel=0.01)
        assert measured == pytest.approx(rms_slope(detrended(whole), SPACING), rel=0.02)
        assert kept < 0.95 * measured


def test_scattered_points_and_other_spacings_of_one_wall_are_warned_of():
    wall = jc.wall_pair(9.0, (60, 60), SPACING, seed=2, roll_off=None)[0]
    y, x = np.indices(wall.shape) * SPACING
    points = np.stack([x.ravel(), y.ravel(), wall.ravel()], axis=1)
    some = np.random.default_rng(1).permutation(len(points))[: len(points) // 2]
    for scan, step, warned in (
        (Scan(wall, (SPACING, SPACING)), SPACING, False),
        (Scan(wall, (SPACING, SPACING)), 2.0 * SPACING, False),
        (Scan(wall, (SPACING, SPACING)), 1.3 * SPACING, True),
        (Cloud(points[some]), 1.7 * SPACING, True),
    ):
        assert bool(smoothing_of(scan, wall_on_grid(scan, step), step)) == warned


@pytest.mark.parametrize(("step", "warned"), [(SPACING / 2.0, 0), (SPACING / 2.3, 2)])
def test_sampling_between_the_points_of_fine_scans_is_warned_of(step, warned):
    upper, lower = jc.wall_pair(9.0, (90, 90), step, seed=2, roll_off=None, correlation=0.9)
    scans = Scan(-upper, (step, step)), Scan(lower, (step, step))
    pair = registered(*scans, SPACING, orientation="common_frame", cut_spikes=False)
    assert sum("heights were interpolated" in line for line in pair.warnings) == warned


def test_the_overlap_is_reported_as_a_share_of_both_scans():
    upper, lower = jc.wall_pair(9.0, (60, 60), SPACING, seed=2, roll_off=None, correlation=0.9)
    scans = Scan(-upper, (SPACING, SPACING)), Scan(lower[:42], (SPACING, SPACING))
    pair = registered(*scans, orientation="common_frame", cut_spikes=False)
    assert pair.overlap == 1.0
    assert "72 % of the upper scan and 100 % of the lower" in " ".join(pair.report)
