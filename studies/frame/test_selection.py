"""Effects that are selected for the cases of a study, with walls of a JRC or scanned ones."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.ensembles.quantities import names_of_case
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.walls.gridding import Scan
from studies.frame import simulation
from studies.frame.cases import cases_of
from studies.frame.experiments import case_point
from studies.frame.pilots import choose_rock_effects, examined
from studies.frame.scanned_walls import cut_walls, prepared_walls
from studies.frame.settings import walls_of
from studies.frame.simulation import close_joints, under_chosen
from tests.joints import SPACING
from tests.studied import study_of

pytestmark = pytest.mark.usefixtures("times_by_effects")
SMALL = {
    "study": {"rocks": ["slate"], "realizations": 4, "pool": None},
    "grid": {"cells_x": 16, "cells_y": 16},
}
SCANNED = {"jrc": None, "levels": {"jrc": None}, "walls": {"lower": "scan.npz", "upper": "rotated"}}
NAMES = names_of_case(flow=False)
TIMES = "timing_simulation"


@pytest.fixture(autouse=True)
def scan(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scan.npz").write_bytes(b"")  # whose digest is a setting; walls are made below


def points_to(tolerance, draws="independent", **rock):
    """Return points of all cases of a rock, by label; effects are chosen to a tolerance."""
    rock = rock | {"max_normal_stress_MPa": 1}
    changes = {"effects": {"auto": tolerance}, "rocks": {"slate": rock}, "study": {"draws": draws}}
    study = study_of(SMALL, changes)
    return {case.label: case_point(study, case, range(4)) for case in cases_of(study)}


def chosen_to(tolerance, **changes):
    """Return the dataset of chosen effects of a rock, and the points of its cases."""
    points = points_to(tolerance, **changes)
    choice = examined(points)
    return choose_rock_effects(choice, walls_of(choice.point.settings), NAMES), points


def test_the_cases_of_a_rock_share_the_decision_of_the_largest_stress_over_strength():
    pilot, points = chosen_to(0.02)
    assert len(points) > 5
    choice = json.loads(pilot.attrs["chosen"])
    label = pilot.attrs["case"]
    assert jc.Effects(**choice["effects"]) == jc.Effects()
    conditions = {label: point.settings.conditions for label, point in points.items()}
    ratios = {
        label: one.largest_stress / one.rock[0].compressive_strength
        for label, one in conditions.items()
    }
    assert ratios[label] == max(ratios.values())
    choice = json.loads(chosen_to(0.99)[0].attrs["chosen"])
    assert jc.Effects(**choice["effects"]) != jc.Effects()
    details = choice["cases"][label]
    assert 0.0 < choice["error"] == details["error"]
    assert {row["quantity"] for row in details["changes"]} >= {"stiffness_net", "max_closure"}


def test_joints_of_a_pilot_are_taken_for_its_case_only():
    """With common draws the other cases of a rock have the same seeds."""
    pilot, points = chosen_to(0.99, draws="common")
    effects = jc.Effects(**json.loads(pilot.attrs["chosen"])["effects"])
    for label, point in points.items():
        under, closed = under_chosen(point, pilot)
        assert under.settings.conditions.effects == effects
        taken = pilot.seed.values.tolist() if label == pilot.attrs["case"] else []
        assert list(closed) == taken


@pytest.mark.parametrize("rock", [{}, SCANNED], ids=["jrc", "scanned"])
@pytest.mark.parametrize("tolerance", [1e-6, 0.95])
def test_joints_of_a_pilot_are_taken_instead_of_closed_again(
    monkeypatch, tmp_path, tolerance, rock
):
    (label, point), *_ = points_to(tolerance, **rock).items()
    walls = list(cut_scan(point.settings) if rock else walls_of(point.settings))
    write_netcdf(choose_rock_effects(examined({label: point}), walls, NAMES), tmp_path / "pilot.nc")
    pilot = read_netcdf(tmp_path / "pilot.nc")
    under, known = under_chosen(point, pilot)
    assert (under.settings.conditions.effects == jc.Effects()) is (tolerance < 0.5)
    plain = close_joints(under, walls, NAMES)
    closed = []
    close = simulation.simulate_row
    monkeypatch.setattr(
        simulation, "simulate_row", lambda *given: closed.append(1) or close(*given)
    )
    taken = close_joints(under, walls, NAMES, closed=known)
    assert len(closed) == 4 - pilot.sizes["joint"] < 4
    assert taken.drop_vars(TIMES).identical(plain.drop_vars(TIMES))


def cut_scan(settings):
    """Generate the walls of a point, cut out of a scan."""
    scan = Scan(jc.wall_pair(9.0, (40, 50), SPACING, 3, roll_off=None)[0], (SPACING, SPACING))
    keys = settings.walls._replace(units="mm")
    prepared = prepared_walls({"lower": scan}, keys, SPACING, "yu_vayssade_linear_0.25mm")
    return (np.array(pair) for pair in cut_walls(prepared, settings))
