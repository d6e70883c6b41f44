"""Newton's method for the equilibrium of contacts that displace each other elastically."""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.solvers.conjugate_gradients import CoarseSpace, coarse_space, newton_direction
from jointclosure.solvers.contacts import Contacts, contact_response, coordinate_sweep, energy
from jointclosure.solvers.interaction_operator import Influence, interaction_product

MOST_NEWTON_STEPS = 200
_MOST_POOR_STEPS = 8
_SWEEPS = 3
_HALVINGS = 4
ROUNDING = 2.0**-52
"""Smallest residual [1] that can be determined in double precision."""


class Equilibrium(NamedTuple):
    """Forces [N] and interaction [m] at the cells (n,), with residual and effort.

    ``residual`` is sum |F - G| / sum G with the answers G = min(C, psi(g + D - K F)) to the forces
    F, and for a given total force T at least |sum F - T| / sum G. ``field`` is the interaction (y,
    x) [m] at all cells if it was computed with that of the contacts, otherwise empty.
    """

    force: np.ndarray
    interaction: np.ndarray
    field: np.ndarray
    shift: float
    residual: float
    newton_steps: int
    products: int
    space: CoarseSpace


class Problem(NamedTuple):
    """Problem of `solve_equilibrium`; answer, secant (n,) and grid (y, x) are work space."""

    influence: Influence
    matrix: np.ndarray
    contacts: Contacts
    target: float
    answer: np.ndarray
    secant: np.ndarray
    grid: np.ndarray


class Iterate(NamedTuple):
    """Forces (n,) [N], interaction (n,) and (y, x) [m]; sums of |F - answer| and of answers [N]."""

    force: np.ndarray
    elastic_displacement: np.ndarray
    field: np.ndarray
    shift: float
    difference: float
    total: float
    missing: float


@kernel
def _judged(problem, force, elastic_displacement, field, shift):
    """Make an iterate from forces and their interaction; set `Problem.answer` and `secant`."""
    difference, total = contact_response(
        problem.contacts, shift, elastic_displacement, force, problem.answer, problem.secant
    )
    missing = 0.0 if math.isnan(problem.target) else problem.target - force.sum()
    return Iterate(force, elastic_displacement, field, shift, difference, total, missing)


@large_kernel
def _iterate(problem, force, shift):
    """Make an iterate from forces, with one product with the interaction."""
    elastic_displacement = interaction_product(
        problem.influence, problem.matrix, problem.contacts.cells, force, problem.grid
    )
    known = 0 if problem.matrix.size > 0 else problem.grid.shape[1]
    field = problem.influence.field[:, :known].copy()
    return _judged(problem, force, elastic_displacement, field, shift)


@kernel
def _misfit(state):
    return max(state.difference, abs(state.missing))


@large_kernel
def _newton_step(problem, space, state, tolerance):
    """Return the iterate after a Newton step, and the number of products."""
    # as exact as the error of Newton's method requires, and not beyond the tolerance
    ratio = _misfit(state) / state.total if state.total > 0.0 else np.inf
    direction, moved, used = newton_direction(
        problem.influence,
        problem.matrix,
        problem.contacts.cells,
        space,
        problem.answer - state.force,
        problem.secant,
        np.nan if math.isnan(problem.target) else state.missing,
        min(0.1, max(0.3 * ratio, 0.3 * tolerance / ratio)),
        problem.grid,
    )
    force = np.minimum(np.maximum(state.force + direction, 0.0), problem.contacts.limit)
    # last digits of a contact that opens, which rounding of the others would hide
    force[(problem.answer == 0.0) & (force < ROUNDING * state.total)] = 0.0
    return _iterate(problem, force, state.shift + moved), used + 1


@large_kernel
def _lowered(problem, state, trial):
    """Return an iterate with a lower energy than the state, and the number of products."""
    contacts, shift = problem.contacts, state.shift
    before = energy(contacts, shift, state.elastic_displacement, state.force)
    if energy(contacts, shift, trial.elastic_displacement, trial.force) < before:
        return trial, 0
    part = 1.0
    for _ in range(_HALVINGS):
        part *= 0.5
        force = state.force + part * (trial.force - state.force)
        moved = trial.elastic_displacement - state.elastic_displacement
        elastic_displacement = state.elastic_displacement + part * moved
        if energy(contacts, shift, elastic_displacement, force) < before:
            field = state.field + part * (trial.field - state.field)
            return _judged(problem, force, elastic_displacement, field, shift), 0
    force = state.force.copy()
    for _ in range(_SWEEPS):
        coordinate_sweep(problem.influence.table, problem.contacts, state.shift, force)
    return _iterate(problem, force, state.shift), _SWEEPS + 1


@kernel
def interacting_equilibrium(
    influence, matrix, contacts, start, elastic_displacement, space, target, tolerance
):
    """Solve `solve_equilibrium` with interaction; the parameters are the same."""
    n = start.size
    grid = np.zeros(influence.table.shape)
    problem = Problem(influence, matrix, contacts, target, np.empty(n), np.empty(n), grid)
    force = np.minimum(start, contacts.limit)
    given = elastic_displacement.size == n
    if given:
        state = _judged(problem, force, elastic_displacement, grid[:, :0].copy(), 0.0)
    else:
        state = _iterate(problem, force, 0.0)
    products = 0 if given else 1
    stiffness = 1.0 / problem.secant
    steps = poor = 0
    while steps < MOST_NEWTON_STEPS and poor <= _MOST_POOR_STEPS:
        if _misfit(state) <= tolerance * state.total:
            if not given:
                break
            # the interaction was given: check whether it is that of the forces
            given = False
            state = _iterate(problem, state.force, state.shift)
            products += 1
            continue
        if steps == 0 and space.number.size == 0:
            space = coarse_space(influence, contacts.cells, stiffness)
        steps += 1
        trial, used = _newton_step(problem, space, state, tolerance)
        products += used
        used = 0
        if not trial.difference * state.total < 0.5 * state.difference * trial.total:
            if given:
                # it was wrong: start again with the interaction of the forces
                trial, used = _iterate(problem, state.force, state.shift), 1
            elif math.isnan(target):
                trial, used = _lowered(problem, state, trial)
            else:
                poor += 1
        else:
            poor = 0
        given = False
        state = trial
        products += used
    residual = np.nan  # forces without overlap are no equilibrium
    if state.difference == 0.0 and state.missing == 0.0:
        residual = 0.0
    elif state.total > 0.0 and state.difference < np.inf and abs(state.missing) < np.inf:
        residual = _misfit(state) / state.total
    return Equilibrium(
        state.force,
        state.elastic_displacement,
        state.field,
        state.shift,
        residual,
        steps,
        products,
        space,
    )
