"""Scanned walls in a study: from what its configuration says to the joints that are cut."""

import json

import numpy as np
import pytest
import scipy
import xarray as xr

import jointclosure as jc
from jointclosure.walls.gridding import Scan
from jointclosure.walls.jrc import rms_slope
from jointclosure.walls.planes import detrended
from studies.frame.cases import block_settings, cases_of, wall_name
from studies.frame.keys import Grid
from studies.frame.rocks import check_files
from studies.frame.scanned_walls import (
    Cutter,
    cut_walls,
    described,
    prepare_walls,
    prepared_walls,
    windows,
)
from studies.frame.yaml_files import ConfigurationError
from tests.joints import SPACING
from tests.studied import study_of

WALLS = {"lower": "scan.npz", "upper": "rotated", "units": "mm"}
NO_JRC = {"jrc": None, "levels": {"jrc": None}}
RELATION = "yu_vayssade_linear_0.25mm"


def with_walls(**changes):
    walls = {key: value for key, value in (WALLS | changes).items() if value != "absent"}
    return {"study": {"rocks": ["slate"]}, "rocks": {"slate": NO_JRC | {"walls": walls}}}


@pytest.fixture
def scan():
    wall = jc.wall_pair(9.0, (40, 50), SPACING, seed=3, roll_off=None)[0]
    return Scan(wall, (SPACING, SPACING))


def prepared(scans, **changes):
    walls = study_of(with_walls()).rocks["slate"].walls
    return prepared_walls(scans, walls._replace(**changes), SPACING, RELATION)


def test_measured_walls_take_the_place_of_a_jrc():
    study = study_of(with_walls()).study
    cases = cases_of(study_of(with_walls()))
    assert [case.parameter for case in cases] == [
        "base", *["poisson_ratio"] * 2, *["youngs_modulus"] * 2, *["compressive_strength"] * 2,
    ]  # fmt: skip
    assert all(np.isnan(case.jrc) for case in cases)
    common = study_of(with_walls(), {"study": {"draws": "common"}}).study
    assert len({wall_name(common, case) for case in cases}) == 1
    assert len({wall_name(study, case) for case in cases}) == len(cases)


@pytest.mark.parametrize(
    ("rock", "printed"),
    [
        ({"walls": WALLS, "levels": {"jrc": None}}, "slate.jrc = 6.5: must be left out with walls"),
        ({"walls": WALLS, "jrc": None}, "levels.jrc = [5, 8]: must be left out for scanned walls"),
        ({"jrc": None}, "rocks.slate: must have jrc, or walls"),
        (NO_JRC | {"walls": WALLS | {"lower": "mirrored"}}, "at least one must be a file"),
    ],
)
def test_what_contradicts_measured_walls_is_named(rock, printed):
    with pytest.raises(ConfigurationError) as error:
        study_of({"study": {"rocks": ["slate"]}, "rocks": {"slate": rock}})
    assert printed in str(error.value)


