"""What would run practically for ever is refused, or ends by a bound that can be lifted."""

import math
from unittest.mock import patch

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import simulation
from jointclosure.joint.protocol import FAILURE, FLAGS
from tests.joints import DOLERITE, SPACING

CELLS = (12, 12)


def closed(walls=None, spacing=SPACING, stress=3e6, radius=None, **numerics):
    walls = jc.wall_pair(8.0, CELLS, SPACING, seed=1) if walls is None else walls
    return jc.simulate(
        *walls,
        unusual_values=True,
        spacing=spacing,
        rock=DOLERITE,
        max_normal_stress=stress,
        seating_stress=0.0,
        cycles=1,
        choices=jc.Choices(largest_radius=radius),
        numerics=jc.Numerics(**numerics),
    )


def simulated_without_foresight(**stated):
    with patch.object(simulation, "check_foreseen", lambda *_: None):
        return closed(**stated)


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_walls_far_larger_than_a_displacement_step_are_refused_by_the_step_that_would_do(breakage):
    scale = 1e5
    walls = [scale * wall for wall in jc.wall_pair(8.0, CELLS, SPACING, seed=1)]
    refused = r"displacement_step = 1.25e-05 m: .* most_steps = 100000; must be at least \S+ m"
    with pytest.raises(jc.InputError, match=refused) as stated:
        closed(walls, scale * SPACING, breakage=breakage)
    least = float(str(stated.value).split("at least ")[1].split(" m")[0])
    steps = {
        name: value * 1.01 * least / 12.5e-6
        for name, value in jc.Numerics()._asdict().items()
        if name.endswith("_step") and name != "breakage"
    }
    with pytest.raises(jc.InputError, match="must be at least"):
        closed(walls, scale * SPACING, breakage=breakage, **{k: 0.9 * v for k, v in steps.items()})
    # not foreseen any more, and a bound of few steps shows that the history has begun
    ended = closed(
        walls, scale * SPACING, breakage=breakage, most_steps=1e5, most_breakage_steps=1.0, **steps
    )
    assert int(ended.status) >= FAILURE


def test_an_elastic_curve_takes_no_steps_and_is_never_refused():
    scale = 1e5
    walls = [scale * wall for wall in jc.wall_pair(8.0, CELLS, SPACING, seed=1)]
    found = jc.simulate(
        *walls,
        unusual_values=True,
        spacing=scale * SPACING,
        rock=DOLERITE,
        max_normal_stress=3e6,
        effects=jc.Effects(breakage=False, gouge=False),
    )
    assert int(found.status) == 0


def test_radii_at_which_resolved_breakage_crushes_all_are_refused_by_the_least_that_will_do():
    refused = "largest_radius = 0.00025 m: .* must be at least"
    with pytest.raises(jc.InputError, match=refused) as stated:
        closed(radius=SPACING, breakage="resolved")
    least = float(str(stated.value).split("at least ")[1].split(" m")[0])
    found = closed(radius=1.1 * least, breakage="resolved")
    assert int(found.status) < FAILURE
    # the paper's steps do crush it
    assert int(closed(radius=SPACING).status) < FAILURE


def test_what_is_refused_can_be_asked_for_by_name():
    bounds = {"most_breakage_steps": 3e6, "most_steps": 20}
    ended = closed(radius=SPACING, breakage="resolved", **bounds)
    assert FLAGS[int(ended.status)] == "too_many_steps"


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_no_branch_takes_more_displacement_steps_than_the_bound(branch):
    numerics = {"later_displacement_step": 1e-6, "later_breakage_step": 1e-7}
    whole = closed(most_steps=1e4, stress=1e6, **numerics)
    assert int(whole.status) < FAILURE
    here = np.flatnonzero(whole.branch == branch)
    taken = int(whole.settled_states) - (whole.sizes["step"] - 1)  # and thrown away
    most = here[-5] + (taken if branch == "unloading" else 0)
    ended = simulated_without_foresight(most_steps=float(most), stress=1e6, **numerics)
    assert FLAGS[int(ended.status)] == "too_many_steps"
    assert int(ended.settled_states) == most + 1
    assert ended.branch.values[-1] == branch
    # a cycle that was not completed has no readings
    for name in ("max_closure", "residual_closure", "unloading_excess"):
        assert np.isnan(ended[name].values).all()


def test_no_history_takes_more_breakage_steps_than_the_bound():
    whole, most = closed(stress=10e6), 2.0
    ended = closed(stress=10e6, most_breakage_steps=most)
    assert int(whole.breakage_steps) > most * CELLS[0] * CELLS[1]
    assert FLAGS[int(ended.status)] == "breakage_not_at_rest"
    assert int(ended.breakage_steps) < int(whole.breakage_steps)


@pytest.mark.parametrize("name", ["most_steps", "most_breakage_steps"])
def test_a_bound_is_a_number_from_one_on_and_may_be_infinite(name):
    for wrong in (0, -1.0, math.nan, "x"):
        with pytest.raises(jc.InputError, match=f"{name} = "):
            closed(**{name: wrong})
    assert int(closed(stress=1e5, **{name: math.inf}).status) < FAILURE
