"""Loads and conditions: the same words for every function that closes joints."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.conditions import SEATING_STRESS, LoadCycle, load_cycles
from jointclosure.joint.rocks import ROCKS
from jointclosure.walls.measured import Scan
from tests import joints
from tests.joints import ELASTIC, SPACING, pair
from tests.studied import study_of

SCENES = {"all": jc.Effects(), "elastic": ELASTIC}
TURNS = [3e6, 1e6, 6e6, 2e6, 6e6, 2e6, 4e6]
TOLERANCE = jc.Numerics().stress_tolerance


def closed(effects=SCENES["all"], stress=6e6, **load):
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=1)
    return joints.closed(walls, stress, effects=effects, **load)


@pytest.fixture(scope="module", params=SCENES)
def scene(request):
    return SCENES[request.param]


@pytest.fixture(scope="module")
def history(scene):
    # whose force does not jump where its load turns
    return closed(scene, TURNS, seating_stress=0.5e6, strength_bound="none")


def along(history, number, branch):
    here = (history.load_cycle.values == number) & (history.branch.values == branch)
    return history.normal_stress.values[here]


def test_equal_cycles_to_last_contact_are_bit_for_bit_those_of_one_maximum(scene):
    xr.testing.assert_identical(
        closed(scene, stress=6e6, cycles=3), closed(scene, stress=[6e6, 0, 6e6, 0, 6e6])
    )


def test_the_load_turns_where_it_was_told_to(history):
    assert int(history.status) == 0
    turns = [*TURNS, 0.0]
    for number in range(1, 5):
        maximum, minimum = turns[2 * number - 2 : 2 * number]
        up, down = (along(history, number, branch) for branch in ("loading", "unloading"))
        assert up[-1] == pytest.approx(maximum, rel=TOLERANCE)
        assert down[-1] == pytest.approx(minimum, rel=TOLERANCE)
        assert (down[:-1] > minimum).all()
        assert (up <= maximum * (1.0 + TOLERANCE)).all()


def test_a_cycle_counts_from_where_its_own_loading_starts(history):
    ends = [
        float(history.closure.values[history.load_cycle.values == number][-1])
        for number in range(1, 5)
    ]
    np.testing.assert_array_equal(history.residual_closure.values, ends)
    assert history.max_closure.values[1] < history.max_closure.values[0]
    seated = history.max_closure_seated.values
    assert np.isfinite(seated[0])
    assert np.isnan(seated[1:]).all()  # they start above the seating stress


def test_breakage_remembers_the_largest_stress_only_through_the_walls():
    low_first = closed(stress=[3e6, 0, 6e6])
    at_once = closed(stress=6e6, cycles=1)
    ratio = low_first.residual_closure.values[1] / at_once.residual_closure.values[0]
    assert ratio == pytest.approx(1.0, abs=0.1)
    assert low_first.residual_closure.values[0] < low_first.residual_closure.values[1]


@pytest.mark.parametrize(
    ("load", "cycles", "printed"),
    [
        ([], None, "needs a maximum"),
        ([5e6, 6e6], None, "minimum 6e+06 must be"),
        ([5e6, -1e6], None, "minimum -1e+06 must be"),
        ([0.0, 0.0], None, "must be positive and finite"),
        (True, None, "must be a number"),
        ([5e6, 1e6, 6e6], 3, "cycles = 3"),
    ],
)
def test_a_load_that_cannot_be_is_refused_in_a_line(load, cycles, printed):
    with pytest.raises(jc.InputError) as refused:
        load_cycles(load, cycles)
    assert printed in str(refused.value)
    assert "\n" not in str(refused.value)
    assert load_cycles([5e6, 1e6, 6e6], 2) == (LoadCycle(5e6, 1e6), LoadCycle(6e6, 0.0))
    assert load_cycles(5e6) == (LoadCycle(5e6, 0.0),) * 2


ONCE = {"effects": ELASTIC, "cycles": 1}


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
    closed = DOORS[door](*walls, rock="granite", max_normal_stress=27e3, **ONCE)
    assert first_closure(closed) > 0.0
    assert float(np.ravel(closed.max_closure_seated)[0]) > 0.0


@pytest.mark.parametrize("door", DOORS)
def test_a_rock_is_given_by_its_name_or_its_properties(door, walls):
    granite = ROCKS["granite"].intact
    closures = [
        first_closure(DOORS[door](*walls, rock=rock, max_normal_stress=2e6, **ONCE))
        for rock in ("granite", granite, ("Granite", granite))
    ]
    assert closures == [closures[0]] * 3
    for rock in ("marble", None, 3):
        message = f"rock = {rock!r}: must be a Rock or one of dolerite"
        with pytest.raises(jc.InputError, match=message):
            DOORS[door](*walls, rock=rock, max_normal_stress=2e6)


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
