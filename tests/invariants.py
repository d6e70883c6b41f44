"""What must hold in every history, recomputed by code that shares nothing with the solvers.

`judged` puts a judge between `jointclosure.simulate` and its fast solver: after
each step it recomputes, from the walls and forces as they then are, what
docs/model.md promises. Extends `jointclosure.verification.oracle` to two rocks and to forces.
"""

from contextlib import contextmanager
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from jointclosure.protocol import FAILURE, FLAGS
from jointclosure.simulation import height_datum
from jointclosure.solvers.fast import FastSolver
from jointclosure.solvers.joint import CONVERGED
from jointclosure.solvers.registry import SOLVERS
from jointclosure.verification import oracle

EPSILON = np.finfo(float).eps


class Material(NamedTuple):
    """E_a* of every pair (y, x), E* of both substrates together, radius r [Pa, Pa, m]."""

    asperity: np.ndarray
    substrate: float
    base_radius: float


def material(walls, rock, h, effects, choices) -> Material:
    """Of the pristine walls, whose peaks are the soft ones, from a pair of rocks."""
    plain = [each.youngs_modulus / (1 - each.poisson_ratio**2) for each in rock]
    ratio = choices.peak_modulus_ratio if effects.soft_peaks else 1.0
    upper, lower = (
        modulus * np.where(oracle.peaks(wall), ratio, 1.0)
        for modulus, wall in zip(plain, walls, strict=True)
    )
    return Material(
        1 / (1 / upper + 1 / lower), 1 / sum(1 / e for e in plain), choices.base_radius_in_cells * h
    )


def forces_of_overlaps(overlap, kappa, stuff: Material, substrate: bool):
    """Forces (y, x) that A F + B F^(2/3) = overlap, by bisection, and dF/d(overlap)."""
    a = 0.75 / (stuff.base_radius * stuff.substrate)
    b = (9 * kappa / (16 * stuff.asperity**2)) ** (1 / 3)
    overlap = np.maximum(overlap, 0.0)
    if not substrate:
        with np.errstate(divide="ignore", invalid="ignore"):  # rigid where flat: infinite
            force = np.where(overlap > 0.0, (overlap / b) ** 1.5, 0.0)
            return force, np.where(overlap > 0.0, 1.5 * force / overlap, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        high = np.fmin(np.cbrt(overlap / a), np.sqrt(overlap / b))
    high = np.where(overlap > 0.0, high, 0.0)
    low = np.zeros_like(high)
    for _ in range(120):  # more than a double has digits, of a root that may be far below `high`
        middle = 0.5 * (low + high)
        beyond = (a * middle + b) * middle**2 > overlap
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(high > 0.0, 3 * high / (3 * a * high + 2 * b), 0.0)
    return high**3, slope


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


def force_residual(upper, lower, force, *, h, closure, first_touch, stuff, effects):
    """sum |F - psi(delta_S)| / sum F, and how far rounding of the overlaps moves it.

    The misfit of a force is that to the interval of psi over the `curvature_bounds`.
    """
    u = np.zeros(force.shape)
    if effects.interaction:
        u = oracle.interaction(force, h, stuff.base_radius, stuff.substrate)
    overlap = upper + lower - (first_touch - closure) - u
    bounds = [
        sum(both) for both in zip(*(curvature_bounds(z, h) for z in (upper, lower)), strict=True)
    ]
    stiff, slope = forces_of_overlaps(overlap, bounds[0], stuff, effects.substrate)
    soft, least_slope = forces_of_overlaps(overlap, bounds[1], stuff, effects.substrate)
    slope = np.where(np.isfinite(slope), slope, least_slope)
    total = force.sum()
    heights = np.abs(upper).max() + np.abs(lower).max() + abs(first_touch) + abs(closure)
    rounding = 16 * EPSILON * (heights + np.abs(u).max())
    misfit = np.maximum(force - stiff, 0.0) + np.maximum(soft - force, 0.0)
    return misfit.sum() / total, rounding * slope.sum() / total + 1e3 * EPSILON


class Judge(FastSolver):
    """The fast solver, each of its answers recomputed; `case` is what it was told."""

    case: tuple

    def settle(self, joint, closure, breakage_step):
        settled = super().settle(joint, closure, breakage_step)
        if settled.outcome == CONVERGED:
            assert_at_rest(joint, settled, *self.case)
        return settled

    def elastic_curve(self, joint, targets):
        """The solver's own, each of its points recomputed from forces that are asked for again."""
        settled = FastSolver.elastic_curve(joint, targets)
        if settled[-1].outcome == CONVERGED:
            for part in range(1, targets.size + 1):
                FastSolver.elastic_curve(joint, targets[:part])
                assert_at_rest(joint, settled[part - 1], *self.case)
        return settled


def assert_at_rest(joint, settled, walls, rock, h, effects, choices, numerics) -> None:
    """Forces not negative, in equilibrium, and adding up; volume conserved."""
    force = joint.force
    assert np.isfinite(force).all()
    assert force.min() >= 0.0
    assert settled.least_force >= 0.0
    np.testing.assert_allclose(settled.total_force, force.sum(), rtol=1e-13)
    if force.any():
        misfit, rounding = force_residual(
            joint.upper,
            joint.lower,
            force,
            h=h,
            closure=settled.closure,
            first_touch=(walls[0] + walls[1]).max(),
            stuff=material(walls, rock, h, effects, choices),
            effects=effects,
        )
        assert misfit <= numerics.force_tolerance * 1.01 + rounding, (misfit, rounding, settled)
    assert_volume(walls, (joint.upper, joint.lower), effects)


def assert_volume(before, after, effects) -> None:
    """Each wall's volume as section 3 of the model defines it; see docs/model.md."""
    for old, new in zip(before, after, strict=True):
        if not effects.breakage:
            np.testing.assert_array_equal(new, old)
        elif effects.gouge:
            assert abs((new - old).sum()) <= 1e-12 * np.abs(old - old.min()).sum()
        else:
            assert np.all(new <= old)


@contextmanager
def judged(walls, rock, h, effects, choices, numerics):
    """Within, `jointclosure.simulate` is judged at each of its steps."""
    pair = rock if isinstance(rock, list) else (rock, rock)
    # the solver sees walls without their offset, see docs/statuses.md
    walls = tuple(wall - height_datum(wall) for wall in walls)
    judge = type("Judge", (Judge,), {"case": (walls, pair, h, effects, choices, numerics)})
    with patch.dict(SOLVERS, fast=judge):
        yield


def assert_honest(closed) -> None:
    """A status of success and finite numbers, or a failure that has a name."""
    status = int(closed.status)
    assert 0 <= status < 2 * max(FLAGS)
    assert all(status & bit == 0 or FLAGS[bit] for bit in (1 << k for k in range(16)))
    if status < FAILURE:
        for name, variable in closed.data_vars.items():
            assert np.isfinite(variable.values).all(), name
        assert np.all(closed.normal_stress.values >= 0.0)
        assert np.all(np.diff(closed.closure.values[closed.branch.values == "loading"][:2]) > 0.0)
        assert np.all(closed.contact_fraction.values <= 1.0)
