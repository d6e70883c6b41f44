"""What is read of each cycle is what engineers are told of the same joint."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure import oracle
from jointclosure.ensembles.oracle_limits import largest_ratio, limits_of, tolerances_of
from jointclosure.ensembles.quantities import COLUMNS, HEADINGS, QUANTITIES
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.cycle_results import largest_jump
from jointclosure.joint.history import history_of
from jointclosure.joint.result_tables import cycle_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.parameters import Choices, Effects, Numerics
from jointclosure.solvers.fast import BAND
from studies.frame.joint_tables import mean_shown

LARGEST, HALF = 20e6, 10e6
SLATE = jc.Rock(youngs_modulus=66e9, poisson_ratio=0.25, compressive_strength=159e6)
PAPER = Choices(strength_bound="none")  # whose second cycle takes several of its steps
STATED = Conditions(0.25e-3, SLATE, LARGEST, 3, 0.5e6, Effects(), PAPER, Numerics())
CONDITIONS = STATED.checked()


@pytest.fixture(scope="module")
def joint():
    walls = jc.wall_pair(jrc=6.5, shape=(24, 24), spacing=0.25e-3, seed=4, roll_off=3e-3)
    closed = simulate_walls(*walls, CONDITIONS)
    return closed, SimulatedJoint(walls, closed, CONDITIONS, 0.0, np.empty(0))


def value(name, joint):
    return QUANTITIES[name].rule(joint)


def test_stiffness_is_that_of_each_cycles_own_net_curve(joint):
    """Read off the steps about half of the stress: chords there bound what it can be."""
    closed, read = joint
    assert closed.status < 16
    net = closed.closure - closed.bulk_indentation
    for cycle in (1, 2, 3):
        here = (closed.load_cycle == cycle) & (closed.branch == "loading")
        stress, closure = closed.normal_stress.values[here], net.values[here]
        below, above = closure[stress < HALF].max(), closure[stress >= HALF].min()
        last = stress == min(history_of(closed).landing_stresses[cycle - 1], stress.max())
        end, top = float(closure[last][0]), float(stress[last][0])
        stiffness = value("stiffness_net", read)[cycle - 1]
        assert (top - HALF) / (end - below) <= stiffness <= (top - HALF) / (end - above)
    first, second, _ = history_of(closed).landing_stresses
    assert first < closed.normal_stress.max() < second
    # the second cycle is stiffer than the first
    assert value("stiffness_net", read)[1] > 2.0 * value("stiffness_net", read)[0]


def test_a_jump_is_the_way_to_where_loading_exceeds_a_stress_again():
    steps = {"closure": np.arange(6.0), "normal_stress": [0.0, 2.0, 1.0, 3.0, 4.0, 0.0]}
    steps |= {"load_cycle": [1] * 6, "branch": ["loading"] * 5 + ["unloading"]}
    made = xr.Dataset({name: ("step", values) for name, values in steps.items()})
    made = made.assign(max_closure=("cycle_number", [4.0]))
    jumped = SimulatedJoint((np.zeros(1),) * 2, made, CONDITIONS, 0.0, np.empty(0))
    assert value("largest_jump", jumped) == pytest.approx(1.5 / 4.0)
    made["normal_stress"][2] = 2.5
    assert value("largest_jump", jumped) == 0.0
    made["normal_stress"][4] = 2.0  # not exceeded again until the end
    assert value("largest_jump", jumped) == pytest.approx(1.0 / 4.0)


def test_the_largest_jump_is_that_of_all_cycles():
    steps = {"closure": [0.0, 1.0, 3.0, 4.0, 3.0, 3.5, 4.0, 3.0]}
    steps |= {"normal_stress": [0.0, 2.0, 1.0, 3.0, 0.0, 2.0, 3.0, 0.0]}
    steps |= {"load_cycle": [1] * 5 + [2] * 3}
    steps["branch"] = [*["loading"] * 4, "unloading", *["loading"] * 2, "unloading"]
    made = xr.Dataset({name: ("step", values) for name, values in steps.items()})
    made = made.assign(max_closure=("cycle_number", [4.0, 1.0]))
    assert largest_jump(made) == pytest.approx(2.5 / 4.0)


def test_what_places_a_joint_among_hard_cases_is_counted_in_its_walls(joint):
    closed, read = joint
    lower = sum(
        int((before > after + 1e-12).sum())
        for before, after in zip(read.walls, (closed.upper_final, closed.lower_final), strict=True)
    )
    assert value("broken_share", read) == lower / (2 * 24 * 24) > 0.0
    assert value("contacts_at_max", read) == round(24 * 24 * float(closed.contact_fraction.max()))
    assert value("stress_over_strength", read) == LARGEST / SLATE.compressive_strength


def test_the_loop_is_how_far_unloading_lies_behind_loading_at_half_of_the_stress(joint):
    closed, read = joint
    loops = value("loop", read)
    branches = (closed.branch.values == name for name in ("loading", "unloading"))
    steps = [np.flatnonzero((closed.load_cycle.values == 1) & branch) for branch in branches]
    loading, unloading = (
        np.interp(HALF, closed.normal_stress[here], closed.closure[here])
        for here in (steps[0], steps[1][::-1])
    )
    assert loops[0] == pytest.approx(unloading - loading, rel=1e-3)
    assert loops[0] > 0.1 * closed.max_closure[0]
    assert loops[1:].tolist() == [0.0, 0.0]


def test_hysteresis_is_the_work_that_unloading_keeps_over_that_of_loading():
    """Straight branches: back to 1 of 2 in the first cycle, to 1.75 of 2 from 1 in the second."""
    made = xr.Dataset(
        {
            "closure": ("step", [0.0, 2.0, 1.0, 2.0, 1.75]),
            "normal_stress": ("step", [0.0, 4.0, 0.0, 4.0, 0.0]),
            "load_cycle": ("step", [1, 1, 1, 2, 2]),
            "branch": ("step", ["loading", "loading", "unloading", "loading", "unloading"]),
            "max_closure": ("cycle", [2.0, 1.0]),
        }
    )
    read = SimulatedJoint((np.zeros(1),) * 2, made, CONDITIONS, 0.0, np.empty(0))
    np.testing.assert_allclose(value("hysteresis", read), [0.5, 0.75])


def test_tables_of_engineers_show_the_same_quantities_as_all_others(joint):
    closed, read = joint
    shown = cycle_table(closed)
    names = {column: name for name, (column, _) in COLUMNS.items()}
    assert set(shown) - set(names) == {"cycle", "residual_share_net", "residual_share"}
    for column in set(shown) & set(names):
        scale = COLUMNS[names[column]][1]
        np.testing.assert_allclose(shown[column], scale * value(names[column], read), rtol=1e-12)


@pytest.mark.parametrize("name", [name for name, about in QUANTITIES.items() if about.unit == "1"])
def test_a_ratio_is_shown_as_it_is(name):
    assert COLUMNS[name] == (name, 1.0)
    assert HEADINGS[name] == QUANTITIES[name].title
    assert mean_shown(name, np.array([0.2, 0.4])).value == pytest.approx(0.3)


def test_walls_are_summed_so_that_mates_have_no_relief(joint):
    _, read = joint
    upper = read.walls[0]
    mates = SimulatedJoint((upper, -upper), read.closed, CONDITIONS, 0.0, np.empty(0))
    for name in ("rms_height", "rms_slope", "initial_aperture"):
        assert value(name, mates) == 0.0 < value(name, read)


RESOLVED = Numerics(breakage="resolved", tolerance=0.02, force_tolerance=1e-5)
BY_PARTS = Effects(breakage=False, gouge=False)
ROUNDING = 1e-13
SOLVED = pytest.mark.parametrize(
    ("effects", "numerics", "by_stress", "residual", "strength", "volume"),
    [
        (Effects(), RESOLVED, True, 1e-5, 0.5 * BAND * 0.02, 1e-12),
        (Effects(), Numerics(), True, 1e-4, 0.0, 1e-12),
        (Effects(gouge=False), RESOLVED, True, 1e-5, 0.5 * BAND * 0.02, np.inf),
        (BY_PARTS, Numerics(), True, 1e-8, 0.0, 0.0),  # one curve is solved to this
        (BY_PARTS, Numerics(), False, 1e-4, 0.0, 0.0),
        (BY_PARTS, Numerics(solver="reference"), True, 1e-4, 0.0, 0.0),
    ],
)


def limits_for(effects, numerics, by_stress):
    verdict = oracle.Verdict(*[0.0] * len(oracle.Verdict._fields))._replace(rounding=ROUNDING)
    return limits_of(verdict, effects, tolerances_of(effects, numerics, by_stress))


@SOLVED
def test_states_are_judged_by_what_they_were_solved_to(
    effects, numerics, by_stress, residual, strength, volume
):
    limits = limits_for(effects, numerics, by_stress)
    solved = 1.01 * residual + 16.0 * ROUNDING  # of sixteen units in the last place
    for name in ("residual", "without_overlap", "without_force"):
        assert limits[name] == pytest.approx(solved)
    assert limits["strength"] == pytest.approx(1e-6 + strength + 16.0 * ROUNDING)
    assert (limits["volume"], limits["load"]) == (volume, 1e-12)
    # no other number may be above 0
    others = {name: 0.0 for name in oracle.Verdict._fields if name not in limits}
    for name in others:
        assert largest_ratio({name: 1e-300}, limits) == np.inf


def test_states_are_judged_by_their_largest_ratio_to_a_limit():
    limits = limits_for(BY_PARTS, Numerics(solver="reference"), by_stress=True)
    assert largest_ratio({"load": 3e-12, "rounding": 1.0}, limits) == pytest.approx(3.0)
