"""Forces in equilibrium at a given closure: a convex complementarity problem.

Find forces F >= 0 such that, with the geometric overlap g, the interaction K
and the law of one contact F = psi(overlap),

    F_i = psi_i(g_i - (K F)_i),        psi = 0 where the overlap is not positive.

These are the optimality conditions of

    min  sum_i (A F_i^2 / 2 + 3/5 B_i F_i^(5/3)) + F.K F / 2 - g.F   over F >= 0,

strictly convex as A + K is positive definite for a base radius of at most a
cell (Choices.base_radius_in_cells). So the answer is unique and does not
depend on the method: docs/decisions/0004-equilibrium.md.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.compilation import kernel
from jointclosure.mechanics.contact import force_of_overlap, overlap_of_force
from jointclosure.solvers.interaction_operator import (
    DENSE_LIMIT,
    Influence,
    influence_matrix,
    interaction_product,
)

MOST_NEWTON_STEPS = 200
_MOST_CONJUGATE_GRADIENT_STEPS = 1000


class Equilibrium(NamedTuple):
    """Forces [N] and interaction [m] at the cells (n,), and how they came about.

    ``residual`` is sum |F - psi(g - K F)| / sum F, recomputed from the forces
    returned. ``products`` counts the products with the interaction.
    """

    force: np.ndarray
    interaction: np.ndarray
    residual: float
    newton_steps: int
    products: int


@kernel
def contact_response(overlap, force, substrate, compliance, answer, secant):
    """Forces that answer the overlaps, and secants from the present forces.

    Parameters
    ----------
    overlap : array (n,)
        g - K F [m].
    force : array (n,)
        Present forces F [N].
    substrate, compliance
        A [m/N] and B (n,) [m N^(-2/3)].
    answer, secant : array (n,)
        Receive psi(overlap) [N], and the slope [m/N] of the law between
        the present force and the answer: the compliance with which a step
        from F in direction (overlap - phi(F)) meets the answer exactly.
        Infinite for a cell that is out of contact and stays so.

    Returns
    -------
    difference, total : float
        sum |F - psi| and sum psi [N].
    """
    difference = 0.0
    total = 0.0
    for i in range(overlap.size):
        answer[i], slope = force_of_overlap(overlap[i], substrate, compliance[i])
        step = answer[i] - force[i]
        difference += abs(step)
        total += answer[i]
        if abs(step) > 1e-7 * force[i]:
            present = overlap_of_force(force[i], substrate, compliance[i])
            secant[i] = (overlap[i] - present) / step
        elif slope > 0.0:
            secant[i] = 1.0 / slope
        else:
            secant[i] = np.inf
    return difference, total


@kernel
def energy(overlap, pushed, force, substrate, compliance):
    """The energy that equilibrium minimises [J], K F given as ``pushed``."""
    total = 0.0
    for i in range(force.size):
        root = np.cbrt(force[i])
        own = 0.5 * substrate * force[i] + 0.6 * compliance[i] * root * root
        total += force[i] * (own + 0.5 * pushed[i] - overlap[i])
    return total


@kernel
def coordinate_sweep(table, cells, overlap, force, substrate, compliance):
    """One pass of exact minimisation contact by contact, in place.

    Slow and sure: the energy falls with every pass, whatever the start. The
    paper's sweep (Section 3, steps 3 to 5) is this one, tallest cell first.

    Parameters
    ----------
    table : array (y, x)
        Influence by distance in cells [m/N], see `Influence`.
    cells, overlap, force, compliance
        As in `solve_equilibrium`, swept in their order.
    substrate : float
        A [m/N].

    Returns
    -------
    float
        Largest change of a force, relative to its new value.
    """
    nx = table.shape[1]
    change = 0.0
    for i in range(force.size):
        y, x = divmod(cells[i], nx)
        pushed = 0.0
        for j in range(force.size):
            if force[j] > 0.0:
                v, w = divmod(cells[j], nx)
                pushed += table[abs(y - v), abs(x - w)] * force[j]
        answer = force_of_overlap(overlap[i] - pushed, substrate, compliance[i])[0]
        if answer != force[i]:
            change = max(change, abs(answer - force[i]) / answer if answer > 0.0 else np.inf)
        force[i] = answer
    return change


@kernel
def newton_direction(influence, matrix, cells, step, secant, tolerance, scratch):
    """Solve (D + K) d = D step by conjugate gradients, D the secant compliances.

    Returns the direction d (n,) [N] and the number of products with K.
    """
    n = step.size
    weight = np.zeros(n)
    rest = np.zeros(n)
    for i in range(n):
        if secant[i] < np.inf:
            weight[i] = 1.0 / np.sqrt(secant[i])
            rest[i] = step[i] / weight[i]
    solution = np.zeros(n)
    search = rest.copy()
    square = np.dot(rest, rest)
    enough = tolerance * tolerance * square
    used = 0
    while square > enough and used < _MOST_CONJUGATE_GRADIENT_STEPS:
        image = interaction_product(influence, matrix, cells, weight * search, scratch)
        used += 1
        curved = 0.0
        for i in range(n):
            image[i] = search[i] + weight[i] * image[i]
            curved += search[i] * image[i]
        length = square / curved
        following = 0.0
        for i in range(n):
            solution[i] += length * search[i]
            rest[i] -= length * image[i]
            following += rest[i] * rest[i]
        for i in range(n):
            search[i] = rest[i] + following / square * search[i]
        square = following
    return weight * solution, used


@kernel
def interacting_equilibrium(influence, cells, overlap, compliance, substrate, start, tolerance):
    """`solve_equilibrium` with interaction; the same parameters.

    Newton on the convex problem, in the contacts that carry or are about to,
    with secants for the contact law and conjugate gradients inside; a step
    that lowers neither energy nor residual is replaced by sweeps of exact
    coordinate minimisation, which always lower the energy.
    """
    n = cells.size
    scratch = np.zeros(influence.table.shape)
    matrix = influence_matrix(influence.table, cells[: n if n <= DENSE_LIMIT else 0])
    answer, secant = np.empty(n), np.empty(n)
    force = start.copy()
    pushed = interaction_product(influence, matrix, cells, force, scratch)
    products = 1
    difference, total = contact_response(
        overlap - pushed, force, substrate, compliance, answer, secant
    )
    steps = 0
    while difference > tolerance * total and steps < MOST_NEWTON_STEPS:
        steps += 1
        # as exact as Newton's own error calls for, and no more than is asked for
        ratio = difference / total if total > 0.0 else np.inf
        inner = min(0.1, max(0.3 * ratio, 0.3 * tolerance / ratio))
        direction, used = newton_direction(
            influence, matrix, cells, answer - force, secant, inner, scratch
        )
        trial = np.maximum(force + direction, 0.0)
        trial_pushed = interaction_product(influence, matrix, cells, trial, scratch)
        products += used + 1
        trial_difference, trial_total = contact_response(
            overlap - trial_pushed, trial, substrate, compliance, answer, secant
        )
        better = trial_difference * total < 0.5 * difference * trial_total
        if not better:
            before = energy(overlap, pushed, force, substrate, compliance)
            after = energy(overlap, trial_pushed, trial, substrate, compliance)
            better = after < before
        if not better:
            trial = force.copy()
            for _ in range(3):
                coordinate_sweep(influence.table, cells, overlap, trial, substrate, compliance)
            trial_pushed = interaction_product(influence, matrix, cells, trial, scratch)
            products += 4
            trial_difference, trial_total = contact_response(
                overlap - trial_pushed, trial, substrate, compliance, answer, secant
            )
        force, pushed = trial, trial_pushed
        difference, total = trial_difference, trial_total
    residual = difference / total if total > 0.0 else 0.0
    return Equilibrium(force, pushed, residual, steps, products)


@kernel
def separate_equilibrium(overlap, compliance, substrate):
    """Forces (n,) [N] of contacts that do not feel each other."""
    force = np.empty(overlap.size)
    for i in range(overlap.size):
        force[i] = force_of_overlap(overlap[i], substrate, compliance[i])[0]
    return force


def solve_equilibrium(
    influence: Influence | None,
    cells: np.ndarray,
    overlap: np.ndarray,
    compliance: np.ndarray,
    substrate: float,
    start: np.ndarray,
    tolerance: float,
) -> Equilibrium:
    """Forces in equilibrium at the overlapping cells.

    Parameters
    ----------
    influence : Influence or None
        None in a scene without interaction, which needs no iteration.
    cells : int64 array (n,)
        Flat indices of the cells that overlap without interaction.
    overlap : array (n,)
        Geometric overlap g [m].
    compliance : array (n,)
        B [m N^(-2/3)].
    substrate : float
        A [m/N].
    start : array (n,)
        Forces to start from [N], finite and not negative.
    tolerance : float
        Relative residual to reach.

    Returns
    -------
    Equilibrium
        Converged where its residual is at most the tolerance. Infinite forces
        where a rigid contact (flat, without substrate) overlaps.
    """
    if influence is None or cells.size == 0:
        force = separate_equilibrium(overlap, compliance, float(substrate))
        residual = 0.0 if np.all(np.isfinite(force)) else np.inf
        return Equilibrium(force, np.zeros(cells.size), residual, 0, 0)
    return interacting_equilibrium(
        influence, cells, overlap, compliance, float(substrate), start, float(tolerance)
    )
