import numpy as np

from jointclosure.joint.history import (
    closure_at_stresses,
    first_crossing,
    last_crossing,
    unloading_excess,
)

STRESS = np.array([0.0, 1.0, 3.0, 2.0, 4.0])
CLOSURE = np.array([0.0, 10.0, 20.0, 30.0, 40.0])


def test_loading_takes_the_first_crossing_and_unloading_the_last():
    assert first_crossing(STRESS, CLOSURE, 2.0) == 15.0
    assert last_crossing(STRESS[::-1], CLOSURE[::-1], 2.5) == 17.5 - 0.0
    assert first_crossing(STRESS, CLOSURE, 0.0) == 0.0


def test_a_level_that_was_not_reached_is_nan():
    assert np.isnan(first_crossing(STRESS, CLOSURE, 5.0))
    assert np.isnan(last_crossing(STRESS, CLOSURE, 5.0))


def test_curves_are_read_per_cycle_and_branch():
    closure = np.array([0.0, 1.0, 2.0, 1.5, 0.5, 1.5, 2.5, 0.7])
    stress = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 1.0, 2.0, 0.0])
    cycle = np.array([1, 1, 1, 1, 1, 2, 2, 2])
    branch = np.array(["loading"] * 3 + ["unloading"] * 2 + ["loading"] * 2 + ["unloading"])
    found = closure_at_stresses(closure, stress, cycle, branch, 2, np.array([0.0, 1.0, 2.0]))
    np.testing.assert_allclose(found[0], [[0.0, 1.0, 2.0], [0.5, 1.5, 2.0]])
    np.testing.assert_allclose(found[1], [[0.5, 1.5, 2.5], [0.7, 1.6, 2.5]])


def one_cycle(closure, stress):
    """Arguments of `unloading_excess` for a cycle of four steps up and the rest down."""
    branch = np.where(np.arange(len(closure)) < 4, "loading", "unloading")
    return np.array(closure), np.array(stress), np.ones(len(closure), dtype=int), branch


def test_the_excess_of_unloading_is_read_at_its_steps():
    up, load = [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]
    higher = one_cycle([*up, 2.5, 1.5, 0.5], [*load, 2.75, 1.0, 0.0])
    np.testing.assert_allclose(unloading_excess(*higher, [0.0, 0.0]), [0.25, np.nan])
    lower = one_cycle([*up, 2.5, 1.5, 0.5], [*load, 2.25, 1.0, 0.0])
    assert unloading_excess(*lower, [0.0]) == [0.0]


def test_unloading_to_below_the_start_of_its_loading_counts_in_full():
    up, load = [1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 2.0, 3.0]
    found = unloading_excess(*one_cycle([*up, 0.5, 0.0], [*load, 0.75, 0.0]), [0.0])
    assert found == [0.75]


def test_convex_curves_that_are_one_have_no_excess_whatever_their_steps():
    def force(closure):
        return np.maximum(closure, 0.0) ** 1.5

    up, down = np.linspace(0.0, 1.0, 30), np.linspace(0.98, 0.0, 17)
    closure = np.concatenate([up, down])
    branch = np.where(np.arange(closure.size) < up.size, "loading", "unloading")
    cycle = np.ones(closure.size, dtype=int)
    assert unloading_excess(closure, force(closure), cycle, branch, [0.0])[0] < 1e-4
