"""Selected effects: what matters stays, what does not goes, and the error is known."""

import functools

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.effect_selection import (
    ENOUGH,
    FEWEST_PAIRS,
    LONGER,
    LOSS,
    SCATTER,
    Change,
    Pilot,
    choose_among,
    choose_effects,
    possible_scenes,
)
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import Numerics
from tests.joints import DOLERITE, SPACING

pytestmark = pytest.mark.usefixtures("times_by_effects")
ALL, ELASTIC = jc.Effects(), jc.Effects(breakage=False, gouge=False)
FEWER = jc.Effects(interaction=False)
SETTING = {"spacing": SPACING, "rock": DOLERITE, "seating_stress": 0.0}
SHAPE = (len(ASSESSED), 2)


def joints(cells, count=4):
    return [
        jc.wall_pair(8.0, (cells, cells), SPACING, seed, roll_off=None) for seed in range(count)
    ]


@functools.cache
def choices_about_interaction():
    """Change of the closure without interaction, and the choices for tolerances about it."""
    pairs, setting = joints(24), SETTING | {"cycles": 1, "max_normal_stress": 3e6}
    means = [
        np.mean([float(jc.simulate(*pair, effects=e, **setting).max_closure[0]) for pair in pairs])
        for e in (ELASTIC, ELASTIC._replace(interaction=False))
    ]
    actual = 1.0 - means[1] / means[0]
    assert 0.01 < actual < 0.2
    given = {"effects": ELASTIC, "joints": 10_000} | setting
    return actual, [choose_effects(pairs, tolerance=f * actual, **given) for f in (0.5, 10.0)]


def test_an_effect_below_the_tolerance_is_left_out():
    _, (sharp, rough) = choices_about_interaction()
    assert sharp.effects.interaction is True
    assert rough.effects.interaction is False


def test_the_error_of_an_effect_that_is_left_out_is_bounded():
    actual, (_, choice) = choices_about_interaction()
    gross = choice.changes[choice.changes.quantity == "max_closure"].iloc[0]
    assert gross.change < 0.0
    assert actual < gross.at_most <= choice.error
    assert set(choice.changes.quantity) == set(ASSESSED)


@pytest.mark.parametrize(("tolerance", "effects"), [(1e-6, ALL), (0.9, FEWER)])
def test_joints_closed_with_the_selected_effects_are_realisations_of_the_case(tolerance, effects):
    pairs, setting = joints(24), SETTING | {"max_normal_stress": 10e6}
    choice = choose_effects(pairs, tolerance=tolerance, **setting)
    assert choice.effects == effects
    for pair, closed in zip(pairs, choice.closed, strict=False):
        again = jc.simulate(*pair, effects=effects, **setting)
        assert closed.closed.max_closure.equals(again.max_closure)


def test_what_frozen_walls_show_of_a_joint_in_which_nothing_breaks_is_its_change():
    strong = Conditions(SPACING, DOLERITE._replace(compressive_strength=1e9), 1e4, 2, 0.0)
    strong = strong._replace(numerics=Numerics(force_tolerance=1e-6))
    pilot = Pilot(joints(24, 1), strong.checked(), 20)
    changes = pilot.changes(FEWER, 1)[0]
    assert float(pilot.closed[ALL][0].closed.breakage_steps) == 0.0
    predicted = pilot.predicted(FEWER)
    assert np.abs(changes[0]).max() > 1e-4
    np.testing.assert_allclose(predicted.mean, changes, rtol=2e-3, atol=1e-12)
    assert pilot.lost(ALL) > pilot.closed[FEWER][0].seconds  # frozen walls take time too


def test_a_run_with_all_effects_bounds_the_error_of_elastic_joints_from_below():
    pair = joints(32, 1)[0]
    pilot = Pilot([pair], Conditions(SPACING, DOLERITE, 3e6, 2, 0.0).checked(), 20)
    gross = pilot.values(ALL, 1)[0, list(ASSESSED).index("max_closure")]
    least = min(  # whatever an elastic joint closes by, it does so in both cycles
        np.abs(elastic / gross - 1.0).max() for elastic in np.linspace(*gross, 1000)
    )
    assert pilot.screened(("breakage", "gouge"), 0.99 * least)
    assert not pilot.screened(("breakage", "gouge"), 1.01 * least)
    assert set(pilot.closed) == {ALL}


