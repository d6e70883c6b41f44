"""Points on a regular grid are that grid, whatever their order, gaps and repeats."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.inputs.remarks import cautions
from jointclosure.walls.measured import Cloud
from jointclosure.walls.scans import read_scan
from tests.joints import SPACING
from tests.walls.test_formats import STEP_MM
from tests.walls.writers import Ground, triangles

SHAPE = (20, 26)


@pytest.fixture(scope="module")
def wall():
    """Heights (y, x) [mm]."""
    return 1e3 * jc.wall_pair(9.0, SHAPE, SPACING, seed=5)[0]


@pytest.fixture
def points(wall):
    return Ground(wall).points()


def read_points(path, points, digits=6):
    np.savetxt(path, points, fmt=f"%.{digits}f")
    return read_scan(path, units="mm")


@pytest.mark.parametrize("lost", [[0], [137], [3, 77, 78, 79, 300], range(130, 156)])
def test_a_grid_with_missing_points_is_that_grid_and_a_lost_profile_is_warned_of(
    lost, wall, points, tmp_path
):
    scan = read_points(tmp_path / "a.xyz", np.delete(points, lost, axis=0))
    expected = 1e-3 * wall
    expected.flat[list(lost)] = np.nan
    assert scan.spacing == (SPACING, SPACING)
    np.testing.assert_allclose(scan.heights, expected, atol=1e-9)
    assert f"{len(lost)} of 520 nodes of the points' grid have no point" in scan.remarks[0]
    warned = " ".join(cautions(scan.remarks))
    assert ("26 of them inside the wall (5 %): is the file inc" in warned) == (len(lost) == 26)


def test_scattered_and_staggered_points_are_no_grid(points, tmp_path):
    random = np.random.default_rng(1)
    scattered, staggered = points.copy(), points.copy()
    scattered[:, :2] += STEP_MM * random.random((len(points), 2))
    staggered[:, 0] += 0.5 * STEP_MM * (np.round(points[:, 1] / STEP_MM) % 2)
    rounded = np.column_stack([np.round(6.0 * random.random((500, 2)), 2), random.random(500)])
    for cloud in (scattered, staggered, rounded):
        scan = read_points(tmp_path / "a.xyz", cloud)
        assert isinstance(scan, Cloud)
        assert "no regular grid" in " ".join(cautions(scan.remarks))


def off_its_node(points, step):
    points[137, 0] += 0.075 * step


def a_lost_field(points, step):
    points[137] = [*points[137, 1:], np.nan]  # y and height, as read in the places of x and y


def a_point_between(points, step):
    points[137, :2] += 0.5 * step


def a_shifted_profile(points, step):
    points[3 * 26 : 4 * 26, 0] += 0.25 * step + 1e-6


def rounded_places(points, step):
    points[:, :2] = np.round(points[:, :2] / (0.4 * step)) * 0.4 * step


def jitter(points, step):
    points[:, :2] += 0.02 * step * np.random.default_rng(4).standard_normal((len(points), 2))


DAMAGES = {
    off_its_node: (1, "1 of 520 points lie off the nodes"),
    a_lost_field: (1, "1 of 520 nodes of the points' grid have no point"),
    a_point_between: (1, "1 of 520 points lie off the nodes"),
    a_shifted_profile: (26, "26 of 520 points lie off the nodes"),
    rounded_places: (0, "points were moved to the nodes of their grid, by an rms "),
    jitter: (0, "points were moved to the nodes of their grid, by an rms 2.9 % of its step"),
}


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_a_lattice_is_decided_by_most_points_and_those_off_it_are_left_out(
    damage, wall, points, tmp_path
):
    step = 0.4
    points = points * [step / STEP_MM, step / STEP_MM, 1.0] + [7.5, -30.0, 0.0]
    damage(points, step)
    scan = read_points(tmp_path / "a.xyz", points)
    lost, remark = DAMAGES[damage]
    assert scan.spacing == pytest.approx((1e-3 * step,) * 2, rel=5e-3)
    assert scan.origin == pytest.approx((-30e-3, 7.5e-3), abs=0.15e-3 * step)
    assert remark in " ".join(scan.remarks)
    known = np.isfinite(scan.heights)
    assert scan.heights.shape == SHAPE
    assert known.sum() == known.size - lost
    np.testing.assert_allclose(scan.heights[known], 1e-3 * wall[known], atol=1e-9)


@pytest.mark.parametrize("gridded", [True, False])
def test_several_heights_at_one_place_are_refused_where_they_are_many(gridded, points, tmp_path):
    if not gridded:
        points[:, :2] += 0.25 * np.random.default_rng(2).random((len(points), 2))
    other = points + np.array([0.0, 0.0, 0.4])
    few = read_points(tmp_path / "few.xyz", np.vstack([points, other[100:103]]))
    assert few.remarks[0] == "3 places with several heights were treated as missing"
    known = np.isfinite(few.heights).sum() if gridded else len(few.points)
    assert known == len(points) - 3
    with pytest.raises(jc.InputError, match=r"many\.xyz: 520 of 520 places have several heights"):
        read_points(tmp_path / "many.xyz", np.vstack([points, other]))


def test_a_closed_block_below_a_wall_is_no_wall(points, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    far = points[:, :2].max(axis=0)
    block = trimesh.creation.box(bounds=[[0.0, 0.0, -2.0], [*far, -1.0]])
    sheet = trimesh.Trimesh(points, triangles(SHAPE), process=False)
    solid = trimesh.util.concatenate([sheet, block])
    (tmp_path / "a.stl").write_bytes(solid.export(file_type="stl"))
    with pytest.raises(jc.InputError, match=r"a\.stl: the surface overlaps itself: .* covers? 3 "):
        read_scan(tmp_path / "a.stl", units="mm")


def test_places_that_are_written_rounded_are_those_of_a_grid(points, tmp_path):
    points = points * np.array([4.0 / 3.0, 4.0 / 3.0, 1.0])  # 0.333... mm apart
    scan = read_points(tmp_path / "a.xyz", points, digits=2)
    assert scan.spacing == pytest.approx((1e-3 / 3.0, 1e-3 / 3.0), rel=1e-4)
    assert scan.heights.shape == SHAPE
