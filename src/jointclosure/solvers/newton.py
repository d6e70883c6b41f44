"""Newton's method for the equilibrium of contacts that displace each other elastically."""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.solvers.conjugate_gradients import CoarseSpace, coarse_space, newton_direction
from jointclosure.solvers.contacts import (
    Contacts,
    contact_response,
    coordinate_sweep,
    energy,
    usable_start,
)
from jointclosure.solvers.interaction_operator import (
    Influence,
    add_displacements,
    interaction_product,
)
from jointclosure.solvers.products import assign

MOST_NEWTON_STEPS = 200  # after which an equilibrium counts as not found; chosen
_MOST_POOR_STEPS = 8
"""Steps in a row at a given total force that do not halve the residual, after which the shift is
bracketed instead; chosen."""
_SWEEPS = 3  # passes over all contacts where no part of a Newton step lowers the energy; chosen
_HALVINGS = 4  # of a Newton step that does not lower the energy; chosen
FINEST_OF_SUMS = 1e-6
"""Smallest residual [1] that displacements summed from products in single precision can show; a
smaller one is computed from a product in double precision. That of a settled joint always is."""
ROUNDING = 2.0**-52
"""Smallest residual [1] that can be determined in double precision."""


class Equilibrium(NamedTuple):
    """Forces of contacts (n,) in equilibrium, with residual and effort.

    The symbols are those of `solvers.equilibrium`. The residual is sum |F - G| / sum G. The answers
    G = min(C, psi(g + D - K F)) are the forces that the contacts would carry at the overlaps that
    the forces F leave. For a given total force T the residual is at least |sum F - T| / sum G.
    """

    force: np.ndarray  # (n,) [N]
    interaction: np.ndarray  # at the contacts (n,) [m]
    field: np.ndarray  # interaction at all cells (y, x) [m], empty if it was not computed
    shift: float  # of all overlaps [m]
    residual: float  # [1]
    newton_steps: int
    products: int  # with the interaction
    space: CoarseSpace  # preconditioner, which a following equilibrium may use


class Problem(NamedTuple):
    """Contacts whose equilibrium is sought, with work space for the last iterate.

    ``influence``, ``matrix`` and ``contacts`` are as for `solve_equilibrium`. Every new `Iterate`
    sets ``answer`` and ``secant``.
    """

    influence: Influence
    matrix: np.ndarray
    contacts: Contacts
    target: float  # total force [N], NaN if the shift is given
    answer: np.ndarray  # answers G (n,) [N] of the contacts, see `Equilibrium`
    secant: np.ndarray  # compliance (n,) [m/N] of each contact from its force to its answer
    grid: np.ndarray  # work space: forces (y, x) [N] of a product


class Iterate(NamedTuple):
    """Forces of one step of Newton's method, and how far they are from equilibrium."""

    force: np.ndarray  # (n,) [N]
    elastic_displacement: np.ndarray  # their interaction at the contacts (n,) [m]
    field: np.ndarray  # interaction at all cells (y, x) [m]; with a matrix at contacts (1, n)
    shift: float  # of all overlaps [m]
    difference: float  # sum of |force - answer| [N]
    total: float  # sum of the answers [N]
    missing: float  # given total force less the sum of the forces [N]; 0 if none is given


@kernel
def _iterate_with_answers(problem, force, field, shift):
    """Make an iterate from forces (n,) [N] and their interaction ``field`` [m], see `Iterate`.

    `Problem.answer` and `Problem.secant` are set to those of the iterate. ``shift`` is in m.
    """
    cells = problem.contacts.cells
    elastic_displacement = np.empty(cells.size)
    flat = field.ravel()
    for i in range(cells.size):
        elastic_displacement[i] = flat[i if problem.matrix.size > 0 else cells[i]]
    difference, total = contact_response(
        problem.contacts, shift, elastic_displacement, force, problem.answer, problem.secant
    )
    missing = 0.0 if math.isnan(problem.target) else problem.target - force.sum()
    return Iterate(force, elastic_displacement, field, shift, difference, total, missing)


@large_kernel
def _iterate_of_forces(problem, force, shift):
    """Make an iterate from forces (n,) [N] at a shift [m], with one product with the interaction.

    `Problem.answer` and `Problem.secant` are set to those of the iterate.
    """
    elastic_displacement = interaction_product(
        problem.influence, problem.matrix, problem.contacts.cells, force, problem.grid
    )
    if problem.matrix.size > 0:
        field = np.empty((1, force.size))
        assign(field[0], elastic_displacement)
    else:
        field = problem.influence.field[:, : problem.grid.shape[1]].copy()
    return _iterate_with_answers(problem, force, field, shift)


@kernel
def _misfit(state):
    """Return `Equilibrium.residual` times the sum of the answers [N], for an iterate."""
    return max(state.difference, abs(state.missing))


