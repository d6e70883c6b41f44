"""What would run practically for ever is refused, or ends by a bound that can be lifted."""

import math
import re
from unittest.mock import patch

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.joint import cycling, feasibility, simulation
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.cycling import closure_limit
from jointclosure.joint.rocks import named_rock
from jointclosure.joint.status import FAILURE, FLAGS
from jointclosure.joint.step_control import LARGEST_STEP
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.mechanics.strength import strength_factor
from jointclosure.solvers import fast
from jointclosure.solvers.fast import BAND
from jointclosure.solvers.joint import Joint
from jointclosure.walls.gridding import Scan
from tests import joints
from tests.joints import SPACING, pair
from tests.processes import ROOT

CELLS, SCALE = 12, 1e5
WITHOUT_GOUGE = jc.Effects(gouge=False)
LARGE = [SCALE * wall for wall in pair(CELLS, 1)]


def closed(walls=None, stress=3e6, scale=1.0, **stated):
    about = {"unusual_values": True, "seating_stress": 0.0, "cycles": 1, "spacing": scale * SPACING}
    return joints.closed(walls or pair(CELLS, 1), stress, **about | stated)


def named_least(refused) -> float:
    return float(str(refused.value).split("at least ")[1].split(" m")[0])


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_walls_far_larger_than_a_displacement_step_are_refused_by_one_that_does(breakage):
    bounds = {"most_steps": 2000, "breakage": breakage}
    refused = r"displacement_step = 1.25e-05 m: .* most_steps = 2000; must be at least \S+ m"
    with pytest.raises(jc.InputError, match=refused) as stated:
        closed(LARGE, scale=SCALE, **bounds)
    parts = {"displacement_step": 1.0, "later_displacement_step": 0.5}
    if breakage == "fixed_step":
        parts |= {"breakage_step": 0.4, "later_breakage_step": 0.2}
    names = tuple(parts)
    step = 1.01 * named_least(stated) * np.array(list(parts.values()))
    with pytest.raises(jc.InputError, match="must be at least"):
        closed(LARGE, scale=SCALE, **bounds, **dict(zip(names, 0.9 * step, strict=True)))
    # not foreseen any more, and a bound of few steps shows that the history has begun
    steps = dict(zip(names, step, strict=True))
    ended = closed(LARGE, scale=SCALE, **bounds, most_breakage_steps=1.0, **steps)
    assert int(ended.status) >= FAILURE


def test_radii_that_crush_all_are_refused_by_the_least_that_will_do():
    refused = "largest_radius = 0.00025 m: .* must be at least"
    with pytest.raises(jc.InputError, match=refused) as stated:
        closed(largest_radius=SPACING, breakage="resolved", strength_bound="none")
    bounds = {"largest_radius": 1.1 * named_least(stated), "strength_bound": "none"}
    found = closed(breakage="resolved", **bounds)
    assert int(found.status) < FAILURE
    # the paper's steps do crush it
    assert int(closed(largest_radius=SPACING).status) < FAILURE


def test_a_stress_that_all_bases_together_do_not_carry_is_refused_by_what_they_do():
    weak = {"rock": joints.DOLERITE._replace(compressive_strength=3e6), "breakage": "resolved"}
    with pytest.raises(jc.InputError, match="strength_bound = 'base'") as said:
        closed(**weak, tolerance=1e-3)
    assert str(said.value).startswith("max_normal_stress (--stress) = 3 MPa: must be less than ")
    most = 1e6 * float(str(said.value).split("less than ")[1].split(" MPa")[0])
    base = 0.5**2 * np.pi * 2.0 / 3.0 * 3e6 / strength_factor(joints.DOLERITE.poisson_ratio)
    assert most == pytest.approx(base, rel=0.01)


BEYOND = {"max_normal_stress": 300e6, "rock": "granite", "numerics": RESOLVED}


@pytest.mark.parametrize(
    "door",
    [
        lambda: jc.simulate(*pair(CELLS), spacing=SPACING, **BEYOND),
        lambda: jc.simulate_ensemble([pair(CELLS)], spacing=SPACING, workers=1, **BEYOND),
        lambda: jc.close("no_file", "no_file", **BEYOND),
        lambda: jc.assess(("no_file", "no_file"), **BEYOND),
        lambda: jc.choose_effects([pair(CELLS)], spacing=SPACING, **BEYOND),
        lambda: jc.fit(_curve(), rock=_weak(), jrc=8.0, shape=(CELLS, CELLS)),
        lambda: jc.validate(_curve(), rock=_weak(), jrc=8.0, shape=(CELLS, CELLS)),
    ],
    ids=["simulate", "simulate_ensemble", "close", "assess", "choose_effects", "fit", "validate"],
)
def test_a_stress_that_no_walls_carry_is_refused_before_files_are_read_or_joints_made(door):
    made = AssertionError("a joint was made")
    refused = r"max_normal_stress \(--stress\) = .* must be less than"
    none_is = patch.object(simulation, "Joint", side_effect=made)
    with none_is, pytest.raises(jc.InputError, match=refused):
        door()