def test_a_file_that_is_not_there_is_named_with_its_key(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(jc.InputError, match=r"rocks.slate.walls.lower = 'scan.npz': not found in"):
        check_files(study_of(with_walls()).rocks)
    (tmp_path / "scan.npz").write_bytes(b"")
    check_files(study_of(with_walls()).rocks)
    (tmp_path / "folder").mkdir()
    with pytest.raises(jc.InputError, match=r"walls.upper = 'folder': not found in"):
        check_files(study_of(with_walls(upper="folder")).rocks)
    check_files(study_of().rocks)


def test_all_files_that_are_missing_are_named_at_once_with_what_is_allowed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    curve = {"rocks": {"slate": {"measured": {"file": "lab.csv", "stress_unit": "MPa"}}}}
    with pytest.raises(jc.InputError) as error:
        check_files(study_of(with_walls(), curve).rocks)
    of_walls, of_curve = str(error.value).splitlines()[1:]
    place = f"not found in {tmp_path}; must be the path of a file (from there, or absolute)"
    assert of_walls.startswith(f"  rocks.slate.walls.lower = 'scan.npz': {place} or one of rotated")
    assert of_curve == f"  rocks.slate.measured.file = 'lab.csv': {place}"


def test_heights_that_point_into_the_rock_are_turned(scan):
    walls = prepared({"upper": scan, "lower": scan}, upper="a.npz", inverted=["upper"])
    np.testing.assert_array_equal(walls.upper.values, -walls.lower.values)
    # a wall over itself in one frame is mated: no part of it touches first
    joint = Cutter(walls, (20, 20), 1).joint(0, 0)
    np.testing.assert_allclose(joint["upper"] + joint["lower"], 0.0, atol=1e-18)


def test_walls_of_a_later_block_are_those_of_the_whole(scan):
    walls = prepared({"lower": scan})
    study = study_of(with_walls())
    room = Cutter(walls, (20, 24), 5).room()
    assert room["windows_side_by_side"] == 4
    stored = xr.Dataset(attrs={name: np.int64(count) for name, count in room.items()})
    assert json.loads(described({"slate": stored})) == {"slate": room}
    surfaces = block_settings(
        study._replace(rocks={"slate": study.rocks["slate"]._replace(walls=None)}),
        cases_of(study)[0], range(3),
    )._replace(grid=Grid(cells_x=24, cells_y=20, spacing_mm=1e3 * SPACING))  # fmt: skip
    pairs = list(cut_walls(walls, surfaces))
    later = cut_walls(walls, surfaces._replace(first_realization=1, realizations=2))
    for pair, again in zip(pairs[1:], later, strict=True):
        np.testing.assert_array_equal(pair, again)
    assert not np.array_equal(pairs[0], pairs[1])


def with_rim(wall, side):
    raised = wall + 1e-3
    kept = np.s_[:, 2:] if side == "left" else np.s_[:, :-2]
    raised[kept] = wall[kept]
    return raised


@pytest.mark.parametrize("degrees", [0.0, 12.0])
def test_walls_that_lie_on_each_other_do_so_once_their_rims_are_cut(degrees, scan):
    plane = np.tan(np.radians(degrees)) * SPACING * np.indices(scan.heights.shape)[1]
    walls = prepared(
        {
            "upper": scan._replace(heights=with_rim(scan.heights + plane, "left")),
            "lower": scan._replace(heights=with_rim(scan.heights + plane, "right")),
        },
        upper="a.npz",
        inverted=["upper"],
    )
    assert walls.upper.shape[1] in (46, 47, 48)  # of 50 columns
    rough = detrended(walls.lower.values)
    assert np.abs(detrended((walls.upper + walls.lower).values)).max() < 0.02 * rough.std()


@pytest.mark.parametrize("damage", ["blocks", "inclined"])
def test_walls_whose_cells_do_not_lie_on_each_other_are_refused(damage, scan):
    x = np.indices(scan.heights.shape)[1]
    if damage == "blocks":
        upper = np.kron(scan.heights[::2, ::2], np.ones((2, 2)))
        lower = scan.heights
    else:
        upper = scan.heights[:-2, 2:]
        lower = scan.heights + 0.3 * SPACING * x
    scans = {"upper": scan._replace(heights=upper), "lower": scan._replace(heights=lower)}
    with pytest.raises(jc.InputError, match="bring_together: true"):
        prepared(scans, upper="a.npz")


@pytest.mark.parametrize("rounded", [True, False])
def test_rounding_of_inclined_walls_is_stored_with_them(rounded, scan):
    inclined = scan.heights + 0.3 * SPACING * np.indices(scan.heights.shape)[1]
    given = np.round(inclined, 4) if rounded else inclined
    remarks = prepared({"lower": scan._replace(heights=given)}).lower.attrs["remarks"]
    assert "turned until it lies level" in remarks
    assert ("heights are multiples of 100 um" in remarks) == rounded


@pytest.mark.parametrize("together", [True, False])
def test_warnings_of_scans_are_shown_as_they_are_stored(together, tmp_path):
    upper, lower = jc.wall_pair(9.0, (64, 72), SPACING, seed=4, correlation=0.97, roll_off=None)
    files = {"upper": str(tmp_path / "upper.npz"), "lower": str(tmp_path / "lower.npz")}
    for file, wall in zip(files.values(), (upper, lower), strict=True):
        smoothed = scipy.ndimage.uniform_filter(wall, 5)
        np.savez(file, heights=smoothed)
    about = {"units": "m", "spacing": SPACING, "bring_together": together}
    walls = study_of(with_walls()).rocks["slate"].walls._replace(**files, **about)
    grid = study_of({"grid": {"cells_x": 16, "cells_y": 16}}).grid
    shown = []
    found = prepare_walls(
        walls, files, grid, RELATION, True, 2, log=lambda line: None, show=shown.append
    )
    warnings = found.attrs["warnings"].splitlines()
    assert len(warnings) == len(shown) > 0
    for warning, line in zip(warnings, shown, strict=True):
        assert "Warning: " in warning
        assert line == f"{files['lower']}, {files['upper']}: {warning}"


def test_two_files_that_lie_anyhow_are_brought_together_if_asked_to():
    upper, lower = jc.wall_pair(9.0, (64, 72), SPACING, seed=4, correlation=0.97, roll_off=None)
    scans = {
        "upper": Scan(-upper[:, 6:], (SPACING, SPACING), (0.0, 6 * SPACING)),
        "lower": Scan(lower, (SPACING, SPACING)),
    }
    with pytest.raises(jc.InputError, match="bring_together: true"):
        prepared(scans, upper="a.csv", lower="b.csv")
    found = prepared(scans, upper="a.csv", lower="b.csv", bring_together=True)
    assert found.upper.shape == found.lower.shape == (64, 66)
    np.testing.assert_allclose(found.upper, detrended(upper[:, 6:]), atol=1e-9)
    np.testing.assert_allclose(found.lower, detrended(lower[:, 6:]), atol=1e-9)
    assert "found: common_frame" in found.attrs["registration"]


def test_designs_that_draw_walls_of_a_jrc_refuse_measured_ones():
    design = {"tilt_degrees": [0, 0.5], "rotation_degrees": [0], "mismatch_wavelength_mm": [0.75]}
    with pytest.raises(ConfigurationError, match=r"misalignment: not with rocks.slate.walls"):
        study_of(with_walls(), {"misalignment": design})


# Windows of scanned walls in which no cell is missing, and the joints that are cut out there


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
    joint = whole.joint(3, seed=1)
    y, x = whole.origin("measured", 3)
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
