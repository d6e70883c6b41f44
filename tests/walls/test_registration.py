"""Two scans of one joint are brought together as its walls were, or it is said why not."""

import re
import warnings
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

import jointclosure as jc
from benchmarks.registration import Truth, rotation
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.history import with_snapshots
from jointclosure.uncertainty.scanned_joint import _force_in_holes
from jointclosure.walls import joint_grid, registration, rotation_search, wall_files
from jointclosure.walls.gridding import Cloud, Scan, point_distance, points_of, usual_grid_spacing
from jointclosure.walls.joint_grid import LARGEST, check_cells
from jointclosure.walls.mating import Mismatch
from jointclosure.walls.motion import Motion
from jointclosure.walls.overlap import Overlap, largest_rectangle
from jointclosure.walls.pair_checks import check_confirmed
from jointclosure.walls.pair_remarks import width_remarks
from jointclosure.walls.planes import detrended
from jointclosure.walls.plateaus import remove_plateaus
from jointclosure.walls.position_search import BestFit, Position, _remedy
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration import registered
from jointclosure.walls.registration_options import ORIENTATIONS
from jointclosure.walls.registration_summary import summary_of
from jointclosure.walls.rotation_search import SlopeFit
from jointclosure.walls.scans import read_scan
from jointclosure.walls.spikes import remove_spikes, spike_heights
from jointclosure.walls.stray_points import patch_numbers
from jointclosure.walls.wall_files import registered_walls
from tests.joints import DOLERITE, SPACING, TWO_WALLS, closed

SHAPE = (64, 72)
AS_SCANNED = {"orientation": "common_frame", "shift": "scanned", "spikes": "keep"}
EXAMPLES = settings(max_examples=8, deadline=None, derandomize=True)


@pytest.fixture(autouse=True)
def few_rotations(request, monkeypatch):
    """Compare walls every 30 degrees, except in tests of walls that were turned."""
    if not {"number", "two_walls"} & set(request.fixturenames):
        monkeypatch.setattr(rotation_search, "ROTATION_STEP", 30.0)


@pytest.fixture(scope="module")
def joint():
    """Upper and lower wall, heights towards each other, correlated by 0.9."""
    return jc.wall_pair(9.0, SHAPE, SPACING, seed=4, correlation=0.9, roll_off=None)


@pytest.fixture
def walls(joint):
    """Copies of both walls."""
    return joint[0].copy(), joint[1].copy()


def scanned(wall, name="common_frame"):
    """The scan that, laid as an orientation says, is the upper wall in the lower one's frame."""
    sign = -1.0 if name in ("towards", "turned_over") else 1.0
    reversed_ = {"turned_over": np.s_[::-1], "mirrored": np.s_[:, ::-1]}.get(name, np.s_[:])
    return grid(sign * -wall[reversed_])


def grid(wall, origin=None, step=SPACING):
    return Scan(wall, (step, step), origin)


def test_units_are_those_of_each_scan(walls, tmp_path):
    sizes, files = {"mm": 1e3, "um": 1e6}, [tmp_path / "upper.npy", tmp_path / "lower.npy"]
    found = []
    for units in (("mm", "um"), ("mm", "mm")):
        for file, wall, unit in zip(files, (0.6e-3 - walls[0], walls[1]), units, strict=True):
            np.save(file, sizes[unit] * wall)
        stated = {"units": units, "scan_spacing": SPACING}
        found.append(registered_walls(*files, stated, orientation="common_frame"))
    np.testing.assert_allclose(found[0].lower, found[1].lower, atol=1e-12)
    with pytest.raises(jc.InputError, match=r"\('m', 'm', 'm'\): must be one value, or one for"):
        registered_walls(*files, {"units": ("m", "m", "m")})


@pytest.mark.parametrize(
    ("names", "warned"),
    [
        (("lower.npy", "upper.npy"), True),
        (("upper.npy", "lower.npy"), False),
        (("lower_a.npy", "b.npy"), False),
    ],
)
def test_files_whose_names_say_the_other_order_are_warned_of(walls, tmp_path, names, warned):
    files = [tmp_path / name for name in names]
    for file, wall in zip(files, (0.6e-3 - walls[0], walls[1]), strict=True):
        np.save(file, wall)
    stated = {"units": "m", "scan_spacing": SPACING}
    found = registered_walls(*files, stated, orientation="common_frame")
    assert any("is taken as the upper wall" in one for one in found.warnings) == warned


@pytest.mark.parametrize(
    ("spacing", "message"),
    [
        (0.0, r"spacing = 0.0 m: must be positive"),
        (0.25, r"spacing = 0.25 m: not usual of rock .* is 0.25 mm meant"),
    ],
)
def test_a_wrong_grid_spacing_is_refused_before_scans_are_inspected(
    walls, spacing, message, monkeypatch
):
    monkeypatch.setattr(registration, "prepared_scans", Mock(side_effect=AssertionError))
    with pytest.raises(jc.InputError, match=message):
        registered(grid(0.6e-3 - walls[0]), grid(walls[1]), spacing)


@pytest.mark.parametrize("side", ["upper", "lower"])
def test_a_flat_wall_leaves_the_gap_and_all_holes_to_the_other(side):
    heights = np.random.default_rng(1).normal(0.0, 1e-4, (2, 9, 12))
    holes = np.zeros((2, 9, 12), bool)
    holes[0, 2, 3] = holes[1, 5, 6] = True
    ends = (np.zeros(2), np.ones(2))
    overlap = Overlap(*heights, *holes, [1.0, 1.0], 0.0, 0.0, 0, ends, np.zeros(2))
    flat = overlap.with_flat_wall(side)
    assert not getattr(flat, side).any()
    assert not getattr(flat, f"{side}_holes").any()
    np.testing.assert_array_equal(flat.holes, overlap.holes)
    np.testing.assert_array_equal(flat.gap[flat.holes], overlap.gap[flat.holes])


