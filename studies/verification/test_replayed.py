"""Cycles that are replayed are the elastic curve of the crushed walls, by a solver of its own.

The solver is dense, and knows the model by `jointclosure.engine.oracle` alone, which shares
no code with the package's solvers.
"""

import hypothesis
import hypothesis.strategies as st
import numpy as np

import jointclosure as jc
from jointclosure.engine import oracle
from tests.joints import DOLERITE, SPACING

SHAPE = (11, 13)
STRESS = 5e6


def elastic_force(joint: oracle.Joint, upper, lower, closure: float) -> float:
    """Total force [N] at rest at a closure [m]: active sets and Newton's method, dense.

    A F + B F^(2/3) + sum of U F of all others = delta_S where F > 0, and no overlap elsewhere.
    """
    state = oracle.State(upper, lower, np.zeros(upper.shape), closure, 0.0)
    law = oracle.law_of(joint, state)
    overlap = (upper + lower - ((joint.upper + joint.lower).max() - closure)).ravel()
    curvature = sum(oracle.curvature(wall, joint.spacing) for wall in (upper, lower))
    compliance = oracle.asperity_compliances(curvature, law).ravel()
    y, x = np.unravel_index(np.arange(upper.size), upper.shape)
    table = oracle.influence(upper.shape, joint.spacing, law.base_radius, law.rock_modulus)
    matrix = table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
    force = oracle.forces_of_overlaps(np.maximum(overlap, 0.0), compliance, law.substrate)
    for _ in range(400):
        misfit = overlap - matrix @ force
        at = np.flatnonzero((force > 0.0) | (misfit > 0.0))
        root = np.cbrt(np.maximum(force[at], 1e-9 * (force.max() or 1.0)))
        residual = misfit[at] - law.substrate * force[at] - compliance[at] * np.cbrt(force[at]) ** 2
        if np.abs(residual).max(initial=0.0) < 1e-12 * np.abs(overlap).max():
            return float(force.sum())
        slope = matrix[np.ix_(at, at)] + np.diag(law.substrate + 2.0 / 3.0 * compliance[at] / root)
        new = force[at] + np.linalg.solve(slope, residual)
        leaves = (new <= 0.0) & (force[at] < 1e-10 * force.max())
        force[at] = np.where(leaves, 0.0, np.maximum(new, 0.1 * force[at]))
    raise AssertionError("the oracle's equilibrium was not found")


@hypothesis.settings(deadline=None, max_examples=12, derandomize=True, database=None)
@hypothesis.given(seed=st.integers(0, 10_000), jrc=st.floats(3.0, 15.0))
def test_a_replayed_cycle_is_the_elastic_curve_of_the_crushed_walls(seed, jrc):
    upper, lower = jc.wall_pair(jrc, SHAPE, SPACING, seed)
    closed = jc.simulate(
        upper, lower, spacing=SPACING, rock=DOLERITE, max_normal_stress=STRESS, cycles=2,
        numerics=jc.Numerics(force_tolerance=1e-8),
    )  # fmt: skip
    hypothesis.assume(int(closed.replayed_cycles) == 1)
    joint = oracle.Joint(upper, lower, SPACING, DOLERITE, jc.Effects(), jc.Choices())
    crushed = closed.upper_final.values, closed.lower_final.values
    steps = np.flatnonzero((closed.load_cycle.values == 2) & (closed.normal_stress.values > 0.0))
    area = upper.size * SPACING**2
    for step in steps[:: max(1, len(steps) // 5)]:
        force = elastic_force(joint, *crushed, float(closed.closure.values[step]))
        assert abs(force / area - closed.normal_stress.values[step]) < 1e-6 * STRESS
