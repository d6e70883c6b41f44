"""Closures, stresses and stiffnesses are read from the steps of a history, whatever these are."""

import functools
import itertools
import json

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint import cycle_results
from jointclosure.joint.cycle_results import loop_between, net_responses, unloading_excess
from jointclosure.joint.history import history_of
from jointclosure.joint.interpolation import crossing, rising_slopes
from jointclosure.uncertainty.sources import coarser
from tests.joints import SPACING, closed

STRESS = np.array([0.0, 1.0, 3.0, 2.0, 4.0])
CLOSURE = np.array([0.0, 10.0, 20.0, 30.0, 40.0])
UP, LOAD = [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]


def history(closure, stress, steps):
    """A history whose numbers of steps of loading and unloading alternate."""
    cycle = np.repeat(np.arange(len(steps)) // 2 + 1, steps)
    branch = np.repeat([("loading", "unloading")[i % 2] for i in range(len(steps))], steps)
    along = {"closure": closure, "normal_stress": stress, "load_cycle": cycle, "branch": branch}
    return xr.Dataset({name: ("step", np.array(values)) for name, values in along.items()})


@pytest.mark.parametrize("level", [2.0, 0.0, 5.0])
def test_both_branches_are_read_at_their_crossing_of_least_closure(level):
    first = crossing(STRESS, CLOSURE, level)
    last = crossing(STRESS[::-1], CLOSURE[::-1], level, "unloading")
    expected = {2.0: 15.0, 0.0: 0.0, 5.0: np.nan}[level]
    np.testing.assert_array_equal([first, last], [expected] * 2)


@pytest.mark.parametrize("tolerance", [0.0, 1e-3])
def test_closures_are_read_on_each_branch_at_stresses_that_it_passed(tolerance):
    closure = [0.0, 1.0, 2.0, 1.5, 0.5, 1.5, 2.5, 0.7]
    stress = [0.0, 1.0, 2.0 / (1.0 + 0.5 * tolerance), 1.0, 0.0, 1.0, 2.0, 0.0]
    levels = np.array([0.0, 1.0, 2.0])
    closed = history(closure, stress, [3, 2, 2, 1])
    found = history_of(closed).gross.where_reached(levels, 2, tolerance)
    np.testing.assert_allclose(found[0], [[0.0, 1.0, 2.0], [0.5, 1.5, 2.0]])
    np.testing.assert_allclose(found[1], [[0.5, 1.5, 2.5], [0.7, 1.6, 2.5]])
    partly = history([0.0, 2.0, 1.5, 3.0], [0.0, 4.0, 2.001, 6.0], [2, 1, 1])
    levels = np.array([1.0, 2.0, 3.0])
    fixed = partly.assign_attrs(numerics='{"breakage": "fixed_step"}')
    found = history_of(fixed).gross.where_reached(levels, 2, 1e-3)
    assert np.isnan([found[0, 1, 0], found[1, 0, 0]]).all()
    found = history_of(partly).gross.where_reached(levels, 2, 1e-3)
    assert np.isnan([found[0, 1, 0], found[1, 0, 0]]).all()
    assert found[0, 1, 1] == found[1, 0, 1] == 1.5  # landed on within the tolerance
    assert np.isfinite(found[:, :, 2][[0, 0, 1], [0, 1, 0]]).all()


@pytest.mark.parametrize(
    ("up", "down", "relief", "excess"),
    [
        (UP, [2.5, 1.5, 0.5], [2.75, 1.0, 0.0], 0.25),
        (UP, [2.5, 1.5, 0.5], [2.25, 1.0, 0.0], 0.0),
        ([1.0, 2.0, 3.0, 4.0], [0.5, 0.0], [0.75, 0.0], 0.75),  # below the start it counts in full
    ],
)
def test_the_excess_of_unloading_is_read_at_its_steps(up, down, relief, excess):
    closed = history([*up, *down], [*LOAD, *relief], [4, len(down)])
    np.testing.assert_allclose(unloading_excess(closed, [0.0, 0.0]), [excess, np.nan])


def test_unloading_below_the_loading_on_both_sides_has_no_excess_without_a_cubic(monkeypatch):
    """A monotone cubic lies between its neighbours; the library that has it is slow to load."""
    closed = history([*UP, 2.5, 1.5, 1.2], [*LOAD, 1.5, 0.5, 0.0], [4, 3])
    monkeypatch.setattr(cycle_results, "scipy", None)
    np.testing.assert_array_equal(unloading_excess(closed, [0.0, 0.0]), [0.0, np.nan])


LARGEST, USUAL = 10.27e6, jc.Numerics(breakage="resolved")


@pytest.fixture(scope="module")
def stiff_joints():
    """Joints by the usual steps of resolved breakage, each with the same one by finer steps."""
    pairs = []
    every = itertools.product((1.6e-3, 6e-3), (60e6, 173e6), (1, 2, 3))
    for wavelength, strength, seed in every:
        about = {"mismatch_wavelength": wavelength, "roll_off": None}
        walls = jc.wall_pair(8.0, (24, 24), SPACING, seed, **about)
        given = {"rock": jc.Rock(11e9, 0.25, strength), "seating_stress": 0.257e6}
        steps = USUAL, coarser(USUAL, 1.0 / 4.0)
        pairs.append([closed(walls, LARGEST, numerics=numerics, **given) for numerics in steps])
    return pairs


def test_stiffness_and_closure_of_stiff_joints_are_those_of_finer_steps(stiff_joints):
    for name, mean in (("stiffness_net", 0.03), ("max_closure_seated_net", 0.03)):
        read = np.array([[net_responses(one)[name] for one in pair] for pair in stiff_joints])
        ratios = read[:, 0] / read[:, 1]
        np.testing.assert_allclose(ratios.mean(axis=0), 1.0, atol=mean)
        assert ratios.std(axis=0).max() < 0.05


def test_every_branch_has_steps_enough_for_a_chord(stiff_joints):
    for usual, _ in stiff_joints:
        for cycle in (1, 2):
            for branch in ("loading", "unloading"):
                stress = usual.normal_stress.values[history_of(usual).branch(cycle, branch).steps]
                assert (stress > 0.5 * LARGEST).sum() >= 5


def lab_history(closure, stress, steps, numerics=None, effects=None, maximum=4.0):
    """A history with the attributes that readings depend on."""
    numerics = {"breakage": "fixed_step", "target": "equilibrate"} | (numerics or {})
    numerics = {"displacement_step": 1.0, "later_displacement_step": 0.5} | numerics
    numerics |= {"stress_tolerance": 1e-3}
    made = history(closure, stress, steps)
    made = made.assign(bulk_indentation=0.0 * made.closure)
    about = {"seating_stress_Pa": 0.5, "max_normal_stress_Pa": maximum}
    settings = {"numerics": numerics, "effects": {"breakage": True} | (effects or {})}
    return made.assign_attrs(about | {name: json.dumps(of) for name, of in settings.items()})


LANDED = [0.0, 1.0, 2.0, 2.5, 2.6], [0.0, 1.0, 3.0, 3.9, 4.0]
"""Closures and stresses of a loading whose last whole step, of 1, ends at a stress of 3."""


def test_only_loadings_beyond_a_former_maximum_land_from_their_last_whole_step():
    once = [5]
    assert history_of(lab_history(*LANDED, once)).landing_stresses[0] == 3.0
    for changed in ({"breakage": "resolved"}, {"target": "interpolate"}):
        assert history_of(lab_history(*LANDED, once, changed)).landing_stresses[0] == np.inf
    elastic = lab_history(*LANDED, once, effects={"breakage": False})
    assert history_of(elastic).landing_stresses[0] == np.inf
    for beyond, lands in ((1.0, False), (1.002, False), (1.05, True)):
        up = [2.0, 2.5, 3.0, 3.1], [0.0, 2.0, 3.5, 4.0 * beyond]
        twice = lab_history([*LANDED[0], *up[0]], [*LANDED[1], *up[1]], [5, 1, 3])
        found = history_of(twice).landing_stresses[1]
        assert found == (3.5 if lands else np.inf)
    # without any whole step it lands from its start
    short = lab_history([0.0, 0.4, 0.7], [0.0, 2.0, 4.0], [3])
    assert history_of(short).landing_stresses[0] == 0.0


def test_closures_of_a_cycle_are_unknown_unless_it_was_unloaded_to_its_minimum():
    closure = [0.0, 2.0, 4.0, 3.0, 2.0, 4.0, 3.5]
    stress = [0.0, 2.0, 4.0, 2.0, 0.0, 4.0, 2.0]
    closed = lab_history(closure, stress, [3, 2, 1, 1], {"breakage": "resolved"})
    for minima, known in (([0.0, 0.0], [True, False]), ([0.0, 2.0], [True, True])):
        found = history_of(closed).gross.cycle_closures(np.array(minima))
        assert np.isfinite(found["max_closure"]).tolist() == known
        assert np.isfinite(found["residual_closure"]).tolist() == known
    # the second one begins below the seating stress, and ends above it
    assert np.isfinite(found["max_closure_seated"]).all()
    assert np.isnan(found["residual_closure_seated"][1])
    assert history_of(closed.isel(step=slice(5, None))).net.seat(2, "loading") != 0.0
    for breakage in ("resolved", "fixed_step"):
        above = lab_history(
            [0.0, 4.0, 3.0, 4.0], [0.0, 4.0, 2.0, 4.0], [2, 1, 1], {"breakage": breakage}
        )
        assert np.isfinite(history_of(above).net.seat(1, "loading"))
        assert np.isnan(history_of(above).net.seat(2, "loading"))  # begins at 2


def test_a_cycle_that_was_not_completed_has_no_net_responses():
    whole = closed_joint()
    part = whole.copy(deep=True)
    part["max_closure"][1] = np.nan
    known, found = net_responses(whole), net_responses(part)
    for name, values in known.items():
        assert np.isfinite(values[0]) or name == "landing_stress"
        np.testing.assert_array_equal(found[name][0], values[0])
        assert np.isnan(found[name][1])


@functools.cache
def closed_joint():
    return closed(jc.wall_pair(8.0, (20, 24), SPACING, seed=3), 4e6, seating_stress=0.5e6)


def test_a_maximum_within_a_percent_of_a_level_counts_as_reaching_it():
    closed = lab_history([0.0, 2.0, 4.0, 3.0, 2.0], [0.0, 2.0, 4.0, 2.0, 0.0], [3, 2])
    read = history_of(closed).gross.at(np.array([3.9, 4.0, 4.03, 4.05]))
    assert np.isfinite(read[0, :, :3]).all()
    np.testing.assert_array_equal(read[0, :, 2], read[0, :, 1])
    assert np.isnan(read[0, :, 3]).all()


def test_stress_levels_of_a_cycle_end_at_its_maximum():
    other = lab_history([*range(6)], [0.0, 4.0, 0.0, 2.0, 0.0, 2.0], [2, 1, 1, 1, 1], maximum=4.0)
    assert history_of(other).stress_levels(4, 2)[-1] == 2.0
    assert (
        history_of(other).stress_levels(4)[-1] == history_of(other).stress_levels(4, 1)[-1] == 4.0
    )


def test_a_loop_of_rounding_is_none():
    loading = np.array([1.0, 1.0, 1.0, 0.0])
    unloading = loading + np.array([1e-13, -1e-13, 1e-11, 1e-20])
    np.testing.assert_array_equal(loop_between(loading, unloading) != 0.0, [0, 0, 1, 1])


rising_curves = st.lists(st.floats(0.01, 3.0), min_size=6, max_size=20)


def slopes_of_steps(rises):
    """Slopes of a curve whose closure rises so at each step of 1 of the stress."""
    stress = np.arange(len(rises) + 1.0)
    return rising_slopes(stress, np.concatenate([[0.0], np.cumsum(rises)]), stress)


@hypothesis.given(rising_curves)
def test_slopes_of_any_curve_rise(rises):
    assert (np.diff(slopes_of_steps(rises)) >= -1e-12).all()


@hypothesis.given(rising_curves)
def test_slopes_of_any_curve_leave_its_steepest_chords_by_no_more_than_twice(rises):
    slopes, chords = slopes_of_steps(rises), 1.0 / np.array(rises)
    assert slopes[0] >= 0.5 * chords.min() * (1.0 - 1e-12)
    assert slopes[-1] <= 2.0 * chords.max() * (1.0 + 1e-12)


@pytest.mark.parametrize("steps", range(6, 21))
def test_slopes_of_a_straight_curve_are_its_slope(steps):
    np.testing.assert_allclose(slopes_of_steps([0.5] * steps), 2.0)