class MadeUp(Pilot):
    """Joints whose quantities change by given values without an effect.

    Closures of the second cycle are half of those of the first: elastic joints need no test.
    """

    cycles = np.array([1.0, 0.5])

    def __init__(self, changes, joints=180, prior=None, seconds=0.5):
        super().__init__(changes, Conditions(SPACING, DOLERITE, 3e6, 2).checked(), joints)
        self.prior, self.time = prior, seconds

    def close(self, change, effects):
        values = np.full(SHAPE, 1.0 + (0.0 if effects == ALL else change)) * self.cycles
        dataset = xr.Dataset({"read": (("quantity", "cycle"), values)})
        seconds = 1.0 if effects == ALL else self.time
        return SimulatedJoint(([], []), dataset, self.conditions, seconds, np.empty(0))

    def read(self, joint):
        return joint.closed.read.values

    def predicted(self, fewer):
        mean, deviation = self.prior or (0.0, np.inf)
        return Change(np.full(SHAPE, mean), np.full(SHAPE, deviation))


@pytest.mark.parametrize(
    ("mean", "deviation", "left_out"), [(0.0, 0.02, True), (0.1, 0.02, False), (0.05, 0.02, False)]
)
def test_a_lone_case_is_decided_by_frozen_walls(mean, deviation, left_out):
    pilot = MadeUp([0.0] * 20, 20, (mean, deviation))
    assert (choose_among(pilot, 0.05).effects == FEWER) is left_out
    assert len(pilot.closed[ALL]) == 1
    assert len(pilot.closed.get(FEWER, ())) == left_out


def test_pairs_decide_where_the_prior_does_not():
    for change, left_out in ((0.03, True), (0.07, False)):
        pilot = MadeUp([change] * 20, 5000, (0.05, 0.05))
        assert (choose_among(pilot, 0.05).effects == FEWER) is left_out
        assert 1 < len(pilot.closed[FEWER]) < 20


@pytest.mark.parametrize("count", [1, 20, 180, 540])
def test_the_time_that_tests_lose_is_bounded_by_the_number_of_joints(count):
    pilot = MadeUp([0.0, 0.11] * 10, count, (0.05, 0.05), seconds=0.45)
    choice = choose_among(pilot, 0.05)
    assert choice.effects == ALL
    assert choice.error == 0.0
    assert choice.lost_seconds <= LOSS * count


@pytest.fixture(scope="module")
def decisions():
    """Of 200 tests: true change, the limit of it, and whether the effect was left out."""
    random, found = np.random.default_rng(1), []
    for _ in range(200):
        truth, scatter = random.normal(0.04, 0.03), SCATTER * random.uniform(0.1, 1.0)
        pilot = MadeUp(random.normal(truth, scatter, 20), 1000, (0.04, 0.03))
        left_out, change, _ = pilot.test(("interaction",), ALL, 0.05)
        found.append((abs(truth), change.most.max(), left_out))
    return np.array(found).T


def test_limits_cover_the_true_change_as_often_as_stated(decisions):
    truth, limit, _ = decisions
    assert np.sum(truth <= limit) >= 0.92 * 200


def test_decisions_that_limits_cover_hold_as_often_as_stated(decisions):
    truth, _, left_out = decisions
    out, held = left_out.sum(), np.sum((left_out == 1.0) & (truth <= 0.05))
    assert out > 40
    assert held >= (ENOUGH + 0.05) * out  # on average over decisions with more than ENOUGH


def test_breakage_is_left_out_after_many_pairs_only():
    for pairs, left_out in (
        (FEWEST_PAIRS["breakage"] - 1, False),
        (FEWEST_PAIRS["breakage"], True),
    ):
        pilot = MadeUp([0.0] * pairs, 10_000, seconds=0.1)
        assert pilot.test(("breakage", "gouge"), ALL, 0.3)[0] is left_out
    lone = MadeUp([0.0] * 20, 20)
    assert "is not tested" in lone.test(("breakage", "gouge"), ALL, 0.3)[2]
    assert set(lone.closed) == {ALL}  # too few joints to pay for so many pairs


def test_all_effects_act_where_a_joint_fails():
    for given in ([np.nan] * 20, [np.nan, 0.0] * 10):
        assert choose_among(MadeUp(given, 10_000, (0.03, 0.05)), 0.05).effects == ALL


