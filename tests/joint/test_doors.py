"""Every function that closes joints takes the same conditions, and refuses the same ones."""

import functools
import warnings

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.rocks import ROCKS
from jointclosure.walls.gridding import Scan
from studies.frame.rocks import ScannedWalls
from studies.frame.walls import prepared_walls
from tests.joints import DOLERITE, ELASTIC, SPACING, pair
from tests.measured.test_calibration import GOOD


def scans_of(upper, lower, spacing):
    """Scans in one frame, z upwards, of which the upper one lies above the other."""
    above = 3.0 * np.abs(upper).max()
    return [Scan(wall, (spacing, spacing), (0.0, 0.0)) for wall in (above - upper, lower)]


def close(upper, lower, spacing=SPACING, **given):
    about = {"single": True, "orientation": "common_frame"}
    return jc.close(*scans_of(upper, lower, spacing), **about, **given).history


def choose(*walls, **given):
    return jc.choose_effects([walls], **given).closed[0].closed


CLOSE = {
    "simulate": jc.simulate,
    "simulate_ensemble": lambda *walls, **given: jc.simulate_ensemble([walls], workers=1, **given),
    "choose_effects": choose,
    "close": close,
}
"""Functions of two walls and conditions that close a joint."""
ONCE = {"spacing": SPACING, "effects": ELASTIC, "cycles": 1}


def first_closure(door, **given):
    return float(np.ravel(CLOSE[door](*pair(24), **ONCE | given).max_closure)[0])


@pytest.mark.parametrize("door", CLOSE)
def test_a_rock_is_given_by_its_name_or_its_properties(door):
    # also below the usual seating stress
    assert first_closure(door, rock="granite", max_normal_stress=27e3) > 0.0
    granite = ROCKS["granite"].intact
    given = ("granite", granite, ("Granite", granite))
    assert len({first_closure(door, rock=rock, max_normal_stress=2e6) for rock in given}) == 1
    for rock in ("marble", None, 3):
        message = f"rock = {rock!r}: must be a Rock or one of dolerite"
        with pytest.raises(jc.InputError, match=message):
            first_closure(door, rock=rock, max_normal_stress=2e6)


def as_scans_of_a_study(upper, lower, spacing, **_):
    about = ScannedWalls(upper="top", lower="bottom", units="mm")
    scans = dict(zip(("upper", "lower"), scans_of(upper, lower, spacing), strict=True))
    return prepared_walls(scans, about, spacing, "yu_vayssade_linear_0.25mm")


DOORS = CLOSE | {
    "equilibrium": lambda *walls, max_normal_stress, **given: jc.equilibrium(
        *walls, closure=1e-6, **given
    ),
    "study": as_scans_of_a_study,
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("what", ["heights", "spacing"])
@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_a_unit_a_thousand_times_off_is_refused_or_warned_of(door, what, factor):
    walls = np.array(jc.wall_pair(8.0, (32, 32), SPACING, 7, correlation=0.9))
    walls = walls * (factor if what == "heights" else 1.0)
    spacing = SPACING * (factor if what == "spacing" else 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # so that nothing is computed
        with pytest.raises((jc.InputError, UserWarning)):
            DOORS[door](*walls, spacing=spacing, rock=DOLERITE, max_normal_stress=1e6)


REFUSED = [
    ({"numerics": jc.Numerics()._replace(idle_interaction=2)}, "idle_interaction = 2"),
    ({"effects": jc.Effects(substrate=False)}, "substrate = False needs interaction = False"),
    ({"seating_stress": 9e6}, "seating_stress"),
    ({"rock": jc.Rock(55.0, 0.2, 165e6)}, "youngs_modulus = 55.0 Pa: not usual"),
    ({"spacing": 0.25}, "spacing = 0.25 m: not usual"),
    ({"max_normal_stress": 5}, "is 5 MPa meant, 5e+06 Pa?"),
    ({"max_normal_stress": 5e12}, "is 5e+06 Pa meant?"),
    ({"max_normal_stress": [5e6, 0.0, 8]}, "max_normal_stress = 8 Pa: not usual"),
    ({"seating_stress": 0.5}, "seating_stress = 0.5 Pa: not usual"),
    ({"numerics": jc.Numerics(displacement_step=12.5)}, "displacement_step = 12.5 m: not"),
    ({"choices": jc.Choices(largest_radius=20.0)}, "largest_radius = 20.0 m: not usual"),
]
OTHERWISE = {"close": "spacing", "fit": "max_normal_stress"}
"""Conditions that a function reads of its scans, or of its curve."""


def fitted(*walls, curve, max_normal_stress, seating_stress, **given):
    seating = seating_stress or 0.2e6
    return jc.fit(curve, jrc=8.0, shape=(8, 8), seating_stress=seating, **given)


@pytest.mark.parametrize("door", [*CLOSE, "fit"])
def test_conditions_that_cannot_be_are_refused_before_a_joint_is_closed(
    door, tmp_path, monkeypatch
):
    monkeypatch.setattr("jointclosure.joint.protocol.run_cycles", None)
    curve = tmp_path / "lab.csv"
    curve.write_text(GOOD)
    doors = CLOSE | {"fit": functools.partial(fitted, curve=curve)}
    usual = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "seating_stress": 0.0}
    for change, printed in REFUSED:
        stated = usual | change
        if OTHERWISE.get(door) in change:
            continue
        with pytest.raises(jc.InputError) as refused:
            doors[door](*pair(6), **stated)
        assert printed in str(refused.value), change