@large_kernel
def _newton_step(problem, space, state, tolerance):
    """Return the iterate after a Newton step from ``state``, and the number of products.

    `Problem.answer` and `Problem.secant` are those of ``state`` before, and of the new iterate
    afterwards. The step is solved as exactly as ``tolerance``, of the residual, requires.
    """
    # as exact as the error of Newton's method requires, and not beyond the tolerance
    ratio = _misfit(state) / state.total if state.total > 0.0 else np.inf
    field = state.field.copy()
    direction, moved, used = newton_direction(
        problem.influence,
        problem.matrix,
        problem.contacts.cells,
        space,
        problem.answer - state.force,
        problem.secant,
        np.nan if math.isnan(problem.target) else state.missing,
        min(0.1, max(0.3 * ratio, 0.3 * tolerance / ratio)),
        field,
    )
    directed = state.force + direction
    force = np.minimum(np.maximum(directed, 0.0), problem.contacts.limit)
    # a contact that opens keeps no last digits, which rounding of other forces would hide
    force[(problem.answer == 0.0) & (force < ROUNDING * state.total)] = 0.0
    used += _add_change(problem, force - directed, field)
    return _iterate_with_answers(problem, force, field, state.shift + moved), used


@kernel
def _add_change(problem, change, field):
    """Add the interaction of changes of force (n,) [N] to a field [m], in place.

    Return the number of products: 1 if a convolution was needed, else 0.
    """
    cells = problem.contacts.cells
    return int(add_displacements(problem.influence, problem.matrix, cells, change, field))


@large_kernel
def _safer_iterate(problem, state, trial):
    """Return an iterate with a lower energy than the iterate ``state``, and the number of products.

    It is ``trial``, the iterate after a Newton step, if its energy is lower. Otherwise it is the
    first of 1/2, 1/4, ... of the step that lowers the energy. If none of `_HALVINGS` such parts
    does, it is the iterate after a few passes of exact minimisation contact by contact
    (Gauss-Seidel), which always lower it.
    """
    contacts = problem.contacts
    shift = state.shift
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
            return _iterate_with_answers(problem, force, field, shift), 0
    force = state.force.copy()
    for _ in range(_SWEEPS):
        coordinate_sweep(problem.influence.table, problem.contacts, state.shift, force)
    return _iterate_of_forces(problem, force, state.shift), _SWEEPS + 1


@kernel
def interacting_equilibrium(influence, matrix, contacts, start, field, space, target, tolerance):
    """Solve the problem of `solve_equilibrium` with interaction; the parameters are the same.

    Newton's method for F = G(F), with the answers G of the contacts to the interaction of F. It
    differs from the textbook's in four ways. The compliance of a contact is not that at its force
    but the secant to its answer, with which a contact alone is solved in one step. Forces are cut
    to the range from 0 to their limit after a step, in place of an active set. A step is as exact
    as the residual requires (inexact Newton). A step that does not halve the residual must lower
    the energy, or a safer one is taken (`_safer_iterate`). At a given total force the energy is no
    measure: too many such steps end the iteration, and the caller brackets the shift.

    The interaction of single-precision products is summed from step to step. It is computed once in
    double precision before a residual below `FINEST_OF_SUMS` is accepted.
    """
    n = start.size
    start, field = usable_start(start, field)
    grid = np.zeros(influence.table.shape)
    problem = Problem(influence, matrix, contacts, target, np.empty(n), np.empty(n), grid)
    force = np.minimum(start, contacts.limit)
    summed = matrix.size == 0 and field.size > 0
    if summed:
        field = field.copy()
        products = _add_change(problem, force - start, field)
        state = _iterate_with_answers(problem, force, field, 0.0)
    else:
        products = 1
        state = _iterate_of_forces(problem, force, 0.0)
    stiffness = 1.0 / problem.secant
    steps = poor = 0
    while steps < MOST_NEWTON_STEPS and poor <= _MOST_POOR_STEPS:
        if _misfit(state) <= tolerance * state.total:
            if not summed or tolerance >= FINEST_OF_SUMS:
                break
            summed = False
            state = _iterate_of_forces(problem, state.force, state.shift)
            products += 1
            continue
        if steps == 0 and space.number.size == 0:
            space = coarse_space(influence, contacts.cells, stiffness)
        steps += 1
        trial, used = _newton_step(problem, space, state, tolerance)
        products += used
        used = 0
        if not trial.difference * state.total < 0.5 * state.difference * trial.total:
            if math.isnan(target):
                trial, used = _safer_iterate(problem, state, trial)
            else:
                poor += 1
        else:
            poor = 0
        summed = True
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
        state.field[:, : 0 if matrix.size > 0 else grid.shape[1]],
        state.shift,
        residual,
        steps,
        products,
        space,
    )
