"""What would run practically for ever is refused, or ends by a bound that can be lifted."""

import math
from unittest.mock import patch

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import simulation
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.mechanics.strength import strength_factor
from tests import joints
from tests.joints import SPACING, pair

CELLS, SCALE = 12, 1e5
LARGE = [SCALE * wall for wall in pair(CELLS, 1)]


def closed(walls=None, stress=3e6, scale=1.0, **stated):
    about = {"unusual_values": True, "seating_stress": 0.0, "cycles": 1, "spacing": scale * SPACING}
    return joints.closed(walls or pair(CELLS, 1), stress, **about | stated)


def named_least(refused) -> float:
    return float(str(refused.value).split("at least ")[1].split(" m")[0])


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_walls_far_larger_than_a_displacement_step_are_refused_by_the_step_that_would_do(breakage):
    bounds = {"most_steps": 2000, "breakage": breakage}
    refused = r"displacement_step = 1.25e-05 m: .* most_steps = 2000; must be at least \S+ m"
    with pytest.raises(jc.InputError, match=refused) as stated:
        closed(LARGE, scale=SCALE, **bounds)
    step = 1.01 * named_least(stated) * np.array([1.0, 0.4, 0.5, 0.2])
    names = ("displacement_step", "breakage_step", "later_displacement_step", "later_breakage_step")
    with pytest.raises(jc.InputError, match="must be at least"):
        closed(LARGE, scale=SCALE, **bounds, **dict(zip(names, 0.9 * step, strict=True)))
    # not foreseen any more, and a bound of few steps shows that the history has begun
    steps = dict(zip(names, step, strict=True))
    ended = closed(LARGE, scale=SCALE, **bounds, most_breakage_steps=1.0, **steps)
    assert int(ended.status) >= FAILURE


def test_radii_at_which_resolved_breakage_crushes_all_are_refused_by_the_least_that_will_do():
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
    most = float(str(said.value).split("less than ")[1].split(" Pa")[0])
    base = 0.5**2 * np.pi * 2.0 / 3.0 * 3e6 / strength_factor(joints.DOLERITE.poisson_ratio)
    assert most == pytest.approx(base, rel=0.01)


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_no_branch_takes_more_displacement_steps_than_the_bound(branch):
    numerics = {"later_displacement_step": 1e-6, "later_breakage_step": 1e-7}
    whole = closed(most_steps=1e4, stress=1e6, **numerics)
    assert int(whole.status) < FAILURE
    here = np.flatnonzero(whole.branch == branch)
    taken = int(whole.settled_states) - (whole.sizes["step"] - 1)  # and thrown away
    most = here[-5] + (taken if branch == "unloading" else 0)
    with patch.object(simulation, "check_foreseen", lambda *_: None):
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