def _weak():
    return named_rock("granite")._replace(compressive_strength=2e6)


def _curve():
    stress = np.linspace(0.0, 5e6, 12)
    return MeasuredCurve(stress, 1e-4 * stress / (stress + 1e6), np.ones(12, int), np.arange(12))


def test_the_stress_of_any_walls_is_never_below_that_of_all_cells_of_a_pair():
    for choices in (jc.Choices(), jc.Choices(strength_bound="none", largest_radius=2 * SPACING)):
        rocks = joints.DOLERITE, joints.DOLERITE
        model = jc.Effects(), choices, RESOLVED
        joint = Joint(*pair(CELLS), SPACING, rocks, *model)
        of_any = feasibility.largest_stress(rocks, *model, SPACING)
        of_pair = feasibility.joint_strength(joint).of_joint
        assert of_pair <= of_any
        assert choices.largest_radius or of_any < 1.1 * of_pair
    # a bound by the base does not depend on the spacing
    model = jc.Effects(), jc.Choices(), RESOLVED
    known = feasibility.largest_stress(rocks, *model, SPACING)
    assert feasibility.largest_stress(rocks, *model) == pytest.approx(known)


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_no_branch_takes_more_displacement_steps_than_the_bound(branch):
    numerics = {"later_displacement_step": 1e-6, "later_breakage_step": 1e-7}
    whole = closed(most_steps=1e4, stress=1e6, **numerics)
    assert int(whole.status) < FAILURE
    here = np.flatnonzero(whole.branch == branch)
    taken = int(whole.settled_states) - (whole.sizes["step"] - 1)  # and thrown away
    most = here[-5] + (taken if branch == "unloading" else 0)
    with patch.object(simulation, "check_feasible", lambda *_: None):
        ended = closed(most_steps=float(most), stress=1e6, **numerics)
    assert FLAGS[int(ended.status)] == "too_many_steps"
    assert int(ended.settled_states) == most + 1
    assert ended.branch.values[-1] == branch
    # a cycle that was not completed has no readings
    for name in ("max_closure", "residual_closure", "unloading_excess"):
        assert np.isnan(ended[name].values).all()


def test_no_history_takes_more_breakage_steps_than_the_bound():
    whole, most = closed(stress=10e6), 2.0
    ended = closed(stress=10e6, most_breakage_steps=most)
    assert int(whole.breakage_steps) > most * CELLS**2
    assert FLAGS[int(ended.status)] == "breakage_not_at_rest"
    assert int(ended.breakage_steps) < int(whole.breakage_steps)
    unbounded = {"most_steps": math.inf, "most_breakage_steps": math.inf}
    assert int(closed(stress=1e5, **unbounded).status) < FAILURE


def test_what_is_refused_can_be_asked_for_by_name():
    bounds = {"most_breakage_steps": 3e6, "most_steps": 20}
    ended = closed(largest_radius=SPACING, breakage="resolved", **bounds)
    assert FLAGS[int(ended.status)] == "too_many_steps"


def test_steps_are_foreseen_for_all_cycles_in_the_longest_steps_of_the_breakage():
    def foreseen(cycles, breakage):
        bounds = {"most_steps": 20, "breakage": breakage, "cycles": cycles}
        with pytest.raises(jc.InputError, match="steps") as stated:
            closed(LARGE, scale=SCALE, **bounds)
        closure, steps = re.search(r"(\S+) m, .*takes? (\S+) steps", str(stated.value)).groups()
        return float(closure), float(steps)

    for breakage, longest in (("fixed_step", 1.0), ("resolved", LARGEST_STEP)):
        for cycles in (1, 3):
            closure, steps = foreseen(cycles, breakage)
            numerics = jc.Numerics()
            expected = closure / (longest * numerics.displacement_step)
            expected += (2 * cycles - 1) * closure / numerics.later_displacement_step
            assert steps == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("tolerance", [1e-3, 0.1])
