"""Scenes with breakage: what must hold at rest, for every solver, judged by the oracle."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.parameters import Choices, Effects, Numerics
from jointclosure.solvers.joint import CONVERGED, Joint
from jointclosure.solvers.registry import SOLVERS, solver_named
from tests import oracle
from tests.conftest import DOLERITE, SPACING

CLOSURES = np.arange(1, 25) * 12.5e-6


def settled(name, walls, effects=Effects(), choices=Choices(), closures=CLOSURES):
    joint = Joint(
        *walls,
        SPACING,
        (DOLERITE, DOLERITE),
        effects,
        choices,
        Numerics(solver=name, force_tolerance=1e-8, sweep_tolerance=1e-8),
    )
    solver = solver_named(name)
    for closure in closures:
        outcome = solver.settle(joint, float(closure), 5e-6)
        assert outcome.outcome == CONVERGED
    return joint, outcome


@pytest.fixture(params=SOLVERS)
def solver(request):
    return request.param


@pytest.mark.parametrize("peaks", ["pristine", "current"])
def test_at_rest_every_contact_holds_or_is_confined(solver, small_joint, peaks):
    joint, outcome = settled(solver, small_joint, choices=Choices(peaks=peaks))
    upper, lower = small_joint if peaks == "pristine" else (joint.upper, joint.lower)
    maps = (oracle.peaks(upper), oracle.peaks(lower))
    load = oracle.pressures_over_limit(
        joint.upper, joint.lower, joint.force, h=SPACING, rock=DOLERITE, peak_maps=maps
    )
    held = (load <= 1.0 + 1e-6) | oracle.confined(joint.upper, joint.lower)
    assert outcome.breakage_steps >= 0
    assert np.any(joint.upper != small_joint[0])  # something did break
    assert held[joint.force > 0.0].all()


def test_at_rest_forces_are_in_equilibrium(solver, small_joint):
    joint, _ = settled(solver, small_joint)
    misfit = oracle.residual(
        joint.upper,
        joint.lower,
        joint.force,
        h=SPACING,
        rock=DOLERITE,
        closure=CLOSURES[-1],
        first_touch=sum(small_joint).max(),
        peak_maps=(oracle.peaks(small_joint[0]), oracle.peaks(small_joint[1])),
    )
    assert misfit < 1e-6 * CLOSURES[-1]
    assert joint.force.min() >= 0.0


def test_each_walls_volume_is_conserved(solver, small_joint):
    joint, _ = settled(solver, small_joint)
    for before, after in zip(small_joint, (joint.upper, joint.lower), strict=True):
        assert abs((after - before).sum()) <= 1e-12 * (before - before.min()).sum()
        assert np.any(after > before)  # gouge fills valleys
        assert after.max() <= before.max()


def test_without_gouge_what_breaks_is_gone(solver, small_joint):
    joint, _ = settled(solver, small_joint, effects=Effects(gouge=False))
    for before, after in zip(small_joint, (joint.upper, joint.lower), strict=True):
        assert np.all(after <= before)
        assert after.sum() < before.sum()


def test_a_strength_that_nothing_reaches_leaves_the_walls_alone(solver, small_joint):
    rock = DOLERITE._replace(compressive_strength=float("inf"))
    closed = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=rock,
        max_normal_stress=1e6,
        numerics=jc.Numerics(solver=solver),
    )
    np.testing.assert_array_equal(closed.upper_final, small_joint[0])
    assert int(closed.breakage_steps) == 0


def test_solvers_agree_in_the_mean_within_the_spread_of_the_order_of_breakage():
    """Equal in the mean over surfaces: see docs/decisions/0006-order-of-breakage.md."""
    maxima = {name: [] for name in SOLVERS}
    for seed in range(12):
        walls = jc.wall_pair(8.0, (16, 16), SPACING, seed=seed)
        for name, values in maxima.items():
            closed = jc.simulate(
                *walls,
                spacing=SPACING,
                rock=DOLERITE,
                max_normal_stress=3e6,
                numerics=jc.Numerics(solver=name),
            )
            values.append(closed.max_closure.values)
    fast, reference = np.array(maxima["fast"]), np.array(maxima["reference"])
    for cycle in (0, 1):
        difference = fast[:, cycle] - reference[:, cycle]
        error = difference.std(ddof=1) / np.sqrt(len(difference))
        # three standard errors of the paired difference
        assert abs(difference.mean()) <= 3.0 * error + 1e-9
        assert abs(difference.mean()) <= 0.1 * reference[:, cycle].mean()
