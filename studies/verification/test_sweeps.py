"""The paper's sweep in both readings, and the fast solver where they fail."""

import numpy as np
import pytest

from jointclosure.engine import oracle
from studies.verification import sweeps
from tests.joints import DOLERITE, SPACING

HEIGHTS = 100.0  # closure of the hardest case over the range of heights


@pytest.fixture(scope="module")
def walls():
    return sweeps.polished_walls()


@pytest.fixture(scope="module")
def hardest():
    return sweeps.hardest_problem()


def field(problem, force, shape):
    values = np.zeros(shape)
    values.ravel()[problem.contacts.cells] = force
    return values


def dense_solution(upper, lower, closure, base_radius_in_cells):
    """Forces (y, x) by Newton on dense matrices, every cell in touch; from the walls alone."""
    r = base_radius_in_cells * SPACING
    none = np.zeros(upper.shape, bool)
    asperity, modulus = oracle.moduli(DOLERITE, 1.0, none, none)
    corner = np.zeros(upper.shape)
    corner[0, 0] = 1.0
    influence = oracle.interaction(corner, SPACING, r, modulus)
    y, x = (index.ravel() for index in np.indices(upper.shape))
    matrix = influence[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
    kappa = oracle.curvature(upper, SPACING) + oracle.curvature(lower, SPACING)
    b = np.cbrt(9.0 * kappa / (16.0 * asperity**2)).ravel()
    matrix[np.diag_indices_from(matrix)] = 3.0 / (4.0 * r * modulus)
    overlap = (upper + lower - (upper + lower).max() + closure).ravel()
    force = np.linalg.solve(matrix, overlap)
    for _ in range(8):
        assert force.min() > 0.0
        misfit = matrix @ force + b * np.cbrt(force) ** 2 - overlap
        force = force - np.linalg.solve(matrix + np.diag(2.0 / 3.0 * b / np.cbrt(force)), misfit)
    assert np.abs(misfit).max() < 1e-12 * closure
    return force.reshape(upper.shape)


def test_the_fast_solver_passes_the_hardest_case_to_10_digits(walls, hardest):
    upper, lower = walls
    closure = HEIGHTS * np.ptp(upper + lower)
    exact = dense_solution(upper, lower, closure, 1.0)
    found, products = sweeps.fast(hardest, 1e-12)
    found = field(hardest, found, upper.shape)
    assert np.abs(found / exact - 1.0).max() < 1e-10
    assert products < 150


def test_the_simultaneous_sweep_stops_converging_where_its_spectral_radius_passes_one():
    upper, lower = sweeps.paper_walls()
    upper, lower = upper[:32, :32], lower[:32, :32]
    critical = sweeps.critical_closure(upper, lower)
    for part, converges in ((0.9, True), (1.1, False)):
        problem = sweeps.problem_at(upper, lower, part * critical, 0.5, True)
        exact, _ = sweeps.fast(problem, 1e-12)
        assert (sweeps.spectral_radius(problem, exact) < 1.0) == converges
        history = sweeps.simultaneous(problem, 1e-8)
        assert (history.stop > 0) == converges
        if converges:
            np.testing.assert_allclose(history.force, exact, atol=1e-6 * exact.max())
        else:
            assert history.residuals[-100:].min() > 0.1
        # one-sided, it converges on both sides
        ordered = sweeps.one_sided(problem, 1e-10)
        np.testing.assert_allclose(ordered.force, exact, atol=1e-8 * exact.max())
