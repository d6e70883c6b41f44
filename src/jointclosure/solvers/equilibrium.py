"""Equilibrium of forces: a convex complementarity problem.

Find 0 <= F <= C with F_i = min(C_i, psi_i(g_i + D - (K F)_i)) for the geometric overlap g, the
shift D of the closure, the interaction K and the law of one contact F = psi(overlap). These are the
optimality conditions of min sum_i (A F_i^2 / 2 + 3/5 B_i F_i^(5/3)) + F.K F / 2 - (g + D).F,
strictly convex because A + K is positive definite for a base radius of at most a cell:
docs/decisions.md#0004-equilibrium. The limits C are infinite for elastic contacts, and the strength
if breakage is resolved. Either the shift is given, as 0, or the total force; the shift is then its
Lagrange multiplier.
"""

import math

import numpy as np
import scipy

from jointclosure.solvers.conjugate_gradients import NO_COARSE_SPACE, CoarseSpace
from jointclosure.solvers.contacts import (
    Contacts,
    are_sound,
    separate_equilibrium,
    separate_shift,
)
from jointclosure.solvers.interaction_operator import Influence, dense_limit, influence_matrix
from jointclosure.solvers.newton import ROUNDING, Equilibrium, interacting_equilibrium

_MOST_DOUBLINGS = 200  # of the bracket of a shift; chosen
_NOTHING = np.empty((0, 0))  # in place of a matrix or a field that is not given


def solve_equilibrium(
    influence: Influence | None,
    contacts: Contacts,
    start: np.ndarray,
    target: float,
    tolerance: float,
    matrix: np.ndarray | None = None,
    field: np.ndarray | None = None,
    space: CoarseSpace | None = None,
) -> Equilibrium:
    """Solve the equilibrium of forces at the overlapping cells.

    If Newton's method does not find it from the starting forces, it is repeated from forces of 0.
    If it is then not found at a given total force, the shift is bracketed.

    Parameters
    ----------
    influence, matrix
        Interaction, None without it, and its matrix (n, n) [m/N], or a larger one that begins with
        it. By default the matrix is computed if there are at most `dense_limit` contacts, and a
        convolution is used for more.
    contacts, start
        Contacts (n,), and forces (n,) [N] from which the iteration starts.
    target
        Total force [N]; NaN if the shift is given, which then is 0.
    tolerance
        Largest `Equilibrium.residual`.
    field
        Interaction (y, x) [m] of the forces at the start, if the caller has it. It is not needed
        with a matrix.
    space
        Preconditioner of an equilibrium of similar contacts.

    Returns
    -------
    The equilibrium. Its residual exceeds the tolerance if it was not found, is infinite if a
    contact is rigid, and is NaN if the problem has no finite solution: a contact is not sound
    (`are_sound`), or the total force is infinite or not positive. Otherwise the residual is at
    least `ROUNDING`, or 0 without contacts.
    """
    n = contacts.cells.size
    if not are_sound(contacts) or target <= 0.0 or math.isinf(target):
        nowhere = np.full(n, np.nan)
        return _direct_solution(nowhere, nowhere.copy(), math.nan, math.nan)
    if influence is None or n == 0:
        solution = _separate_solution(contacts, float(target))
        return solution._replace(residual=max(solution.residual, ROUNDING if n else 0.0))
    if matrix is None:
        dense = n <= dense_limit(influence.table.shape)
        matrix = influence_matrix(influence.table, contacts.cells) if dense else _NOTHING
    problem = (influence, matrix, contacts)
    sought = (float(target), float(tolerance))
    solution = interacting_equilibrium(
        *problem,
        start,
        _NOTHING if field is None else field,
        NO_COARSE_SPACE if space is None else space,
        *sought,
    )
    if not solution.residual <= tolerance and start.any():
        again = interacting_equilibrium(*problem, np.zeros(n), _NOTHING, NO_COARSE_SPACE, *sought)
        steps = solution.newton_steps + again.newton_steps
        products = solution.products + again.products
        solution = again if not solution.residual <= again.residual else solution
        solution = solution._replace(newton_steps=steps, products=products)
    if not math.isnan(target) and not solution.residual <= tolerance:
        solution = _solve_by_bracketing(*problem, *sought, solution)
    # the residual cannot be computed more exactly than this
    return solution._replace(residual=max(solution.residual, ROUNDING))


def _separate_solution(contacts: Contacts, target: float) -> Equilibrium:
    """Solve the equilibrium of contacts without interaction, and the shift for a target [N].

    The residual is the relative error of the total force, 0 without a target, and infinite if a
    force is. Without contacts a target is not used, and shift and residual are 0.
    """
    given = math.isnan(target) or contacts.cells.size == 0
    shift = 0.0 if given else separate_shift(contacts, target)
    force = separate_equilibrium(contacts, shift)
    total = float(force.sum())
    if given:
        residual = 0.0 if math.isfinite(total) else np.inf
    else:
        residual = abs(total - target) / target if total > 0.0 else np.inf
    return _direct_solution(force, np.zeros(force.size), shift, residual)


def _direct_solution(
    force: np.ndarray, interaction: np.ndarray, shift: float, residual: float
) -> Equilibrium:
    """Return as equilibrium forces (n,) [N] that were found without Newton's method or products."""
    return Equilibrium(force, interaction, _NOTHING, shift, residual, 0, 0, NO_COARSE_SPACE)


def _solve_by_bracketing(
    influence, matrix, contacts, target, tolerance, start: Equilibrium
) -> Equilibrium:
    """Solve for the shift at which the contacts carry a total force ``target`` [N], by bracketing.

    The total force increases with the shift. The bracket starts at the first contact, and is
    doubled until the total force is too large. Brent's method finds the root; every evaluation is
    an equilibrium at a given shift. ``start`` is the best solution so far. The residual is NaN if
    there is no bracket.
    """
    best = start
    steps = start.newton_steps
    products = start.products
    if math.isnan(start.residual):
        best = start._replace(force=np.zeros(start.force.size))

    def excess_at(shift: float) -> float:
        """Return the total force less the target [N] at a shift [m], and keep its solution.

        The iteration starts from the forces of `best`, which the solution then replaces.
        """
        nonlocal best, steps, products
        moved = contacts._replace(overlap=contacts.overlap + shift)
        solution = interacting_equilibrium(
            influence, matrix, moved, best.force, _NOTHING, NO_COARSE_SPACE, np.nan,
            0.1 * tolerance,
        )  # fmt: skip
        steps += solution.newton_steps
        products += solution.products
        best = solution._replace(shift=shift)
        return float(solution.force.sum()) - target

    low = -float(contacts.overlap.max())
    high = max(start.shift if math.isfinite(start.shift) else low, 0.5 * low)
    for _ in range(_MOST_DOUBLINGS):
        excess = excess_at(high)
        if not excess < 0.0:
            break
        high += high - low
    if not 0.0 <= excess < np.inf:
        return best._replace(residual=math.nan, newton_steps=steps, products=products)
    root = scipy.optimize.brentq(excess_at, low, high, xtol=1e-14 * (high - low), rtol=1e-14)
    excess_at(root)  # sets `best`
    missing = abs(float(best.force.sum()) - target) / target
    residual = max(best.residual, missing)
    return best._replace(residual=residual, newton_steps=steps, products=products)