def test_a_joint_that_takes_many_more_breakage_steps_without_an_effect_is_given_up():
    pilot = Pilot(joints(24, 1), Conditions(SPACING, DOLERITE, 10e6, 2, 0.0).checked(), 180)
    pilot.values(ALL, 1)
    assert np.isfinite(pilot.values(FEWER, 1)).any()
    steps = pilot.closed.pop(FEWER)[0].closed.breakage_steps
    assert steps > 10 * 24**2
    pilot.closed[ALL][0].closed["breakage_steps"] = 0.9 * steps / LONGER
    choice = choose_among(pilot, 0.9)  # frozen walls show that interaction does not matter
    assert choice.effects == ALL
    assert "too many breakage steps" in str(choice)


def test_substrate_and_soft_peaks_are_kept():
    scenes = possible_scenes(ALL)
    assert scenes[0] == ALL
    assert all(scene.substrate and scene.soft_peaks for scene in scenes)


def test_gouge_goes_with_breakage():
    assert all(scene.gouge == scene.breakage for scene in possible_scenes(ALL))


def test_effects_that_are_off_are_not_brought_in():
    assert possible_scenes(ELASTIC) == [ELASTIC, ELASTIC._replace(interaction=False)]


def test_effects_that_are_not_to_be_chosen_stay():
    assert possible_scenes(ALL, chosen=False) == [ALL]


@pytest.mark.parametrize(("seconds", "left_out"), [(0.85, True), (0.95, False), (2.0, False)])
def test_effects_stay_unless_a_tenth_of_the_time_is_saved(seconds, left_out):
    pilot = MadeUp([0.0] * 20, 10_000, (0.0, 0.01), seconds)
    assert pilot.test(("interaction",), ALL, 0.1)[0] is left_out


@pytest.mark.parametrize(
    ("full", "before"), [(ALL, ELASTIC), (ELASTIC, ELASTIC)], ids=["after breakage", "elastic"]
)
def test_frozen_walls_show_nothing_of_scenes_in_which_nothing_breaks(full, before):
    pilot = MadeUp([0.0] * 20, 10_000, (0.5, 0.01))
    pilot.effects = full
    pilot.values(before, 1)
    _, change, reason = pilot.test(("interaction",), before, 0.05)
    assert "frozen walls" not in reason
    assert np.abs(change.mean).max() < 0.5


def test_what_frozen_walls_do_not_have_is_not_known_before_pairs_are_closed():
    class WithoutStiffness(Pilot):
        def read(self, joint):
            values = super().read(joint)
            if not joint.conditions.effects.breakage:
                values[list(ASSESSED).index("stiffness_net")] = np.nan
            return values

    conditions = Conditions(SPACING, DOLERITE, 3e6, 1, 0.0)
    pilot = WithoutStiffness(joints(24, 1), conditions.checked(), 20)
    pilot.values(ALL, 1)
    change = pilot.predicted(FEWER)
    assert np.isinf(change.deviation).tolist() == [[name == "stiffness_net"] for name in ASSESSED]


def test_the_scatter_that_is_expected_is_that_of_a_single_pair():
    unknown = Change(np.zeros(SHAPE), np.full(SHAPE, np.inf))
    change = unknown.updated(np.full((1, *SHAPE), 0.02))
    np.testing.assert_allclose(change.mean, 0.02)
    np.testing.assert_allclose(change.deviation, SCATTER)


def test_effects_of_a_joint_without_a_closure_are_kept_without_a_test():
    class Failed(MadeUp):
        def read(self, joint):
            return np.full(SHAPE, np.nan)

    assert Failed([0.0]).screened(("interaction",), 0.05) == "cannot be computed"


def test_cycles_to_different_stresses_are_not_alike_without_breakage():
    pilot = MadeUp([0.0])
    assert pilot.screened(("breakage", "gouge"), 0.05)
    pilot.conditions = Conditions(SPACING, DOLERITE, [3e6, 0.0, 1e6]).checked()
    assert pilot.screened(("breakage", "gouge"), 0.05) == ""


def test_a_joint_without_an_effect_takes_no_more_breakage_steps_than_are_stated():
    stated = Conditions(SPACING, DOLERITE, 10e6, 1, 0.0)
    pilot = Pilot(joints(24, 1), stated.checked(), 180)
    pilot.values(ALL, 1)
    pilot.longer = 1e9
    assert np.isfinite(pilot.values(FEWER, 1)).any()
    pilot.closed.pop(FEWER)
    few = stated.numerics._replace(most_breakage_steps=1.0)
    pilot.conditions = pilot.conditions._replace(numerics=few)
    assert np.isnan(pilot.values(FEWER, 1)).all()
