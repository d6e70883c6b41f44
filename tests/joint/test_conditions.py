"""Conditions of a closure: the same words for every function that closes joints."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.joint.conditions import SEATING_STRESS
from jointclosure.joint.rocks import ROCKS
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls.measured import Scan
from tests import joints
from tests.joints import SPACING, pair
from tests.measured.test_calibration import GOOD
from tests.studied import study_of

ELASTIC = {"effects": joints.ELASTIC, "cycles": 1}


@pytest.fixture
def walls():
    """A joint that is long enough for scans."""
    return pair(24)


def scanned(upper, lower, **conditions):
    scans = (Scan(wall, (SPACING, SPACING), (0.0, 0.0)) for wall in (1e-3 - upper, lower))
    return jc.close(*scans, single=True, orientation="common_frame", **conditions).history


DOORS = {
    "simulate": lambda *walls, **given: jc.simulate(*walls, spacing=SPACING, **given),
    "simulate_ensemble": lambda *walls, **given: jc.simulate_ensemble(
        [walls], spacing=SPACING, workers=1, **given
    ),
    "choose_effects": lambda *walls, **given: (
        jc.choose_effects([walls], spacing=SPACING, **given).closed[0].dataset
    ),
    "close": scanned,
}


def first_closure(closed):
    return float(np.ravel(closed.max_closure)[0])


@pytest.mark.parametrize("door", DOORS)
def test_a_joint_is_closed_below_the_usual_seating_stress(door, walls):
    closed = DOORS[door](*walls, rock="granite", max_normal_stress=27e3, **ELASTIC)
    assert first_closure(closed) > 0.0
    if door != "choose_effects":  # which counts from first touch
        assert float(np.ravel(closed.max_closure_seated)[0]) > 0.0


@pytest.mark.parametrize("door", DOORS)
def test_a_rock_is_given_by_its_name_or_its_properties(door, walls):
    granite = ROCKS["granite"].intact
    closures = [
        first_closure(DOORS[door](*walls, rock=rock, max_normal_stress=2e6, **ELASTIC))
        for rock in ("granite", granite, ("Granite", granite))
    ]
    assert closures == [closures[0]] * 3
    for rock in ("marble", None, 3):
        message = f"rock = {rock!r}: must be a Rock or one of dolerite"
        with pytest.raises(jc.InputError, match=message):
            DOORS[door](*walls, rock=rock, max_normal_stress=2e6)


def test_functions_of_one_state_take_the_name_of_a_rock_too(walls):
    given = {"spacing": SPACING, "closure": 1e-5}
    named, stated = (
        jc.equilibrium(*walls, rock=rock, **given) for rock in ("granite", ROCKS["granite"].intact)
    )
    assert named.identical(stated)


def test_the_rocks_of_the_paper_are_those_of_the_default_study():
    study = study_of()
    assert study.rocks.keys() == ROCKS.keys() - {"granite"}
    for name, rock in study.rocks.items():
        assert ROCKS[name] == (rock.title, rock.intact, rock.jrc, rock.max_normal_stress)


@pytest.mark.parametrize(
    ("load", "seating"),
    [(27e3, 2.7e3), (0.55e6, 5.5e4), (0.56e6, SEATING_STRESS), ((5e6, 0.0, 1e5), 1e4), (30e6, 5e5)],
)
def test_seating_that_is_not_stated_lies_below_every_maximum(load, seating):
    checked = jc.Conditions(SPACING, "granite", load).checked()
    assert checked.seating_stress == pytest.approx(seating, rel=1e-15)
    assert checked == checked.checked()


def test_a_command_and_fit_take_a_load_below_the_usual_seating_stress(tmp_path):
    words = ["simulate", "--rock", "granite", "--jrc", "8", "--cells", "12", "--stress", "0.027"]
    assert cli.main([*words, "--output", str(tmp_path / "joint.nc")]) == 0
    assert read_netcdf(tmp_path / "joint.nc").attrs["seating_stress_Pa"] == pytest.approx(2.7e3)
    curve = tmp_path / "kPa.csv"
    curve.write_text(GOOD.replace("stress_MPa", "stress_kPa"))
    about = {"rock": "granite", "jrc": 10, "shape": (10, 10), "surfaces": 4}
    fitted = jc.fit(curve, **about, effects=joints.ELASTIC)
    assert fitted.measured.seating == pytest.approx(500.0)
