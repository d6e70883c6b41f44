"""Windows of scanned walls in which no cell is missing, and the joints that are cut out there."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.roughness import detrended, rms_slope
from jointclosure.walls.synthesis import synthetic_wall
from studies.frame.ensemble.walls import Cutter, MeasuredWalls, windows
from tests.joints import SPACING


@pytest.fixture
def wall():
    return jc.wall_pair(9.0, (40, 52), SPACING, seed=5)[0]


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