def test_many_cells_need_a_stated_spacing(walls, monkeypatch):
    check_cells((1000, 1000), SPACING, LARGEST)
    with pytest.raises(jc.InputError, match=r"1000 x 1001 cells .* 1.5 mm"):
        check_cells((1001, 1000), SPACING, LARGEST)
    monkeypatch.setattr(wall_files, "LARGEST", 100)
    scans = [grid(wall, (0.0, 0.0)) for wall in (0.6e-3 - walls[0], walls[1])]
    registered_walls(*scans, {}, SPACING, orientation="common_frame")
    registered(*scans, orientation="common_frame")
    monkeypatch.setattr(registration, "_pair_on", Mock(side_effect=AssertionError))
    with pytest.raises(jc.InputError, match="must be at most 100 cells unless the grid spacing"):
        registered_walls(*scans, {}, orientation="common_frame")


@pytest.mark.parametrize(
    ("walls", "orientation", "refused"),
    [
        (("flat", "flat"), None, "both walls are flat"),
        (("upper.npy", "flat"), None, "must be stated where the lower wall is flat"),
        (("upper.npy", "flat"), "mirrored", "must be stated where the lower wall is flat"),
        (("flat", "lower.npy"), "towards", "must be left out"),
        (("upper.npy", np.zeros((9, 9))), None, "a wall of type ndarray"),
    ],
)
def test_what_needs_no_file_is_refused_before_files_are_read(
    walls, orientation, refused, monkeypatch
):
    monkeypatch.setattr(wall_files, "read_scan", Mock(side_effect=AssertionError))
    with pytest.raises(jc.InputError, match=refused):
        registered_walls(*walls, {}, orientation=orientation)


@pytest.mark.parametrize(("name", "quarters"), [*zip(ORIENTATIONS, range(4), strict=True)])
def test_a_wall_that_lies_on_the_nodes_of_the_other_is_laid_there_without_a_change(
    name, quarters, joint
):
    upper, lower = joint
    scan = scanned(upper, name)
    scan = scan._replace(heights=np.rot90(scan.heights, quarters))
    found = registered(scan, grid(lower), spikes="keep")
    assert found.orientation == name
    turned = abs(found.motion.angle) % 360.0
    assert min(turned % 90.0, 90.0 - turned % 90.0) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found.upper, upper, atol=1e-12)
    np.testing.assert_allclose(found.lower, lower, atol=1e-12)


@pytest.mark.parametrize("number", [0, 1, 4])
def test_the_motion_of_a_scan_is_undone_within_its_errors(number):
    """Grids and a cloud, two turned over, with noise and missing heights."""
    truth = Truth(number, cells=120, noise=5e-6, mating=1e-3, cell=SPACING)
    pair = registered(*truth.scans(), SPACING)
    angle, shift, errors = truth.errors(pair.mated)
    assert abs(angle) < 0.02
    assert shift < 0.1
    assert np.abs(errors / np.sqrt(np.diag(pair.mated.covariance))).max() < 4.0
    assert f"turned by {pair.mated.angle:.3f} +- " in " ".join(pair.remarks)
    assert "mm along (x, y), with standard errors, to the position" in " ".join(pair.remarks)
    assert pair.mated.tilt == pytest.approx(truth.about["tilt"], abs=0.1)
    assert pair.orientation == ("turned_over" if truth.about["over"] else "common_frame")
    for wall, true in zip((pair.upper, pair.lower), truth.walls(pair), strict=True):
        assert np.std((wall - true)[~pair.holes]) < 0.12 * SPACING


@pytest.mark.parametrize(("cells", "warned"), [(0, False), (6, True)])
def test_walls_that_fit_better_elsewhere_than_as_scanned_have_a_warning(joint, cells, warned):
    upper, lower = joint
    moved = grid(-upper, (0.0, cells * SPACING))
    pair = registered(moved, grid(lower, (0.0, 0.0)), **AS_SCANNED)
    lines = [line for line in cautions(pair.remarks) if "in their scanned position, and by" in line]
    assert bool(lines) == warned
    if warned:
        (x, _) = re.search(r"which lies \((\S+), (\S+)\) mm from it", lines[0]).groups()
        assert float(x) == pytest.approx(-1e3 * cells * SPACING, abs=0.1 * 1e3 * SPACING)


@pytest.mark.parametrize("tilt", [0.0, 7.0])
def test_inclined_walls_as_scanned_are_said_to_close_along_their_normal(joint, tilt):
    upper, lower = joint
    rise = np.tan(np.radians(tilt)) * SPACING * np.arange(upper.shape[1])
    pair = registered(grid(rise - upper, (0.0, 0.0)), grid(rise + lower, (0.0, 0.0)), **AS_SCANNED)
    lines = [line for line in summary_of(pair) if "close along its normal" in line]
    assert bool(lines) == (tilt > 0.0)
    assert not tilt or "becomes 0.12 mm of shift along the joint" in lines[0]


def test_the_summary_states_the_order_of_files_and_errors_that_the_range_has(joint):
    upper, lower = scanned(joint[0], "turned_over"), grid(joint[1])
    mated = registered(upper, lower)
    assert any("the first file is taken as the upper wall" in line for line in summary_of(mated))
    left = registered(scanned(joint[0]), lower, **AS_SCANNED)
    (ranged,) = [line for line in summary_of(left) if "left in their scanned position" in line]
    (single,) = [line for line in summary_of(left, False) if "left in their scanned" in line]
    assert ranged.endswith("position, which has no error in the range")
    assert single.endswith("position")
    assert not any("of the range" in line for line in summary_of(mated, False))


def test_walls_that_are_turned_as_scanned_are_refused_with_the_angle():
    truth = Truth(0, rotation=0.3, tilt=0.0, cells=100, noise=0.0, mating=1e-3, cell=SPACING)
    upper, lower = truth.scans()
    half = truth.middle[1::-1]
    upper = upper._replace(origin=tuple(np.array(upper.origin) - truth.own[1::-1] + half))
    with pytest.raises(jc.InputError, match=r"rotated by 0\.(29|30)\d \+- .* degrees against each"):
        registered(upper, lower, shift="scanned")
    left = registered(upper, lower, shift="scanned", unusual_values=True)
    assert any("rotated by 0." in line for line in left.warnings)
    mated = registered(upper, lower)
    assert mated.mated.angle == pytest.approx(0.3, abs=0.02)
    assert mated.aperture.std() < left.aperture.std()


