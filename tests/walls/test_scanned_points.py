"""Points of a scan: the regular grid on which they lie, gaps, repetitions, and what is refused."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.inputs.remarks import cautions
from jointclosure.walls import scan_quality
from jointclosure.walls.gridding import Cloud, points_of
from jointclosure.walls.scans import read_scan
from jointclosure.walls.scans.points import _find_axis
from jointclosure.walls.scans.sheet import check_sheet
from jointclosure.walls.wall_roughness import measure_wall
from tests.joints import SPACING
from tests.walls.test_formats import STEP_MM
from tests.walls.writers import Ground, triangles


def test_coordinates_of_fewer_than_three_lines_have_no_axis():
    assert _find_axis(np.repeat([0.0, 1.0], 20), 0.1) is None
    assert _find_axis(np.zeros(40), 0.1) is None
    assert _find_axis(np.repeat([0.0, 1.0, 2.0], 20), 0.1).step == pytest.approx(1.0)


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


LOST = pytest.mark.parametrize("lost", [[0], [137], [3, 77, 78, 79, 300], range(130, 156)])


@LOST
def test_a_grid_with_missing_points_is_that_grid(lost, wall, points, tmp_path):
    scan = read_points(tmp_path / "a.xyz", np.delete(points, lost, axis=0))
    expected = 1e-3 * wall
    expected.flat[list(lost)] = np.nan
    assert scan.spacing == (SPACING, SPACING)
    np.testing.assert_allclose(scan.heights, expected, atol=1e-9)


@LOST
def test_missing_points_are_reported(lost, points, tmp_path):
    """A profile that is lost is warned of."""
    scan = read_points(tmp_path / "a.xyz", np.delete(points, lost, axis=0))
    assert f"{len(lost)} of 520 heights" in scan.remarks[0]
    warned = " ".join(cautions(scan.remarks))
    assert ("26 of 520 heights (5 %) are missing inside the wall" in warned) == (len(lost) == 26)


def test_scattered_or_staggered_points_are_no_grid(points, tmp_path):
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
    a_lost_field: (1, "1 of 520 heights are missing"),
    a_point_between: (1, "1 of 520 points lie off the nodes"),
    a_shifted_profile: (26, "26 of 520 points lie off the nodes"),
    rounded_places: (0, "points were moved to the nodes of their grid, by an rms "),
    jitter: (0, "points were moved to the nodes of their grid, by an rms 2.9 % of its step"),
}


LATTICE_STEP = 0.4


@pytest.fixture(params=DAMAGES, ids=lambda damage: damage.__name__)
def damaged(request, points, tmp_path):
    """How a lattice of points was damaged, and its scan."""
    scale = LATTICE_STEP / STEP_MM
    points = points * [scale, scale, 1.0] + [7.5, -30.0, 0.0]
    request.param(points, LATTICE_STEP)
    return request.param, read_points(tmp_path / "a.xyz", points)


def test_a_lattice_is_decided_by_most_points(damaged):
    _, scan = damaged
    assert scan.spacing == pytest.approx((1e-3 * LATTICE_STEP,) * 2, rel=5e-3)
    assert scan.origin == pytest.approx((-30e-3, 7.5e-3), abs=0.15e-3 * LATTICE_STEP)
    assert scan.heights.shape == SHAPE


def test_points_off_a_lattice_are_left_out(damaged, wall):
    damage, scan = damaged
    lost, remark = DAMAGES[damage]
    assert remark in " ".join(scan.remarks)
    known = np.isfinite(scan.heights)
    assert known.sum() == known.size - lost
    np.testing.assert_allclose(scan.heights[known], 1e-3 * wall[known], atol=1e-9)


@pytest.mark.parametrize("rounding", [0.1, 0.15, 0.2, 0.23])
def test_places_that_are_rounded_coarsely_are_the_grid_that_was_scanned(rounding, tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (50, 60), SPACING, 1)[0]
    points = Ground(wall, 0.25, (357123.4567, 5512345.1234)).points()
    points[:, :2] = np.round(points[:, :2] / rounding) * rounding
    scan = read_points(tmp_path / "a.xyz", points)
    assert scan.spacing == pytest.approx((0.25e-3, 0.25e-3), rel=5e-3)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-9)
    assert any(words in " ".join(scan.remarks) for words in ("is a multiple of", "were moved to"))


@pytest.mark.parametrize("rounding", [1.0, 2.0])
def test_places_that_are_too_coarse_for_their_points_need_more_digits(rounding, tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (50, 60), SPACING, 1)[0]
    points = Ground(wall, 0.25, (357123.4567, 5512345.1234)).points()
    points[:, :2] = np.round(points[:, :2] / rounding) * rounding  # exact in single precision too
    printed = f"all x are multiples of {rounding:g}\\) need more digits"
    with pytest.raises(jc.InputError, match=printed):
        read_points(tmp_path / "a.xyz", points)


@pytest.mark.parametrize("kept", [1.0, 0.5])
def test_rounding_that_leaves_lines_of_the_grid_empty_is_refused(kept, tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (50, 60), SPACING, 1)[0]
    points = scattered(Ground(wall, 0.15, (357123.4567, 5512345.1234)).points(), 0.003)
    points[:, :2] = np.round(points[:, :2], 1)
    points = points[np.random.default_rng(1).random(len(points)) <= kept]
    with pytest.raises(jc.InputError, match=r"multiples of 0\.1 and 0\.1 .* export more digits"):
        read_points(tmp_path / "a.xyz", points)


@pytest.mark.parametrize("moved", [0.0125, 0.025])
def test_scattered_points_of_rounded_places_are_no_coarse_grid(moved, tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (50, 60), SPACING, 1)[0]
    points = scattered(Ground(wall, 0.25, (357123.4567, 5512345.1234)).points(), moved)
    points[:, :2] = np.round(points[:, :2] / 0.05) * 0.05
    scan = read_points(tmp_path / "a.xyz", points)
    assert len(points_of(scan)) > 0.97 * len(points)


def scattered(points, deviation):
    points[:, :2] += deviation * np.random.default_rng(1).standard_normal((len(points), 2))
    return points


def test_heights_without_neighbours_are_refused():
    wall = np.full((48, 48), np.nan)
    wall[::2, ::2] = np.random.default_rng(0).random((24, 24))
    with pytest.raises(jc.InputError, match="no three neighbouring cells along x have heights"):
        measure_wall(wall, SPACING)


@pytest.mark.parametrize("gridded", [True, False])
def test_several_heights_at_one_place_are_refused_where_they_are_many(gridded, points, tmp_path):
    if not gridded:
        points[:, :2] += 0.25 * np.random.default_rng(2).random((len(points), 2))
    other = points + np.array([0.0, 0.0, 0.4])
    few = read_points(tmp_path / "few.xyz", np.vstack([points, other[100:103]]))
    assert few.remarks[0] == "3 places with several heights were treated as missing"
    known = np.isfinite(few.heights).sum() if gridded else len(few.points)
    assert known == len(points) - 3
    with pytest.raises(
        jc.InputError,
        match=r"many\.xyz: the points lie on two sheets above each other, about 0.4 apart",
    ):
        read_points(tmp_path / "many.xyz", np.vstack([points, other]))
    with pytest.raises(jc.InputError, match=r"some\.xyz: 26 of 520 places have several heights"):
        read_points(tmp_path / "some.xyz", np.vstack([points, other[::20]]))


@pytest.mark.parametrize(
    ("sheets", "printed"),
    [(0, "must be cut to one wall$"), (1, "the surface overlaps itself: .* covers? 3 ")],
)
def test_a_solid_is_no_wall_nor_is_a_wall_above_one(sheets, printed, points, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    bounds = [[0.0, 0.0, -2.0], [*points[:, :2].max(axis=0), -1.0]]
    sheet = trimesh.Trimesh(points, triangles(SHAPE), process=False)
    meshes = [trimesh.creation.box(bounds=bounds), *[sheet] * sheets]
    (tmp_path / "a.stl").write_bytes(trimesh.util.concatenate(meshes).export(file_type="stl"))
    with pytest.raises(jc.InputError, match=rf"a\.stl: .*{printed}"):
        read_scan(tmp_path / "a.stl", units="mm")


@pytest.mark.parametrize(("units", "warned"), [("mm", False), ("inch", True), ("m", True)])
def test_units_in_which_heights_are_unusually_far_apart_are_warned_of(tmp_path, units, warned):
    """Of a wall of 10 x 8 mm in steps of 0.25 mm: steps of 6.35 mm in inch."""
    y, x = 0.25 * np.indices((33, 41))
    heights = np.random.default_rng(1).normal(0.0, 0.05, x.shape)
    np.savetxt(tmp_path / "wall.xyz", np.column_stack([x.ravel(), y.ravel(), heights.ravel()]))
    scan = jc.read_scan(tmp_path / "wall.xyz", units=units)
    doubts = [line for line in cautions(scan.remarks) if "apart in" in line or "unusual in" in line]
    assert bool(doubts) == warned
    if units == "inch":
        assert doubts[0].startswith("Warning: heights are 6.")
        assert "as they would be in mm; check units" in doubts[0]


@pytest.mark.parametrize(("share", "separated"), [(0.5, True), (1.5, False)])
def test_noise_as_large_as_all_differences_states_no_change_of_the_slope(share, separated):
    line = scan_quality._error_caution("points scatter", 1e-10, share * 1e-10, 0.25e-3)
    assert ("raises the rms slope" in line) == separated
    assert ("noise and slopes cannot be separated here" in line) != separated


@pytest.mark.parametrize("cells", [64, 96])
@pytest.mark.parametrize("degrees", [0.02, 0.1, 0.6, 26.6, 44.5, 89.7])
def test_points_of_a_turned_grid_lie_on_a_sheet_along_z(cells, degrees):
    """Seen along x or y the rows of such a grid are steep lines, and no sheet."""
    heights = jc.wall_pair(8.0, (cells, cells), SPACING, seed=1)[0]
    y, x = SPACING * (np.indices(heights.shape) - 0.5 * cells)
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    turned = np.stack([cosine * x - sine * y, sine * x + cosine * y, heights], axis=-1)
    check_sheet(turned.reshape(-1, 3))
