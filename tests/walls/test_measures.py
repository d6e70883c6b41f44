"""What is measured of a wall is what it was made with."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.inputs.remarks import cautions
from jointclosure.statistics.randomness import generator
from jointclosure.walls import mating as mating_module
from jointclosure.walls.gridding import Cloud, points_of, wall_on_grid
from jointclosure.walls.mating import mating, measured_mismatch, slope_correlations
from jointclosure.walls.measures import hurst_of, mean_curvature, measure_wall, peak_cells
from jointclosure.walls.roughness import RELATIONS, bearing_depths, rms_slope
from jointclosure.walls.scans import read_scan
from jointclosure.walls.scans.points import _find_axis
from jointclosure.walls.synthesis import Spectrum, synthetic_wall
from tests.joints import SPACING, TWO_WALLS, bump
from tests.walls.test_formats import STEP_MM
from tests.walls.writers import Ground, triangles

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


def test_depths_are_those_of_sorted_heights():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 1)
    highest = np.sort((upper + lower).ravel())[::-1]
    for cells in (1, 2, 12, 600, 1200):
        found = bearing_depths(upper + lower, cells / 1200)
        assert found == pytest.approx(highest[0] - highest[cells - 1], abs=1e-18)


def test_the_interval_of_a_mismatch_wavelength_ends_where_the_likelihood_ratio_is_significant(
    monkeypatch,
):
    """Of a wavelength whose logarithm has a normal likelihood: 1.96 standard deviations off."""
    monkeypatch.setattr(mating_module, "_ring_powers", lambda *walls: ())
    monkeypatch.setattr(
        mating_module, "_profile_likelihood", lambda tried: -0.5 * (np.log(tried / 4e-3) / 0.2) ** 2
    )
    flat = np.zeros((4000, 4000))  # long beside the wavelength, which it resolves
    ends = np.sort(measured_mismatch(flat, flat, SPACING))
    np.testing.assert_allclose(np.log(ends / 4e-3), [-0.392, 0.0, 0.392], atol=0.02)


def test_coordinates_of_fewer_than_three_lines_have_no_axis():
    assert _find_axis(np.repeat([0.0, 1.0], 20), 0.1) is None
    assert _find_axis(np.zeros(40), 0.1) is None
    assert _find_axis(np.repeat([0.0, 1.0, 2.0], 20), 0.1).step == pytest.approx(1.0)


def test_depths_of_several_shares_are_those_of_each_up_to_all_cells():
    summed = sum(jc.wall_pair(8, (30, 40), 0.25e-3, 1))
    shares = [0.0, 0.0107, 0.05, 0.5003, 1.0]
    depths = bearing_depths(summed, shares)
    np.testing.assert_array_equal(depths, [bearing_depths(summed, share) for share in shares])
    assert depths[-1] == pytest.approx(np.ptp(summed))


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


# Points on a regular grid are that grid, whatever their order, gaps and repeats


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


# Fit of two walls: by shift, by wavelength, and the wavelength beyond which they are mated


PAIRS = 10


def found_in(cells, **how):
    """Estimates (wavelength and ends, pairs) [m] of pairs with a mismatch of so many cells."""
    how["mismatch_wavelength"] = None if cells is None else cells * SPACING
    pairs = (jc.wall_pair(8.0, (80, 96), SPACING, seed, **how) for seed in range(PAIRS))
    return np.transpose([measured_mismatch(*pair, SPACING) for pair in pairs])


@pytest.mark.parametrize(
    ("cells", "how"), [(5, {}), (9, {"hurst": 0.5}), (9, {"roll_off": 3e-3}), (16, {})]
)
def test_the_interval_of_a_mismatch_wavelength_covers_it(cells, how):
    wavelength, low, high = found_in(cells, **how) / (cells * SPACING)
    assert np.median(wavelength) == pytest.approx(1.0, abs=0.08)
    assert np.mean((low <= 1.0) & (high >= 1.0)) >= 0.9
    # it says something: within a third of it, where walls are so many wavelengths long
    assert np.median(high / low) < 1.6


def test_mates_have_no_mismatch_wavelength():
    assert np.all(found_in(0) == 0.0)


def test_independent_walls_may_have_an_infinite_mismatch_wavelength():
    wavelength, low, high = found_in(None)
    # the few longest waves correlate by chance
    assert np.median(wavelength) == np.inf
    assert np.all(high == np.inf)
    assert np.all(low > 4 * SPACING)


def test_mates_correlate_at_all_wavelengths():
    upper, lower = jc.wall_pair(9.0, (64, 64), SPACING, seed=4, correlation=1.0, roll_off=None)
    mates = mating(upper, lower, SPACING)
    np.testing.assert_allclose(mates.correlation, 1.0, atol=1e-12)


def test_independent_walls_correlate_at_no_wavelength():
    scores = []
    for seed in range(20):
        found = mating(*jc.wall_pair(9.0, (64, 64), SPACING, seed, roll_off=None), SPACING)
        scores.append(found.correlation * np.sqrt(found.modes))
    # standard errors are as stated: the scores have a spread of one
    assert 0.8 < np.std(scores) < 1.25
    assert abs(np.mean(scores)) < 0.3


def test_a_band_of_half_an_octave_is_named_by_its_middle():
    n, wavelength = 128, 8 * SPACING
    x = np.arange(n) * SPACING
    rng = np.random.default_rng(1)
    noise = 1e-6 * rng.normal(size=(2, n, n))
    wave = 1e-4 * np.cos(2.0 * np.pi * x / wavelength)
    found = mating(noise[0] + wave, noise[1] - wave, SPACING)
    band = int(np.argmin(np.abs(np.log(found.wavelengths / wavelength))))
    assert found.correlation[band] > 0.99
    assert np.abs(np.delete(found.correlation, [band - 1, band, band + 1])).max() < 0.5


def test_correlations_over_shifts_are_those_of_the_definition():
    rng = np.random.default_rng(3)
    fixed, moved = rng.normal(size=(7, 8)), rng.normal(size=(6, 7))
    fixed[2, 3] = moved[4, 1] = np.nan
    found = slope_correlations(fixed, moved.shape, 0.5)(moved)
    slopes = [
        np.diff(field, axis=1)[:-1] + 1j * np.diff(field, axis=0)[:, :-1]
        for field in (fixed, moved)
    ]
    least = 0.5 * min(np.isfinite(field).sum() for field in slopes)
    one, other = slopes
    for down in range(-3, 4):
        for right in range(-3, 4):
            pairs = np.array([
                (one[y, x], other[y - down, x - right])
                for y in range(one.shape[0]) for x in range(one.shape[1])
                if 0 <= y - down < other.shape[0] and 0 <= x - right < other.shape[1]
            ])  # fmt: skip
            a, b = pairs[np.isfinite(pairs).all(axis=1)].T
            if len(a) >= least:
                expected = (a @ b.conj()).real / np.sqrt((a @ a.conj() * (b @ b.conj())).real)
                assert found[down, right] == pytest.approx(expected, abs=1e-12)
            else:
                assert np.isnan(found[down, right])