def test_scans_mate_unless_they_are_to_stay_where_they_are():
    upper, lower = jc.wall_pair(9.0, (64, 78), SPACING, seed=4, correlation=0.999, roll_off=None)
    first, second = upper[:, 6:], lower[:, :-6]
    stay = registered(scanned(first), grid(second), shift="scanned", spikes="keep")
    np.testing.assert_array_equal(stay.motion.place, stay.motion.middle)
    moved = (stay.mated.place - stay.mated.middle)[:2]
    assert moved == pytest.approx((6 * SPACING, 0.0), abs=0.1 * SPACING)
    np.testing.assert_allclose(stay.upper, detrended(first), atol=1e-12)
    mated = registered(scanned(first), grid(second))
    assert mated.correlation > 0.85
    assert mated.aperture.mean() < stay.aperture.mean()
    true = registered(grid(-first, (0.0, 6 * SPACING)), grid(second, (0.0, 0.0)), shift="scanned")
    np.testing.assert_allclose(true.upper, mated.upper, atol=1e-12)


def test_fine_scans_are_registered_as_coarse_scans_of_the_same_walls():
    """Steps of both scans: sixths and halves of the paper's spacing, from other first points."""
    upper, lower = jc.wall_pair(9.0, (330, 342), SPACING / 6, 4, correlation=0.99, roll_off=None)
    coarse = registered(scanned(upper[::6, ::6]), grid(lower[::6, ::6]))
    fine = grid(-upper[3:, 2:], (3 * SPACING / 6, 2 * SPACING / 6), SPACING / 6)
    pair = registered(fine, grid(lower[::3, ::3], (0.0, 0.0), SPACING / 2))
    assert (pair.orientation, pair.spacing) == ("common_frame", SPACING)
    rows, columns = pair.upper.shape
    for wall, expected in ((pair.upper, coarse.upper), (pair.lower, coarse.lower)):
        expected = expected[1:, 1:][:rows, :columns]
        assert min(expected.shape) > 50
        np.testing.assert_allclose(detrended(wall), detrended(expected), atol=1e-9)


@pytest.mark.parametrize(("distance", "cell"), [(5e-5, 2.5e-4), (2e-4, 2e-4), (1e-3, 1e-3)])
def test_a_joint_has_a_spacing_near_that_of_the_paper_or_of_coarser_scans(distance, cell):
    assert usual_grid_spacing(distance) == pytest.approx(cell, rel=1e-12)


def test_a_joint_has_the_spacing_that_is_stated():
    step = SPACING / 4
    upper, lower = jc.wall_pair(9.0, (96, 96), step, 4, correlation=0.99, roll_off=None)
    pair = registered(grid(-upper, step=step), grid(lower, step=step), step, shift="scanned")
    np.testing.assert_allclose(pair.lower, lower, atol=1e-12)
    assert not any("points are" in line for line in pair.remarks)


@pytest.mark.parametrize("seed", [0, 1])  # of other seeds one in ten fits by chance
def test_independent_walls_have_no_clear_orientation(seed):
    upper, lower = jc.wall_pair(9.0, SHAPE, SPACING, seed, roll_off=None)
    with pytest.raises(jc.InputError, match=r"is ambiguous: slopes .* scanned position"):
        registered(scanned(upper, "towards"), grid(lower), spikes="keep")


def test_independent_walls_have_the_orientation_that_is_stated():
    upper, lower = jc.wall_pair(9.0, SHAPE, SPACING, 1, roll_off=None)
    stated = {"orientation": "towards", "shift": "scanned"}
    found = registered(scanned(upper, "towards"), grid(lower), **stated)
    np.testing.assert_allclose(found.upper, upper, atol=1e-12)


def test_the_wrong_orientation_is_refused_unless_it_is_meant(joint):
    with pytest.raises(jc.InputError, match=r"orientation = 'towards': common_frame fits clearly"):
        registered(scanned(joint[0]), grid(joint[1]), orientation="towards")


@pytest.fixture(scope="module")
def orientations(joint):
    """A joint in its right orientation, and in a wrong one."""
    scans = scanned(joint[0]), grid(joint[1])
    meant = {"orientation": "towards", "shift": "scanned", "unusual_values": True}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rotation_search, "ROTATION_STEP", 30.0)
        return registered(*scans), registered(*scans, **meant)


def test_the_wrong_orientation_leaves_more_voids(orientations):
    right, wrong = orientations
    assert wrong.aperture.std() > 1.2 * right.aperture.std()


def test_only_the_wrong_orientation_is_warned_of(orientations):
    right, wrong = orientations
    for found, warned in ((wrong, True), (right, False)):
        assert any("orientation" in line for line in cautions(found.remarks)) == warned


@pytest.mark.parametrize(("distance", "word"), [(1e-3, "above"), (-1e-3, "below")])
def test_walls_in_the_wrong_order_are_refused_unless_they_are_meant(distance, word, joint):
    scans = grid(distance - joint[0]), grid(joint[1])
    if word == "below":
        with pytest.raises(jc.InputError, match=r"lies below the lower one in \S+ % of the cells"):
            registered(*scans)
    remarks = registered(*scans, unusual_values=word == "below").remarks
    assert f"lies 1 mm {word} the lower one" in remarks[-1]
    assert (remarks[-1] in cautions(remarks)) == (word == "below")


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_scans_without_a_common_zero_do_not_show_the_order_of_the_walls(order, joint):
    scans = [grid(wall - wall.mean()) for wall in (-joint[0], joint[1])][order]
    remarks = registered(*scans).remarks
    assert remarks[-1].startswith("Warning: the scans have no common zero of heights")
    assert remarks[-1] in cautions(remarks)