def test_the_strength_of_all_bases_has_the_band_in_which_contacts_rest(tolerance):
    """A pair may exceed its strength by half the band, its force by that to the power of 3/2."""
    weak = {"rock": joints.DOLERITE._replace(compressive_strength=3e6), "breakage": "resolved"}
    with pytest.raises(jc.InputError, match="strength_bound = 'base'") as said:
        closed(**weak, tolerance=tolerance)
    most = 1e6 * float(str(said.value).split("less than ")[1].split(" MPa")[0])
    base = 0.5**2 * np.pi * 2.0 / 3.0 * 3e6 / strength_factor(joints.DOLERITE.poisson_ratio)
    assert most == pytest.approx(base * (1.0 + 0.5 * BAND * tolerance) ** 1.5, rel=0.003)


def test_no_joint_closes_beyond_the_closure_that_counts_as_not_reached():
    """Neither flat walls, which close by their indentation alone, nor those that break away."""
    flat, rough, vanishing = 2 * [np.zeros((CELLS, CELLS))], pair(CELLS, 1), jc.Effects(gouge=False)
    for walls, stress, effects in (
        (flat, 1e6, jc.Effects()),
        (flat, 50e6, jc.Effects()),
        (rough, 50e6, jc.Effects()),
        (rough, 1e6, vanishing),
    ):
        found = closed(walls, stress, effects=effects)
        assert int(found.status) < FAILURE
        rocks = joints.DOLERITE, joints.DOLERITE
        joint = Joint(*walls, SPACING, rocks, effects, jc.Choices(), jc.Numerics())
        limit = closure_limit(joint, stress * SPACING**2 * CELLS**2)
        assert float(found.closure.max()) < limit


def test_breakage_that_does_not_come_to_rest_in_many_rounds_is_a_failure(monkeypatch):
    assert int(closed(stress=10e6).status) < FAILURE
    monkeypatch.setattr(fast, "MOST_ROUNDS", 2)
    assert FLAGS[int(closed(stress=10e6).status)] == "breakage_not_at_rest"


@pytest.mark.parametrize("bounds", [{}, {"breakage": "resolved"}, {"effects": WITHOUT_GOUGE}])
def test_walls_whose_peaks_must_all_be_crushed_are_refused_before_the_first_step(bounds):
    """Elastically the highest cell alone carries the stress; at its strength it takes many."""
    scale = 2.0 / float(np.ptp(np.add(*pair(CELLS, 1))))
    relief = [scale * wall for wall in pair(CELLS, 1)]
    began = patch.object(cycling, "run_cycles", side_effect=AssertionError("a step was taken"))
    with began, pytest.raises(jc.InputError, match=r"a closure of .* m, without") as refused:
        closed(relief, most_steps=500, **bounds)
    foreseen = float(str(refused.value).split("a closure of ")[1].split(" m")[0])
    assert 0.01 < foreseen < 2.0


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_the_closure_that_is_foreseen_is_reached(breakage):
    scale = 0.02 / float(np.ptp(np.add(*pair(CELLS, 1))))
    relief = [scale * wall for wall in pair(CELLS, 1)]
    with pytest.raises(jc.InputError) as refused:
        closed(relief, breakage=breakage, most_steps=1)
    foreseen = float(str(refused.value).split("a closure of ")[1].split(" m")[0])
    assert foreseen < float(closed(relief, breakage=breakage).closure.max()) < 10.0 * foreseen


@pytest.mark.parametrize(
    ("stated", "refused"),
    [
        ({"cycles": 10**9}, "cycles = 1000000000: must be at most 10000"),
        ({"stress": [1e6, 0.0] * 10_001, "cycles": None}, "has 20002 stresses"),
        (
            {"cycles": 10_000, "effects": joints.ELASTIC, "curve_points": 100_000},
            "curve_points = 100000: with 10000 cycles",
        ),
    ],
)
def test_histories_that_never_end_are_refused(stated, refused):
    with pytest.raises(jc.InputError, match=refused):
        closed(**stated)


@pytest.mark.parametrize("history", [[5e6, 4.996e6, 5e6], [5e6, 0.0, 6e6, 4.995e6, 5e6]])
def test_a_minimum_that_a_maximum_beside_it_hardly_exceeds_is_refused(history):
    """Both are met within the tolerance: no loading would lie between them."""
    with pytest.raises(jc.InputError, match=r"too close to a maximum beside it, 5 MPa"):
        closed(stress=history, cycles=None)
    elastic = closed(stress=history, cycles=None, effects=joints.ELASTIC)
    assert (elastic.max_closure > 0.0).all()


