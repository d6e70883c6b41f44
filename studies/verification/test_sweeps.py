"""The paper's sweep in both readings, and the fast solver where they fail."""

import mpmath
import numpy as np
import pytest
import scipy

from jointclosure.engine import oracle
from jointclosure.parameters import Choices, Effects
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import influence_of
from studies.verification import printed, sweeps
from studies.verification.analytic import RADIUS, SOLUTIONS, analytic_table
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


@pytest.mark.parametrize("part", [0.3, 1.0, 3.0, 10.0, 100.0])
def test_the_fast_solver_is_in_equilibrium_at_every_load_of_the_hardest_walls(walls, part):
    upper, lower = walls
    closure = part * np.ptp(upper + lower)
    problem = sweeps.problem_at(upper, lower, closure, 1.0, False)
    found = field(problem, sweeps.fast(problem, 1e-12)[0], upper.shape)
    assert found.min() >= 0.0
    effects, choices = Effects(breakage=False, gouge=False, soft_peaks=False), Choices(1.0)
    joint = oracle.Joint(upper, lower, SPACING, DOLERITE, effects, choices)
    state = oracle.State(upper, lower, found, closure, found.sum())
    assert oracle.judge(joint, state).residual < 1e-10


@pytest.mark.parametrize("start", [0.0, 1e-12, 1e6])
@pytest.mark.parametrize("given", ["closure", "total force"])
def test_the_hardest_case_depends_neither_on_the_start_nor_on_what_is_given(hardest, start, given):
    exact, _ = sweeps.fast(hardest, 1e-13)
    total = np.nan if given == "closure" else float(exact.sum())
    stated = influence_of(hardest.table), hardest.contacts, np.full(exact.size, start)
    found = solve_equilibrium(*stated, total, 1e-10)
    assert found.residual <= 1e-10
    assert abs(found.shift) < 1e-12 * hardest.contacts.overlap.max()
    np.testing.assert_allclose(found.force, exact, atol=1e-9 * exact.max())


@pytest.mark.slow
def test_the_one_sided_sweep_ends_on_the_same_forces_a_thousand_sweeps_later(hardest):
    exact, products = sweeps.fast(hardest, 1e-13)
    history = sweeps.one_sided(hardest, 1e-10)
    assert history.residuals[-1] <= 1e-10
    np.testing.assert_allclose(history.force, exact, rtol=1e-7)
    assert history.residuals.size > 10 * products
    # its 1 % test is no error bound: no force changed by that much, and one is off by more
    stopped = np.abs(history.stopped / exact - 1.0)
    assert stopped.max() > 5 * sweeps.PAPER_TOLERANCE


# What the paper's printed formulas lose, and that ours do not


def by_series(frame):
    return frame.pivot_table("error", "at", "series")


def test_the_cubic_as_printed_is_never_right_and_its_best_root_loses_what_ours_keeps():
    found = by_series(printed.cubic_errors(np.logspace(-12, 12, 25)))
    assert found["Eq. (13) as printed"].min() > 0.1
    assert found["sign corrected, principal root"].min() > 0.1
    best = found["sign corrected, best root"]
    assert best.iloc[0] > 1e-6  # cancels as 1e-16/g
    assert best[best.index > 1.0].max() < 1e-13  # the derivation, with the sign corrected
    assert found["jointclosure"].max() < 1e-14


def test_the_far_field_as_printed_loses_every_digit_and_ours_none():
    found = by_series(printed.far_field_errors(np.logspace(0, 9, 40)))
    as_printed = found["Eq. (17) as printed"]
    assert as_printed[as_printed.index < 2.0].max() < 1e-14
    assert as_printed[as_printed.index > 3e8].max() > 0.1
    assert found["jointclosure"].max() < 1e-13


@pytest.mark.parametrize("base", [1e-9, 0.2, 78e9])
def test_the_quartic_as_printed_loses_every_digit_and_ours_none(base):
    found = by_series(printed.quartic_errors(np.logspace(-9, -0.5, 18), base))
    as_printed = found[f"Eq. (29) as printed, p = {base:g}"]
    assert as_printed.iloc[-1] < 1e-12
    assert as_printed.iloc[0] > 1.0
    assert found[f"jointclosure, p = {base:g}"].max() < 1e-13


def test_the_exact_deformation_solves_eq_10_to_50_digits():
    for overlap, gamma in ((1e-300, 0.0), (1e-6, 1e-9), (1e-6, 1e15), (1e3, 1e12)):
        with mpmath.workdps(80):
            x = mpmath.sqrt(printed.exact_deformation(overlap, gamma))
            left = mpmath.mpf(gamma) * x**3 + x**2
            assert abs(left / mpmath.mpf(overlap) - 1) < mpmath.mpf(10) ** -50


# Elastic joints against exact solutions of continuum contact


@pytest.mark.parametrize("name", SOLUTIONS)
def test_the_exact_pressure_carries_the_exact_force(name):
    solution = SOLUTIONS[name]
    carried, _ = scipy.integrate.quad(
        lambda r: 2.0 * np.pi * r * float(solution.pressure(np.array(r))), 0.0, RADIUS, limit=200
    )
    assert carried == pytest.approx(solution.force, rel=2e-3)


def test_elastic_joints_converge_to_the_continuum_with_the_first_power_of_the_spacing():
    table = analytic_table((8, 16, 32))
    assert table.order.dropna().between(0.9, 1.3).all()
    for _, indenter in table.groupby("indenter"):
        assert (np.diff(indenter.pressure_error) < 0.0).all()
        assert abs(indenter.force_error.iloc[-1]) < 0.03
