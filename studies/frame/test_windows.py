"""Windows of scanned walls in which no cell is missing, and the joints that are cut out there."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.walls.roughness import detrended, rms_slope
from studies.frame.walls import Cutter, windows
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


def cutter(measured, partner, shape=(16, 20), order=1):
    about = {"z2": 0.2, "hurst": 0.8}
    walls = {side: (("y", "x"), heights, about) for side, heights in measured.items()}
    dataset = xr.Dataset(walls, attrs={"partner": partner, "spacing_m": SPACING})
    return Cutter(dataset, shape, order)


@pytest.mark.parametrize(
    ("partner", "turned"), [("rotated", np.s_[::-1, ::-1]), ("mirrored", np.s_[:, ::-1])]
)
def test_a_single_wall_meets_itself_turned(wall, partner, turned):
    whole = cutter({"lower": wall}, partner)
    origins = {"upper": whole.origin("partner", 2), "lower": whole.origin("measured", 2)}
    for side, (y, x) in origins.items():
        cut = detrended(wall[y : y + 16, x : x + 20])
        expected = cut[turned] if side == "upper" else cut
        np.testing.assert_array_equal(whole.joint(2, seed=1)[side], expected)
    assert origins["upper"] != origins["lower"]


def test_two_scans_are_cut_at_the_same_place(wall):
    other = wall[::-1].copy()
    other[0, 0] = np.nan
    whole = cutter({"upper": wall, "lower": other}, "")
    assert [0, 0] not in whole.windows.tolist()
    joint, (y, x) = whole.joint(3, seed=1), whole.origin("measured", 3)
    for side, scan in (("upper", wall), ("lower", other)):
        np.testing.assert_array_equal(joint[side], detrended(scan[y : y + 16, x : x + 20]))


def test_a_synthetic_partner_is_another_for_each_seed(wall):
    whole = cutter({"upper": wall}, "synthetic")
    one, same, other = (whole.joint(0, seed)["lower"] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.0
    assert rms_slope(one, SPACING) == pytest.approx(0.2, rel=1e-12)


def test_realisations_have_different_windows_whatever_their_number(wall):
    whole = cutter({"lower": wall}, "rotated")
    count = len(whole.windows)
    origins = [whole.origin("measured", number) for number in range(count)]
    assert len(set(origins)) == count == 25 * 33
    again, other = (cutter({"lower": wall}, "rotated", order=order) for order in (1, 2))
    assert origins == [again.origin("measured", number) for number in range(count)]
    assert origins[:9] != [other.origin("measured", number) for number in range(9)]


def test_more_realisations_than_windows_are_refused_unless_walls_are_drawn(wall):
    whole = cutter({"lower": wall}, "mirrored", (39, 52))
    whole.check(2)
    with pytest.raises(jc.InputError, match=r"study.realizations = 3: must be at most 2"):
        whole.check(3)
    cutter({"lower": wall}, "synthetic", (39, 52)).check(3)