def test_interchanged_walls_of_which_one_was_turned_over_are_the_same_joint(joint):
    upper, lower = scanned(joint[0], "turned_over"), grid(joint[1])
    given, interchanged = registered(upper, lower), registered(lower, upper)
    assert given.orientation == interchanged.orientation == "turned_over"
    assert interchanged.aperture.mean() == pytest.approx(given.aperture.mean(), rel=1e-3)


def test_two_scans_of_one_wall_are_warned_of(joint):
    noise = 1e-6 * np.random.default_rng(1).standard_normal((2, *joint[1].shape))
    found = registered(*(grid(joint[1] + each) for each in noise))
    assert any("as two scans of one wall do" in line for line in found.warnings)


def test_the_aperture_is_zero_at_first_touch_where_no_spike_is(joint, walls):
    upper, spiked = walls
    spiked[40, 50] += 3e-3
    whole, kept = (registered(scanned(upper), grid(spiked), spikes=k) for k in ("cut", "keep"))
    for pair in (whole, kept):
        summed = pair.upper + pair.lower
        assert pair.aperture.min() == 0.0 == pair.aperture[pair.first_touch_cell]
        np.testing.assert_allclose(pair.aperture + summed, summed.max(), atol=1e-15)
    assert kept.first_touch_cell == (40, 50) != whole.first_touch_cell
    assert kept.aperture.mean() > 2e-3
    assert any("lower wall: 1 of 4608 points are spikes" in line for line in whole.remarks)
    # the height in its place is that between its neighbours
    expected = registered(scanned(upper), grid(joint[1]))
    assert abs(whole.aperture.mean() - expected.aperture.mean()) < 1e-4


def counted(pair):
    """The cells in holes of the upper and the lower wall of which a pair warns."""
    (line,) = (line for line in pair.warnings if "were taken out of contact" in line)
    return tuple(map(int, re.search(r"\((\d+) of the upper, (\d+) of the lower\)", line).groups()))


def is_open(pair):
    """Whether the cells around a hole touch before it does."""
    rim = ndimage.binary_dilation(pair.holes, np.ones((3, 3))) & ~pair.holes
    return pair.aperture[pair.holes].min() > pair.aperture[rim].min()


@st.composite
def damaged(draw):
    """A mated joint, z upwards, and cells (wall, y, x) off its edges, few enough to be filled."""
    seed = draw(st.integers(0, 1000))
    step = draw(st.sampled_from([2e-6, 1e-5, 0.0]))
    walls = jc.wall_pair(8.0, (44, 52), SPACING, seed, mismatch_wavelength=2e-3, roll_off=None)
    upper, lower = np.round(np.array(walls) / step) * step if step else walls
    cells = np.zeros((2, 44, 52), bool)
    corner = st.tuples(*(st.integers(0, most) for most in (1, 34, 42, 1)))
    for wall, y, x, more in draw(st.lists(corner, min_size=1, max_size=2)):
        cells[wall, y + 1 : y + 7 + more, x + 1 : x + 8] = True
    return 1e-3 - upper, lower, cells


@EXAMPLES
@given(damaged(), st.sampled_from(["missing", "mean", "minimum", "value", "tilted", "noisy"]))
def test_all_cells_of_holes_and_of_constant_patches_are_counted_and_out_of_contact(joint, kind):
    *walls, cells = joint
    for wall, damage in zip(walls, cells, strict=True):
        values = {"missing": np.nan, "minimum": wall.min(), "value": 2e-3}
        wall[damage] = values.get(kind, wall[5, 5])
        if kind == "tilted":  # a filled scan was levelled
            wall += 5e-6 * np.arange(52)
        elif kind == "noisy":
            wall[damage] += 1e-9 * np.sin(np.arange(damage.sum()))
    found = registered(*map(grid, walls), **AS_SCANNED)
    # cells beside a patch may have its height by chance, and a patch of the other wall none
    more = np.array(counted(found)) - cells.sum(axis=(1, 2))
    assert (more >= 0).all()
    assert (more <= (0 if kind == "missing" else 8)).all()
    assert found.holes[cells.any(axis=0)].all()
    assert is_open(found)
    patches = 0 if kind == "missing" else cells.any(axis=(1, 2)).sum()
    assert sum("plateaus" in line for line in found.warnings) == patches


def test_walls_that_are_flat_or_stepped_keep_their_heights(joint):
    steps = np.indices(SHAPE)[1] // 12 * 1e-4
    for wall in (np.zeros(SHAPE), steps, np.where(joint[1] > 0.0, joint[1], 0.0)):
        assert np.isfinite(remove_plateaus(grid(wall)).heights).all()


def test_what_the_other_scan_did_not_see_is_left_out_with_the_hole_beside_it(walls):
    upper, lower = walls
    upper[30:36, 62:71] = np.nan
    lower[:, 70:] = np.nan
    lower[:20] = np.nan
    found = registered(scanned(upper), grid(lower), **AS_SCANNED)
    assert found.upper.shape == found.lower.shape == (44, 70)
    assert np.isfinite(found.upper + found.lower).all()
    assert counted(found) == (48, 0)


@pytest.mark.parametrize("flat", ["upper", "lower"])
def test_a_hole_of_a_rough_wall_does_not_touch_a_flat_one(flat, walls):
    wall, hole = walls[1], np.s_[20:28, 30:38]
    wall[hole] = np.nan
    scans = ("flat", grid(wall)) if flat == "upper" else (grid(wall), "flat")
    found = registered(*scans, orientation="towards" if flat == "lower" else None)
    assert counted(found) == ((0, 64) if flat == "upper" else (64, 0))
    assert not getattr(found, flat).any()
    assert found.holes[hole].all()
    assert is_open(found)


def test_holes_that_are_too_many_are_cut_with_a_warning(walls):
    upper, lower = walls
    lower[5:35, 30:60] = np.nan
    found = registered(scanned(upper), grid(lower))
    assert found.upper.size < 0.8 * upper.size
    assert not found.holes.any()
    (line,) = (line for line in found.warnings if "900 cells in large holes" in line)
    assert "% of the smaller scan" in line


