"""Histories of loads: where their branches end, and what they do to a joint."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.conditions import as_stated
from jointclosure.joint.history import history_of
from jointclosure.joint.load import SEATING_STRESS, stated_load
from jointclosure.joint.rocks import ROCKS
from jointclosure.joint.status import LARGEST_UNBREAKABLE_SHARE, OUTSIDE_MODEL_RANGE, TARGET_JUMPED
from tests import joints
from tests.joints import COARSE, ELASTIC, SPACING, pair
from tests.studied import study_of

SCENES = {"all": jc.Effects(), "elastic": ELASTIC}
TURNS = [3e6, 1e6, 6e6, 2e6, 6e6, 2e6, 4e6]


def closed(effects=SCENES["all"], stress=6e6, **load):
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=1)
    return joints.closed(walls, stress, effects=effects, **load)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_equal_cycles_to_last_contact_are_bit_for_bit_those_of_one_maximum(scene):
    xr.testing.assert_identical(
        closed(scene, stress=6e6, cycles=3), closed(scene, stress=[6e6, 0, 6e6, 0, 6e6])
    )


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_cycle_counts_from_where_its_own_loading_starts(scene):
    # whose force does not jump where its load turns
    history = closed(scene, TURNS, seating_stress=0.5e6, strength_bound="none")
    ends = [
        float(history.closure.values[history.load_cycle.values == number][-1])
        for number in range(1, 5)
    ]
    np.testing.assert_array_equal(history.residual_closure.values, ends)
    assert history.max_closure.values[1] < history.max_closure.values[0]
    seated = history.max_closure_seated.values
    assert np.isfinite(seated[0])
    assert np.isnan(seated[1:]).all()  # they start above the seating stress


WAYS = {
    "fixed steps": {},
    "resolved": {"numerics": COARSE},
    "interpolated": {"target": "interpolate"},
    "elastic": {"effects": ELASTIC},
}


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("way", WAYS)
def test_every_branch_ends_where_the_load_turns(way, seed):
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed)
    history = joints.closed(walls, TURNS, seating_stress=0.5e6, **WAYS[way])
    within = 1e-12 if way in ("interpolated", "elastic") else jc.Numerics().stress_tolerance
    short = []
    for cycle, (maximum, minimum) in enumerate(np.reshape([*TURNS, 0.0], (-1, 2)), start=1):
        up, down = (
            history.normal_stress.values[history_of(history).branch(cycle, name).steps]
            for name in ("loading", "unloading")
        )
        assert (up <= maximum * (1.0 + within)).all()
        assert (down[:-1] > minimum).all()
        assert down[-1] == pytest.approx(minimum, rel=within)
        short.append(up[-1] < maximum * (1.0 - within))
    assert any(short) == bool(int(history.status) & TARGET_JUMPED)


def test_a_joint_is_out_of_range_with_over_a_tenth_on_unbreakable_contacts():
    flagged = []
    for seed, stress in ((2, 8e6), (4, 4e6), (6, 8e6), (9, 8e6)):
        history = joints.closed(pair(24, seed), stress, strength_bound="none")
        share = float((history.locked_share + history.flat_share).max())
        assert 0.08 < share < 0.12  # near the limit, on both sides of it
        flagged.append(bool(int(history.status) & OUTSIDE_MODEL_RANGE))
        assert flagged[-1] == (share > LARGEST_UNBREAKABLE_SHARE == 0.1)
    assert len(set(flagged)) == 2


def test_breakage_remembers_the_largest_stress_only_through_the_walls():
    low_first = closed(stress=[3e6, 0, 6e6])
    at_once = closed(stress=6e6, cycles=1)
    ratio = low_first.residual_closure.values[1] / at_once.residual_closure.values[0]
    assert ratio == pytest.approx(1.0, abs=0.1)
    assert low_first.residual_closure.values[0] < low_first.residual_closure.values[1]


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
    assert checked == as_stated(checked).checked()


@pytest.mark.parametrize(
    ("stresses", "words"),
    [
        (8e6, "8 MPa, 2 cycles"),
        ((8e6, 5e6), "8, 5 MPa, 1 cycle (up to 8 and down to 5 MPa; 8.5 MPa has a decimal point)"),
        ((5e6, 0.0, 20e6), "5, 0, 20 MPa, 2 cycles"),
    ],
)
def test_the_load_in_words_shows_a_decimal_comma(stresses, words):
    assert stated_load(stresses).description() == words
