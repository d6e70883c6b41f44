"""Effects that are selected for the cases of a study, with walls of a JRC or scanned ones."""

import json

import pytest

import jointclosure as jc
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.walls.gridding import Scan
from studies.frame import closing as closing
from studies.frame.closing import Ensemble, choose_for_rock, close_block
from studies.frame.walls import prepared_walls
from tests.joints import SPACING
from tests.studied import study_of

pytestmark = pytest.mark.usefixtures("times_by_effects")
SMALL = {
    "study": {"rocks": ["slate"], "realizations": 4, "pool": None},
    "grid": {"cells_x": 16, "cells_y": 16},
}
SCANNED = {"jrc": None, "levels": {"jrc": None}, "walls": {"lower": "scan.npz", "upper": "rotated"}}


@pytest.fixture(autouse=True)
def scan(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scan.npz").write_bytes(b"")  # whose digest is a setting; walls are made below


def settings_to(tolerance, **rock):
    rock = rock | {"max_normal_stress_MPa": 1}
    study = study_of(SMALL, {"effects": {"auto": tolerance}, "rocks": {"slate": rock}})
    ensemble = Ensemble(study)
    return {label: ensemble.settings(label, range(4)) for label in ensemble.cases}


def test_the_cases_of_a_rock_share_the_decision_of_the_largest_stress_over_strength():
    settings = settings_to(0.02)
    assert len(settings) > 5
    pilot = choose_for_rock(settings)
    choice, examined = json.loads(pilot.attrs["chosen"]), pilot.attrs["case"]
    assert jc.Effects(**choice["effects"]) == jc.Effects()
    ratios = {
        label: one.conditions.max_normal_stress / one.conditions.rock.compressive_strength
        for label, one in settings.items()
    }
    assert ratios[examined] == max(ratios.values())
    choice = json.loads(choose_for_rock(settings_to(0.99)).attrs["chosen"])
    assert jc.Effects(**choice["effects"]) != jc.Effects()
    details = choice["cases"][examined]
    assert 0.0 < choice["error"] == details["error"]
    assert {row["quantity"] for row in details["changes"]} >= {"stiffness_net", "max_closure"}


@pytest.mark.parametrize("rock", [{}, SCANNED], ids=["jrc", "scanned"])
@pytest.mark.parametrize("tolerance", [1e-6, 0.95])
def test_joints_of_a_pilot_are_taken_bit_by_bit_and_not_closed_again(
    monkeypatch, tmp_path, tolerance, rock
):
    (label, settings), *_ = settings_to(tolerance, **rock).items()
    walls = None
    if rock:
        scan = Scan(jc.wall_pair(9.0, (40, 50), SPACING, 3, roll_off=None)[0], (SPACING, SPACING))
        keys = settings.walls._replace(units="mm")
        prepared = prepared_walls({"lower": scan}, keys, SPACING, "yu_vayssade_linear_0.25mm")
        walls = tmp_path / "slate.nc"
        write_netcdf(prepared, walls)
    before = choose_for_rock({label: settings}, walls=walls)
    choice = json.loads(before.attrs["chosen"])
    effects = jc.Effects(**choice["effects"])
    assert (effects == jc.Effects()) is (tolerance < 0.5)
    used, pilot = settings.under(effects=effects), tmp_path / "pilot.nc"
    write_netcdf(before, pilot)
    plain = close_block(used, report=lambda line: None, walls=walls)
    closed, close = [], closing.close_joint
    monkeypatch.setattr(closing, "close_joint", lambda *given: closed.append(1) or close(*given))
    taken = close_block(used, report=lambda line: None, walls=walls, pilot=pilot)
    assert len(closed) == 4 - before.sizes["realization"]
    times = "timing_simulation"
    assert taken.drop_vars(times).identical(plain.drop_vars(times))