def test_too_many_holes_everywhere_are_refused(walls):
    upper, lower = walls
    lower[5:35, 30:60] = np.nan
    lower[(np.indices(SHAPE) // 6).sum(axis=0) % 2 == 0] = np.nan
    with pytest.raises(jc.InputError, match=r"walls overlap in .* \d{4} cells lie in holes"):
        registered(scanned(upper), grid(lower), **AS_SCANNED)


def test_holes_do_not_carry_the_load_of_the_joint():
    """Closures are those without the hole; holes filled between their rims changed them by 10 %."""
    walls = jc.wall_pair(10, (44, 52), SPACING, 1, mismatch_wavelength=2e-3, roll_off=None)
    closures = []
    for damage in (False, True):
        lower = walls[1].copy()
        for y, x in [(8, 8), (30, 40), (12, 30)] * damage:
            lower[y : y + 3, x : x + 3] = np.nan
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            scans = grid(1e-3 - walls[0]), grid(lower)
            joint = jc.close(*scans, rock="granite", max_normal_stress=10e6, single=True)
        closures.append(joint.history.max_closure_seated.values[0])
        of_force = [line for line in joint.pair.remarks if "% of the force" in line]
        assert len(of_force) == damage
        assert "snapshot" not in joint.history.dims
    assert any("out of contact" in str(line.message) for line in warned)
    assert float(re.search(r"carry (\S+) %", of_force[0])[1]) < 2.0
    assert closures[1] == pytest.approx(closures[0], rel=0.06)


def test_a_hole_hardly_changes_the_mismatch_wavelength():
    upper, lower = jc.wall_pair(9.0, (80, 96), SPACING, 5, roll_off=None, mismatch_wavelength=3e-3)
    known, y, x = upper.copy(), *np.ogrid[:80, :96]
    known[np.hypot(y - 40, x - 48) < 12] = np.nan
    whole, holed = (
        registered(scanned(wall), grid(lower), **AS_SCANNED).mismatch for wall in (upper, known)
    )
    assert holed.wavelength == pytest.approx(whole.wavelength, rel=0.2)


def test_the_force_on_holes_is_their_share_of_the_force_at_the_highest_stress(joint):
    pair = registered(*map(grid, (1e-3 - joint[0], joint[1])), **AS_SCANNED)
    history = closed(joint, 2e6, snapshots=[1e6, 2e6], cycles=1)
    force = history.snapshot_force.values[history.snapshot_stress.values.argmax()]
    for columns in (slice(30), slice(30, None)):
        holes = np.zeros(SHAPE, bool)
        holes[:, columns] = True
        (line,) = _force_in_holes(pair._replace(holes=holes), history, 2e6)
        stated = re.search(r"holes of a scan carry (\S+) % of the force at 2 MPa", line)[1]
        share = 100.0 * force[:, columns].sum() / force.sum()
        assert 1.0 < share < 99.0
        assert float(stated) == pytest.approx(share, rel=0.05)
    assert set(with_snapshots(history, [1e6]).snapshot_stress.values) == {1e6}


def test_a_joint_that_failed_states_the_force_on_holes_as_far_as_it_is_known(joint):
    pair = registered(*map(grid, (1e-3 - joint[0], joint[1])), **AS_SCANNED)
    pair = pair._replace(holes=np.ones(SHAPE, bool))
    history = closed(joint, 2e6, snapshots=[0.0, 1e6], cycles=1)
    (line,) = _force_in_holes(pair, history, 2e6)
    assert line.endswith("100 % of the force at 1 MPa (not known at 2 MPa, which was not reached)")
    for stresses in ([0.0], []):
        stored = history.isel(snapshot=history.snapshot_stress.isin(stresses))
        (line,) = _force_in_holes(pair, stored, 2e6)
        assert "is not known, as the joint reached no stress" in line


@settings(EXAMPLES, max_examples=4)
@given(
    st.integers(0, 1000),
    st.floats(2.0, 20.0),
    st.sampled_from([1e-6, 1e-5, 0.0]),
    st.sampled_from([10.0, 25.4, 0.1, 1 / 25.4, 1000.0]),
    st.sampled_from([0, 1]),
)
def test_heights_in_another_unit_than_x_and_y_are_refused_or_warned_of(
    seed, jrc, step, factor, wrong
):
    walls = np.array(jc.wall_pair(jrc, (44, 52), SPACING, seed, correlation=0.9))
    upper, lower = np.round(walls / step) * step if step else walls
    scans = grid(1e-3 - upper), grid(lower)
    found = registered(*scans, **AS_SCANNED)
    none = ("unit", "plateaus", "holes")
    assert not any(word in line for line in found.remarks for word in none)
    both = [scan._replace(heights=factor * scan.heights) for scan in scans]
    words = rf"in another unit than x and y, by a factor of .*{max(factor, 1 / factor):g}"
    pair = [both[k] if k == wrong else scans[k] for k in (0, 1)]
    with pytest.raises(jc.InputError, match=rf"times as steep as .*{words}"):
        registered(*pair, **AS_SCANNED)
    try:
        lines = registered(*both, **AS_SCANNED).warnings
    except jc.InputError as error:
        lines = [str(error)]
    assert re.search(rf"rms slope of .*{words}", " ".join(lines))


@pytest.mark.parametrize(("mismatch", "factor"), [(0.5e-3, 2.0), (5e-3, 2.54), (1e-3, 1 / 2.54)])
def test_a_mated_wall_whose_heights_are_in_another_unit_is_refused(mismatch, factor):
    walls = jc.wall_pair(10.0, (44, 52), SPACING, 3, mismatch_wavelength=mismatch, roll_off=None)
    upper, lower = grid(1e-3 - walls[0]), grid(walls[1])
    registered(upper, lower, **AS_SCANNED)
    with pytest.raises(jc.InputError, match=r"times those of the other .*inches and cm"):
        registered(upper._replace(heights=factor * upper.heights), lower, **AS_SCANNED)


def copies(wall):
    """What one file may be given as twice: as it is, in other words, and moved."""
    scan = scanned(wall)
    return {
        "as points": (scan, Cloud(points_of(scan))),
        "turned over": (scanned(wall, "turned_over"), scan),
        "moved": (scan._replace(origin=(0.0, 3 * SPACING)), scan),
        "printed": (scan, scan._replace(heights=np.round(scan.heights, 9))),
    }


@pytest.mark.parametrize("kind", copies(np.zeros((4, 4))))
def test_a_copy_of_a_scan_is_refused_unless_it_is_meant(kind, joint):
    scans = copies(joint[0])[kind]
    with pytest.raises(jc.InputError, match=r"(given twice|a copy of the other); unusual_values"):
        registered(*scans, shift="mated", spikes="keep")
    pair = registered(*scans, shift="mated", spikes="keep", unusual_values=True)
    assert abs(pair.correlation) == pytest.approx(1.0)
    assert np.abs(pair.mating.correlation).max() <= 1.0


@pytest.mark.parametrize("seed", range(12))
def test_the_largest_rectangle_is_the_largest(seed):
    rng = np.random.default_rng(seed)
    full = rng.random((7, 9)) < rng.choice([0.5, 0.8, 0.95])
    best = max(
        (
            (b - a) * (d - c)
            for a in range(7) for b in range(a + 1, 8) for c in range(9) for d in range(c + 1, 10)
            if full[a:b, c:d].all()
        ),
        default=0,
    )  # fmt: skip
    found = full[largest_rectangle(full)]
    assert found.all()
    assert found.size == best


def test_gaussian_walls_have_no_spikes(joint):
    assert not np.isfinite(spike_heights(points_of(grid(joint[0])))).any()


@pytest.fixture
def spiked(walls):
    """A wall with three outliers, two of them beside each other."""
    wall = walls[0]
    wall[30, 31] += 2e-3
    wall[60, 20] -= 2e-3
    wall[60, 21] -= 2.2e-3
    return wall


def test_single_outliers_are_spikes(spiked, joint):
    left, about = remove_spikes(grid(spiked))
    np.testing.assert_array_equal(np.isnan(left.heights), spiked != joint[0])
    assert about.startswith("3 of 4608 points are spikes")


def test_spikes_of_a_cloud_are_those_of_its_grid(spiked):
    cloud, about = remove_spikes(Cloud(points_of(grid(spiked))))
    assert len(cloud.points) == spiked.size - 3
    assert about == remove_spikes(grid(spiked))[1]


@pytest.fixture
def mates():
    """Heights of two walls as they were scanned, one above the other."""
    upper, lower = jc.wall_pair(9.0, (48, 52), SPACING, seed=4, correlation=0.9)
    return 1e-3 - upper, lower


def assert_warned_of(pair, warning):
    found = registered(*pair, **AS_SCANNED, unusual_values=True)
    assert any(line.startswith(f"Warning: {warning}") for line in found.warnings)


def test_walls_that_lie_well_are_not_warned_of(mates):
    assert registered(*map(grid, mates), **AS_SCANNED).warnings == []


def test_a_wedge_is_warned_of(mates):
    upper, lower = mates
    wedge = np.tan(np.radians(2.0)) * np.indices(upper.shape)[0] * SPACING
    pair = grid(upper + wedge), grid(lower)
    assert_warned_of(pair, "the walls are inclined to each other by 2.0 degrees")


def test_a_small_overlap_is_warned_of(mates):
    upper, lower = mates
    pair = grid(upper[:, 30:], (0.0, 30 * SPACING)), grid(lower[:, :39], (0.0, 0.0))
    assert_warned_of(pair, "the walls overlap in 44 % of the smaller scan, less than 50 %")


@pytest.mark.parametrize("shift", ["scanned", "mated"])
@pytest.mark.parametrize("degrees", [10.0, 19.0, 35.0])
def test_inclined_scans_of_both_walls_are_the_joint_of_level_ones(shift, degrees):
    upper, lower = jc.wall_pair(9.0, (40, 44), SPACING, seed=4, correlation=0.9)
    clouds = [points_of(grid(wall)) for wall in (1e-3 - upper, lower)]
    inclined = [Cloud(points @ rotation("y", degrees).T) for points in clouds]
    known = {"orientation": "common_frame", "shift": shift, "spikes": "keep"}
    level = registered(*map(Cloud, clouds), SPACING, **known)
    pair = registered(*inclined, SPACING, **known)
    turned = f"lower wall: the mean plane is inclined by {degrees:.1f} degrees: the scan was turned"
    assert any(line.startswith(turned) for line in pair.remarks)
    assert pair.aperture.std() == pytest.approx(level.aperture.std(), rel=0.08)
    assert min(pair.upper.shape) >= 37
    assert not any("inclined" in warning for warning in pair.warnings)


def test_a_flat_wall_on_an_inclined_scan_is_as_on_a_level_one():
    lower = jc.wall_pair(9.0, (40, 44), SPACING, seed=4)[1]
    inclined = Cloud(points_of(grid(lower)) @ rotation("y", 19.0).T)
    level, pair = (registered("flat", wall, SPACING) for wall in (grid(lower), inclined))
    assert pair.lower.shape in ((40, 44), (40, 43))
    assert pair.lower.std() == pytest.approx(level.lower.std(), rel=0.03)


def test_an_aperture_map_on_a_flat_wall_is_a_rough_wall_under_a_flat_one(joint):
    rough = joint[1]
    tilted = rough + 5e-6 * np.indices(rough.shape)[1]
    lower, aperture = grid(tilted), grid(rough.max() - rough)
    under = registered("flat", lower, spikes="keep")
    mapped = registered(aperture, "flat", orientation="common_frame", spikes="keep")
    turned = registered(lower, "flat", orientation="towards", spikes="keep")
    for pair in (mapped, turned):
        np.testing.assert_allclose(pair.aperture, under.aperture, atol=1e-12)
    assert not under.upper.any()
    assert not mapped.lower.any()
    assert not under.warnings
    for scans, orientation, refused in (
        ((lower, "flat"), None, "must be stated where the lower wall is flat"),
        (("flat", "flat"), None, "both walls are flat"),
        (("flat", lower), "towards", "must be left out"),
    ):
        with pytest.raises(jc.InputError, match=refused):
            registered(*scans, orientation=orientation)


@pytest.mark.parametrize(("degrees", "warned"), [(4.5, False), (5.5, True)])
def test_an_aperture_map_is_warned_of_if_it_is_inclined_by_more_than_five_degrees(degrees, warned):
    upper, lower = jc.wall_pair(9.0, (48, 52), SPACING, seed=4, correlation=0.9)
    plane = np.tan(np.radians(degrees)) * np.indices(upper.shape)[0] * SPACING
    found = registered(grid(2e-3 - upper - lower + plane), "flat", **AS_SCANNED)
    text = f"Warning: the plane is inclined by {degrees} degrees, more than 5"
    assert any(line.startswith(text) for line in found.warnings) == warned


def test_a_fit_of_slopes_at_which_heights_have_no_position_is_refused():
    middle, fits = np.zeros(3), [SlopeFit("rotated", 0.9, 10.0, np.zeros(2))]
    mated = Motion(np.eye(3), np.eye(3), middle, middle, np.full((3, 3), np.nan))
    position = Position(mated, False, BestFit("rotated", fits, mated, []), [])
    with pytest.raises(jc.InputError, match=r"ambiguous: slopes correlate by rotated 0.90 at 10 d"):
        check_confirmed(position)
    sure = position.fit._replace(mated=mated._replace(covariance=np.eye(3)))
    check_confirmed(position._replace(fit=sure))
    check_confirmed(position._replace(fit=position.fit._replace(mated=None)))


@pytest.mark.parametrize("number", [4])  # of walls that are compared at all rotations
def test_heights_in_another_unit_are_named_where_they_are_why_no_position_is_found(number):
    """Least squares of heights find no position, but the message says what is wrong."""
    upper, lower = jc.wall_pair(
        9.0, SHAPE, SPACING, number, mismatch_wavelength=2e-3, roll_off=None
    )
    scans = grid(1e-3 - upper), grid(10.0 * lower)
    found = registered(*scans, unusual_values=True)
    assert not np.isfinite(found.mated.covariance).all()
    with pytest.raises(jc.InputError, match=r"times as steep as .*in another unit than x and y"):
        registered(*scans)


def test_walls_given_as_scans_are_refused_without_a_name_of_a_file(walls):
    with pytest.raises(jc.InputError, match=r"^upper and lower: the same scan was given twice"):
        registered_walls(grid(walls[0]), grid(walls[0]), {}, SPACING)


def test_holes_that_were_filled_do_not_count_in_the_slopes_that_a_wall_lost(walls, monkeypatch):
    compared = []

    def none(cloud, wall, *more):
        compared.append(wall)

    monkeypatch.setattr(joint_grid, "slopes_by_interpolation", none)
    upper = 0.6e-3 - walls[0]
    upper[10:13, 10:13] = np.nan
    pair = registered(grid(upper), grid(walls[1]), **AS_SCANNED)
    np.testing.assert_array_equal(np.isnan(compared[0]), pair.holes)
    assert not np.isnan(compared[1]).any()


def test_a_joint_without_holes_has_no_remark_about_their_force(walls):
    scans = grid(0.6e-3 - walls[0]), grid(walls[1])
    conditions = jc.Conditions(SPACING, DOLERITE, 1e6, 1, 0.1e6)
    joint = jc.close(*scans, conditions=conditions, orientation="common_frame", single=True)
    assert not [line for line in joint.pair.remarks if "of the force" in line]
    assert "snapshot_stress" not in joint.history


@pytest.mark.parametrize(("gap", "count"), [(3.0, 1), (12.0, 2)])
def test_points_apart_by_many_times_their_distance_are_patches(gap, count):
    x, y = (part.ravel() for part in np.meshgrid(np.arange(20.0), np.arange(10.0)))
    x = np.where(x < 10.0, x, x + gap - 1.0)
    assert len(np.unique(patch_numbers(SPACING * np.column_stack([x, y])))) == count


@pytest.fixture(scope="module")
def two_walls():
    """Every third point of the scans of a published fracture, and the walls that they make."""
    if not TWO_WALLS.is_dir():
        pytest.skip("the two walls are not here")
    names = ("side_b_top.txt", "side_a_bottom.txt")
    scans = (read_scan(TWO_WALLS / name, units="mm") for name in names)
    upper, lower = (Cloud(scan.points[::3]) for scan in scans)
    return upper, lower, registered(upper, lower, 1e-3)


@pytest.mark.parametrize(("name", "degrees"), [("turned_over", 33.0), ("common_frame", 171.0)])
def test_the_walls_of_a_published_fracture_are_laid_together_at_any_angle(name, degrees, two_walls):
    upper, lower, right = two_walls
    assert right.orientation == "common_frame"
    assert right.correlation > 0.9
    over = np.diag([1.0, -1.0, -1.0] if name == "turned_over" else [1.0, 1.0, 1.0])
    turn = rotation("z", degrees) @ rotation("x", 2.0)
    found = registered(Cloud(upper.points @ (over @ turn)), lower, 1e-3)
    assert found.orientation == name
    angle = abs(found.mated.angle - right.mated.angle)
    assert angle == pytest.approx(degrees, abs=4.0 * found.mated.standard_errors()[0])
    assert found.correlation == pytest.approx(right.correlation, abs=0.005)
    assert found.aperture.std() == pytest.approx(right.aperture.std(), rel=0.05)


def test_angles_of_tried_fits_have_the_convention_of_the_motion():
    """From -180 to 180 degrees, so that both lines of the report can be compared."""
    tried = {
        angle: str(SlopeFit("turned_over", 0.86, angle, np.zeros(2))) for angle in (6.0, 186.0)
    }
    assert tried[186.0] == "turned_over 0.86 at -174 degrees"
    assert tried[6.0] == "turned_over 0.86 at 6 degrees"


def test_holes_of_scattered_points_do_not_change_the_spacing_of_the_other_grid(walls):
    """The grid would be interpolated, and lose its short waves."""
    ground = grid(walls[1], (0.0, 0.0))
    points = points_of(grid(0.6e-3 - walls[0], (0.0, 0.0)))
    whole = points + np.array([0.4 * SPACING, 0.3 * SPACING, 0.0])
    middle = whole[:, :2].mean(axis=0)
    hole = np.linalg.norm(whole[:, :2] - middle, axis=1) < 9.0 * SPACING
    assert 0.04 < hole.mean() < 0.07
    scattered = Cloud(whole[~hole])
    assert point_distance(scattered) > 1.005 * SPACING
    pair = registered(scattered, ground, orientation="common_frame", shift="scanned")
    assert pair.spacing == SPACING
    far = Cloud(whole[::2])
    assert point_distance(far) > 1.3 * SPACING
    assert registered(far, ground, orientation="common_frame", shift="scanned").spacing > SPACING


@pytest.mark.parametrize("number", [1, 4])
def test_fits_of_one_broad_peak_are_one_fit(number):
    """Slopes correlate nearly as well at rotations that differ by 12 degrees."""
    upper, lower = jc.wall_pair(
        10.0, (52, 52), SPACING, number, mismatch_wavelength=3e-3, roll_off=None
    )
    scans = [points_of(grid(heights)) for heights in (-upper, lower)]
    turned = (scans[0] - scans[0].mean(axis=0)) @ (rotation("z", 5.0) @ rotation("y", 3.0)).T
    pair = registered(Cloud(turned), Cloud(scans[1]), SPACING)
    assert pair.orientation == "common_frame"
    error = pair.motion.standard_errors()[0]
    assert pair.motion.angle == pytest.approx(-5.0, abs=3.0 * error)


def of_width(wavelengths):
    """A pair whose overlap has a width of so many mismatch wavelengths, and a fit with an error."""
    width = 64 * 0.25e-3
    wavelength = width / wavelengths if wavelengths else 0.0
    place = np.zeros(3)
    motion = Motion(np.eye(3), np.eye(3), place, place, np.diag([1e-4, 1e-5, 1e-5]) ** 2)
    pair = dict.fromkeys(RegisteredPair._fields[:16])
    walls = np.random.default_rng(0).normal(0.0, 1e-5, (2, 64, 80))
    return RegisteredPair(**pair | {
        "upper": walls[0], "lower": walls[1], "spacing": 0.25e-3, "motion": motion,
        "mated": motion, "first": place[:2], "holes": np.zeros((64, 80), bool),
        "mismatch": Mismatch(wavelength, 0.9 * wavelength, 1.1 * wavelength),
    })  # fmt: skip


def test_narrow_overlaps_say_by_what_their_standard_errors_are_too_small():
    (remark,) = width_remarks(of_width(5.0))
    assert "only 5 mismatch wavelengths wide" in remark
    assert "2.4 times as large as these standard errors" in remark
    assert "taken as 0.014 degrees and (0.0240, 0.0240) mm" in remark
    assert width_remarks(of_width(10.5)) == []


def test_errors_of_the_position_on_narrow_overlaps_are_larger_than_those_of_the_fit():
    wide, narrow = (np.sqrt(np.diag(of_width(n).errors.covariance)) for n in (12.0, 6.4))
    np.testing.assert_allclose(narrow / wide, 1.55, rtol=1e-12)
    np.testing.assert_allclose(wide, [1e-4, 1e-5 / 0.25e-3, 1e-5 / 0.25e-3], rtol=1e-12)


@pytest.mark.parametrize("wavelengths", [0.0, np.inf])
def test_walls_without_a_mismatch_wavelength_keep_the_errors_of_the_fit(wavelengths):
    pair = of_width(wavelengths)
    assert pair.error_factor == 1.0
    assert width_remarks(pair) == []


@pytest.mark.parametrize(("folder", "width"), [("2", 8.0), ("25", 6.4), ("29", 5.5)])
def test_the_error_factor_is_that_of_the_stored_test(folder, width):
    stored = Path("benchmarks/results") / f"registration_small_{folder}" / "summary.csv"
    (row,) = pd.read_csv(stored).to_dict("records")
    scores = [row[f"rms_z_{name}"] for name in ("angle", "x", "y")]
    measured = np.sqrt(np.mean(np.square(scores)))
    assert of_width(width).error_factor == pytest.approx(measured, rel=0.05)


@pytest.mark.parametrize(
    ("other", "stated"),
    [
        (SlopeFit("towards", 0.8, 10.0, np.zeros(2)), "turned_over or towards: state"),
        (SlopeFit("turned_over", 0.8, 350.0, np.zeros(2)), "their rotations differ by 20 degrees"),
    ],
)
def test_an_ambiguous_fit_says_how_both_fits_differ(other, stated):
    remedy = _remedy(SlopeFit("turned_over", 0.9, 10.0, np.zeros(2)), other)
    assert stated in remedy
    assert "--orientation turned_over --shift mated" in remedy


@pytest.mark.parametrize(
    ("factor", "meant"), [(1e-3, "is 0.0075 m meant?"), (1e6, "is 7500 mm meant")]
)
def test_scans_with_an_unusual_side_say_how_long_it_is_and_what_determines_it(factor, meant):
    heights = factor * 1e-4 * np.random.default_rng(1).standard_normal((2, 16, 16))
    scans = [Scan(wall, (factor * 0.5e-3,) * 2) for wall in heights]
    with pytest.raises(jc.InputError, match=r"a side of the scan is .* mm long.*--units") as found:
        registered(*scans, orientation="common_frame")
    assert meant in str(found.value)
