"""What must hold in every history of any walls: each step judged by the oracle's equations.

`judged` closes a joint with a solver that shows every state it brings to rest to
`assert_at_rest`. Walls here may have profiles that are straight but for rounding, which
`jointclosure.engine.oracle.judge` takes as they are: so forces are held against the
interval of curvatures that rounding leaves.
"""

import numpy as np

import jointclosure as jc
from jointclosure.engine import oracle
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.joint.simulation import close_walls, height_datum
from jointclosure.solvers.registry import solver_named
from studies.verification.judged import JudgedSolver

EPSILON = np.finfo(float).eps


def curvature_bounds(z, h):
    """Between what values (y, x) rounding of the heights leaves the Gaussian curvature.

    Nearly straight profiles are ill-conditioned: the curvature is a root of what cancels.
    """
    padded = np.pad(z, 1, mode="reflect")
    rounding = 4 * EPSILON * np.abs(z).max() / h**2
    low, high = np.ones(z.shape), np.ones(z.shape)
    for before, after in (
        (padded[1:-1, :-2], padded[1:-1, 2:]),
        (padded[:-2, 1:-1], padded[2:, 1:-1]),
    ):
        sides = [np.hypot(h, z - before), np.hypot(h, after - z), np.hypot(2 * h, after - before)]
        profile = 2 * h * np.abs(before - 2 * z + after) / np.prod(sides, axis=0)
        low *= np.maximum(profile - rounding, 0.0)
        high *= profile + rounding
    return np.sqrt(low), np.sqrt(high)


def force_residual(joint: oracle.Joint, state: oracle.State):
    """sum |F - psi(delta_S)| / sum F, and how far rounding of the overlaps moves it.

    The misfit of a force is that to the interval of psi over the `curvature_bounds`.
    """
    law = oracle.law_of(joint, state)
    cells, overlap = oracle.overlaps_of(joint, state, law)
    walls = (state.upper, state.lower)
    bounds = zip(*(curvature_bounds(z, joint.spacing) for z in walls), strict=True)
    forces, slopes = [], []
    for kappa in (upper + lower for upper, lower in bounds):
        compliance = oracle.asperity_compliances(kappa, law).ravel()[cells]
        found = oracle.forces_of_overlaps(np.maximum(overlap, 0.0), compliance, law.substrate)
        forces.append(found)
        slopes.append(oracle.slopes_of_forces(found, compliance, law.substrate))
    stiff, soft = forces
    slope = np.where(np.isfinite(stiff), *slopes)
    force, total = state.force.ravel()[cells], state.force.sum()
    undeformed = (state.upper + state.lower).ravel()[cells]
    moved = undeformed - ((joint.upper + joint.lower).max() - state.closure) - overlap
    heights = sum(np.abs(z).max() for z in walls) + np.abs(joint.upper + joint.lower).max()
    rounding = 16 * EPSILON * (heights + abs(state.closure) + np.abs(moved).max(initial=0.0))
    misfit = np.maximum(force - stiff, 0.0) + np.maximum(soft - force, 0.0)
    return misfit.sum() / total, rounding * slope.sum() / total + 1e3 * EPSILON


def assert_at_rest(joint: oracle.Joint, state: oracle.State, tolerance: float) -> None:
    """Forces not negative, in equilibrium, and adding up; volume conserved."""
    force = state.force
    assert np.isfinite(force).all()
    assert force.min() >= 0.0
    np.testing.assert_allclose(state.total_force, force.sum(), rtol=1e-13)
    if force.any():
        misfit, rounding = force_residual(joint, state)
        assert misfit <= tolerance * 1.01 + rounding, (misfit, rounding, state.closure)
    assert_volume((joint.upper, joint.lower), (state.upper, state.lower), joint.effects)


def assert_volume(before, after, effects) -> None:
    """Each wall's volume as section 3 of the model defines it; see docs/model.md."""
    for old, new in zip(before, after, strict=True):
        if not effects.breakage:
            np.testing.assert_array_equal(new, old)
        elif effects.gouge:
            assert oracle.volume_change(old, new) <= 1e-12
        else:
            assert np.all(new <= old)


def judged(upper, lower, *, rock, spacing, effects, choices, numerics=jc.Numerics(), **load):
    """`jointclosure.simulate`, judged at each of its steps."""
    # the solver sees walls without their offset
    walls = [wall - height_datum(wall) for wall in (upper, lower)]
    joint = oracle.Joint(*walls, spacing, rock, effects, choices)
    stated = {"rock": rock, "spacing": spacing, "effects": effects, "choices": choices} | load

    def show(state: oracle.State) -> None:
        assert_at_rest(joint, state, numerics.force_tolerance)

    return close_walls(
        upper,
        lower,
        Conditions(numerics=numerics, seating_stress=0.0, **stated),
        solver_of=lambda name: JudgedSolver(solver_named(name), show),
    )


def assert_honest(closed) -> None:
    """A status of success and finite numbers, or a failure that has a name."""
    status = int(closed.status)
    assert 0 <= status < 2 * max(FLAGS)
    assert all(status & bit == 0 or FLAGS[bit] for bit in (1 << k for k in range(16)))
    if status < FAILURE:
        for name, variable in closed.data_vars.items():
            assert np.isfinite(variable.values).all(), name
        assert float(closed.least_force) >= 0.0
        assert np.all(closed.normal_stress.values >= 0.0)
        assert np.all(np.diff(closed.closure.values[closed.branch.values == "loading"][:2]) > 0.0)
        assert np.all(closed.contact_fraction.values <= 1.0)
        assert np.all(closed.locked_share + closed.flat_share <= 1.0 + 1e-12)
