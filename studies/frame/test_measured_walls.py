"""Scanned walls in a study: what its configuration may say, and the joints that are cut."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engine.settings import Grid
from jointclosure.walls.measured import Scan
from jointclosure.walls.roughness import detrended
from studies.frame.cases import cases_of, surface_settings
from studies.frame.files import ConfigurationError
from studies.frame.rocks import check_files
from studies.frame.walls import (
    Cutter,
    cut_walls,
    prepared_walls,
)
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
    cases = cases_of(study_of(with_walls()))
    assert [case.parameter for case in cases] == [
        "base", *["poisson_ratio"] * 2, *["youngs_modulus"] * 2, *["compressive_strength"] * 2,
    ]  # fmt: skip
    assert all(np.isnan(case.jrc) for case in cases)
    common = cases_of(study_of(with_walls(), {"study": {"draws": "common"}}))
    assert {case.surface for case in common} == {"slate-base"}
    assert len({case.surface for case in cases}) == len(cases)


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


def test_heights_that_point_into_the_rock_are_turned(scan):
    walls = prepared({"upper": scan, "lower": scan}, upper="a.npz", inverted=["upper"])
    np.testing.assert_array_equal(walls.upper.values, -walls.lower.values)
    # a wall over itself in one frame is mated: no part of it touches first
    joint = Cutter(walls, (20, 20), 1).joint(0, 0)
    np.testing.assert_allclose(joint["upper"] + joint["lower"], 0.0, atol=1e-18)


def test_walls_of_a_later_block_are_those_of_the_whole(scan):
    walls, study = prepared({"lower": scan}), study_of(with_walls())
    assert Cutter(walls, (20, 24), 5).room()["windows_side_by_side"] == 4
    surfaces = surface_settings(
        study._replace(rocks={"slate": study.rocks["slate"]._replace(walls=None)}),
        cases_of(study)[0], range(3),
    )._replace(grid=Grid(24, 20, SPACING))  # fmt: skip
    pairs = list(cut_walls(walls, surfaces))
    later = cut_walls(walls, surfaces._replace(first_realization=1, realizations=2))
    for pair, again in zip(pairs[1:], later, strict=True):
        np.testing.assert_array_equal(pair, again)
    assert not np.array_equal(pairs[0], pairs[1])


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