def test_a_cycle_whose_loading_breakage_jumps_over_at_once_has_a_closure_of_zero():
    """The last state below the maximum is then the one at its start."""
    load, loads = cycling._load, []

    def load_first_only(*arguments):
        loads.append(arguments)
        return load(*arguments) if len(loads) == 1 else None

    with patch.object(cycling, "_load", load_first_only):
        joint = closed(stress=2e6, cycles=2, replay=False)
    assert len(loads) == 2
    assert joint.max_closure.values[0] > 0.0
    assert joint.max_closure.values[1] == 0.0
    assert np.isfinite(joint.residual_closure).all()


NEAR = {"spacing": SPACING, "rock": joints.DOLERITE, "numerics": jc.Numerics(breakage="resolved")}


@pytest.mark.parametrize("door", ["simulate", "close"])
def test_a_stress_near_that_of_all_cells_is_warned_of_before_the_simulation(door, monkeypatch):
    monkeypatch.setattr(simulation.Simulation, "run", None)
    walls = pair(24)
    if door == "close":
        above = 3.0 * np.abs(walls[0]).max()
        walls = [
            Scan(wall, (SPACING, SPACING), (0.0, 0.0)) for wall in (above - walls[0], walls[1])
        ]
    about = {"single": True, "orientation": "common_frame"} if door == "close" else {}
    with pytest.raises(UserWarning, match=r"= 120 MPa is 89 % of the stress that all cells"):
        getattr(jc, door)(*walls, max_normal_stress=120e6, **NEAR | about)


def test_the_warning_near_the_strength_has_the_times_of_the_stored_table():
    table = pd.read_csv(ROOT / "benchmarks/results/near_strength/near_strength.csv").dropna()
    usual = table[table.time_ratio == 1.0]
    assert usual.share_of_all_cells.mean() == pytest.approx(simulation._USUAL_SHARE, abs=0.005)
    near = table[table.share_of_all_cells >= simulation.NEAR_STRENGTH]
    for least, times in near.groupby(
        (near.share_of_all_cells >= 0.9).map({False: 0.75, True: 0.9})
    ):
        ends = times.time_ratio.round().agg(["min", "max"])
        assert tuple(ends) == simulation._TIMES_OF_USUAL[least]


def test_the_strengths_of_cells_are_computed_once_for_the_check_and_the_warning(monkeypatch):
    computed = []
    strength = simulation.joint_strength
    monkeypatch.setattr(
        simulation, "joint_strength", lambda *joint: computed.append(1) or strength(*joint)
    )
    conditions = jc.Conditions(max_normal_stress=120e6, **NEAR).checked()
    assert simulation.Simulation(*pair(12), conditions).near_strength()
    assert len(computed) == 1


def test_the_warning_near_the_strength_is_of_fixed_steps_too():
    conditions = jc.Conditions(max_normal_stress=150e6, **NEAR | {"numerics": jc.Numerics()})
    (warning,) = simulation.Simulation(*pair(12), conditions.checked()).near_strength()
    assert "is 111 % of the stress that all cells together carry" in warning
    assert "many times as long as at lower stresses" in warning


def test_a_simulation_runs_once():
    conditions = jc.Conditions(max_normal_stress=1e6, cycles=1, **NEAR).checked()
    once = simulation.Simulation(*pair(12), conditions)
    once.run()
    with pytest.raises(RuntimeError, match="runs once"):
        once.run()


@pytest.mark.parametrize(("stress", "said"), [(120e6, "5 to 18 times"), (133e6, "12 to 34 times")])
def test_the_warning_near_the_strength_says_how_much_longer_it_takes(stress, said):
    conditions = jc.Conditions(max_normal_stress=stress, **NEAR).checked()
    (warning,) = simulation.Simulation(*pair(12), conditions).near_strength()
    assert f"may take roughly {said} as long as at 24 % of it" in warning


@pytest.mark.parametrize(
    ("stress", "change"),
    [(90e6, {}), (90e6, {"numerics": jc.Numerics()}), (120e6, {"effects": joints.ELASTIC}),
     (120e6, {"choices": jc.Choices(strength_bound="none")})],
)  # fmt: skip
def test_other_stresses_are_not_said_to_be_slow(stress, change):
    conditions = jc.Conditions(max_normal_stress=stress, **NEAR | change).checked()
    assert simulation.Simulation(*pair(12), conditions).near_strength() == []
