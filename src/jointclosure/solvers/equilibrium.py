"""Forces in equilibrium: a convex complementarity problem.

Find forces 0 <= F <= C such that, with the geometric overlap g, the closure's
shift D, the interaction K and the law of one contact F = psi(overlap),

    F_i = min(C_i, psi_i(g_i + D - (K F)_i)),     psi = 0 where there is no overlap.

These are the optimality conditions of

    min  sum_i (A F_i^2 / 2 + 3/5 B_i F_i^(5/3)) + F.K F / 2 - (g + D).F   over 0 <= F <= C,

strictly convex as A + K is positive definite for a base radius of at most a
cell (Choices.base_radius_in_cells). So the answer is unique and does not
depend on the method: docs/decisions/0004-equilibrium.md. The limits C are
infinite for elastic contacts, and a contact's strength where it may yield.

Either the shift is given (0), or the total force is, and the shift is its
Lagrange multiplier: the closure at which the joint carries that force.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy.optimize

from jointclosure.compilation import kernel
from jointclosure.mechanics.contact import (
    cube_root,
    force_near,
    force_of_overlap,
    overlap_of_force,
)
from jointclosure.solvers.coarse_space import coarse_space
from jointclosure.solvers.conjugate_gradients import newton_direction
from jointclosure.solvers.interaction_operator import (
    Influence,
    dense_limit,
    influence_matrix,
    interaction_product,
)

MOST_NEWTON_STEPS = 200
_MOST_DOUBLINGS = 200
ROUNDING = 2.0**-52
"""Residual [1] below which none is known in double precision."""


class Contacts(NamedTuple):
    """The cells (n,) that may carry force, and their laws.

    ``cells`` are flat indices, ``overlap`` g [m], ``compliance`` B
    [m N^(-2/3)], ``limit`` C [N], ``substrate`` A [m/N].
    """

    cells: np.ndarray
    overlap: np.ndarray
    compliance: np.ndarray
    limit: np.ndarray
    substrate: float


class Equilibrium(NamedTuple):
    """Forces [N] and interaction [m] at the cells (n,), and how they came about.

    ``shift`` D [m] is 0 where it was given. ``residual`` is
    sum |F - psi(g + D - K F)| / sum F, recomputed from the forces returned, and
    with a given total force T at least |sum F - T| / T. ``products`` counts
    the products with the interaction. ``field`` is the interaction (y, x) [m]
    at all cells of the grid where it came with those of the contacts, or empty.
    """

    force: np.ndarray
    interaction: np.ndarray
    field: np.ndarray
    shift: float
    residual: float
    newton_steps: int
    products: int


@kernel
def contact_response(contacts, shift, pushed, force, answer, secant):
    """Forces that answer the overlaps, and secants from the present forces.

    Parameters
    ----------
    contacts : Contacts
    shift : float
        D [m].
    pushed, force : array (n,)
        K F [m] and the present forces F [N].
    answer, secant : array (n,)
        Receive min(C, psi(g + D - K F)) [N], and the slope [m/N] of the law
        between the present force and the answer: the compliance with which a
        step from F in direction (overlap - phi(F)) meets the answer exactly.
        Infinite for a cell that stays out of contact, or at its limit.

    Returns
    -------
    difference, total : float
        sum |F - answer| and sum answer [N].
    """
    difference = 0.0
    total = 0.0
    substrate = contacts.substrate
    for i in range(force.size):
        overlap = contacts.overlap[i] + shift - pushed[i]
        compliance = contacts.compliance[i]
        root = cube_root(force[i]) if force[i] > 0.0 else 0.0
        found, slope = force_near(overlap, substrate, compliance, root)
        if found > contacts.limit[i]:
            found = contacts.limit[i]
            slope = 0.0
            overlap = overlap_of_force(found, substrate, compliance)
        answer[i] = found
        step = found - force[i]
        difference += abs(step)
        total += found
        if abs(step) > 1e-7 * force[i]:
            present = (substrate * root + compliance) * root * root
            secant[i] = (overlap - present) / step
        elif slope > 0.0:
            secant[i] = 1.0 / slope
        else:
            secant[i] = np.inf
    return difference, total


@kernel
def energy(contacts, shift, pushed, force):
    """The energy that equilibrium minimises [J], K F given as ``pushed``."""
    total = 0.0
    for i in range(force.size):
        root = cube_root(force[i])
        own = 0.5 * contacts.substrate * force[i] + 0.6 * contacts.compliance[i] * root * root
        total += force[i] * (own + 0.5 * pushed[i] - contacts.overlap[i] - shift)
    return total


@kernel
def coordinate_sweep(table, contacts, shift, force):
    """One pass of exact minimisation contact by contact, in place.

    Slow and sure: the energy falls with every pass, whatever the start. The
    paper's sweep (Section 3, steps 3 to 5) is this one, tallest cell first.

    Parameters
    ----------
    table : array (y, x)
        Influence by distance in cells [m/N], see `Influence`.
    contacts : Contacts
        Swept in their order.
    shift : float
        D [m].
    force : array (n,)
        [N].

    Returns
    -------
    float
        Largest change of a force, relative to its new value.
    """
    nx = table.shape[1]
    cells = contacts.cells
    change = 0.0
    for i in range(force.size):
        y, x = divmod(cells[i], nx)
        pushed = 0.0
        for j in range(force.size):
            if force[j] > 0.0:
                v, w = divmod(cells[j], nx)
                pushed += table[abs(y - v), abs(x - w)] * force[j]
        overlap = contacts.overlap[i] + shift - pushed
        answer = force_of_overlap(overlap, contacts.substrate, contacts.compliance[i])[0]
        answer = min(answer, contacts.limit[i])
        if answer != force[i]:
            change = max(change, abs(answer - force[i]) / answer if answer > 0.0 else np.inf)
        force[i] = answer
    return change


@kernel
def interacting_equilibrium(influence, matrix, contacts, start, pushed, target, tolerance):
    """`solve_equilibrium` with interaction; the same parameters.

    Newton on the convex problem, in the contacts that carry or are about to,
    with secants for the contact law and conjugate gradients inside; at a given
    shift a step that lowers neither energy nor residual is replaced by sweeps
    of exact coordinate minimisation, which always lower the energy.
    """
    n = start.size
    scratch = np.zeros(influence.table.shape)
    answer, secant = np.empty(n), np.empty(n)
    force = np.minimum(start, contacts.limit)
    shift = 0.0
    bound = not math.isnan(target)
    field = scratch[:, :0]
    products = 0
    given = pushed.size == n
    if not given:
        pushed, field = interaction_product(influence, matrix, contacts.cells, force, scratch)
        products = 1
    difference, total = contact_response(contacts, shift, pushed, force, answer, secant)
    missing = target - force.sum() if bound else 0.0
    space = coarse_space(influence, contacts.cells, 1.0 / secant)
    steps = 0
    poor = 0
    while steps < MOST_NEWTON_STEPS:
        if max(difference, abs(missing)) <= tolerance * total:
            if not given:
                break
            # the interaction was given: see whether it is that of the forces
            given = False
            pushed, field = interaction_product(influence, matrix, contacts.cells, force, scratch)
            products += 1
            difference, total = contact_response(contacts, shift, pushed, force, answer, secant)
            continue
        steps += 1
        # as exact as Newton's own error calls for, and no more than is asked for
        ratio = max(difference, abs(missing)) / total if total > 0.0 else np.inf
        inner = min(0.1, max(0.3 * ratio, 0.3 * tolerance / ratio))
        direction, moved, used = newton_direction(
            influence,
            matrix,
            contacts.cells,
            space,
            answer - force,
            secant,
            missing if bound else np.nan,
            inner,
            scratch,
        )
        trial = np.minimum(np.maximum(force + direction, 0.0), contacts.limit)
        # a leaving contact's last digits, which the others' rounding would hide
        trial[(answer == 0.0) & (trial < ROUNDING * total)] = 0.0
        trial_pushed, field = interaction_product(influence, matrix, contacts.cells, trial, scratch)
        products += used + 1
        trial_difference, trial_total = contact_response(
            contacts, shift + moved, trial_pushed, trial, answer, secant
        )
        better = trial_difference * total < 0.5 * difference * trial_total
        if bound:
            # no energy to fall back on: the caller brackets where this does not converge
            poor = 0 if better else poor + 1
            if poor > 8:
                break
        elif not better and not given:
            before = energy(contacts, shift, pushed, force)
            after = energy(contacts, shift, trial_pushed, trial)
            better = after < before
            if not better:
                trial = force.copy()
                for _ in range(3):
                    coordinate_sweep(influence.table, contacts, shift, trial)
                trial_pushed, field = interaction_product(
                    influence, matrix, contacts.cells, trial, scratch
                )
                products += 4
                trial_difference, trial_total = contact_response(
                    contacts, shift, trial_pushed, trial, answer, secant
                )
        if given and not better:
            # what was given misled: begin with the interaction of the forces
            trial = force
            trial_pushed, field = interaction_product(
                influence, matrix, contacts.cells, trial, scratch
            )
            products += 1
            moved = 0.0
            trial_difference, trial_total = contact_response(
                contacts, shift, trial_pushed, trial, answer, secant
            )
        given = False
        force, pushed, shift = trial, trial_pushed, shift + moved
        difference, total = trial_difference, trial_total
        missing = target - force.sum() if bound else 0.0
    residual = np.nan  # forces that no overlap answers are no equilibrium
    if difference == 0.0 and missing == 0.0:
        residual = 0.0
    elif total > 0.0 and difference < np.inf and abs(missing) < np.inf:
        residual = max(difference, abs(missing)) / total
    return Equilibrium(force, pushed, field, shift, residual, steps, products)


@kernel
def separate_equilibrium(contacts, shift):
    """Forces (n,) [N] of contacts that do not feel each other."""
    force = np.empty(contacts.overlap.size)
    for i in range(force.size):
        answer = force_of_overlap(
            contacts.overlap[i] + shift, contacts.substrate, contacts.compliance[i]
        )[0]
        force[i] = min(answer, contacts.limit[i])
    return force


@kernel
def separate_shift(contacts, target):
    """Shift D [m] at which contacts that do not feel each other carry a force [N].

    Newton, kept between a shift that is too small and one that is too large;
    from the latter it converges monotonically, as the force is convex in D.
    The upper end where the force jumps there (a rigid contact).
    """
    tallest = np.argmax(contacts.overlap)
    low = -contacts.overlap[tallest]
    # alone, the tallest contact would carry the force at
    shift = low + overlap_of_force(target, contacts.substrate, contacts.compliance[tallest])
    high = np.inf
    for _ in range(200):
        total = 0.0
        slope = 0.0
        for i in range(contacts.overlap.size):
            overlap = contacts.overlap[i] + shift
            force, stiffness = force_of_overlap(overlap, contacts.substrate, contacts.compliance[i])
            total += force
            slope += stiffness
        if total > target:
            high = shift
        else:
            low = shift
        if abs(total - target) <= 1e-14 * target:
            return shift
        following = shift + (target - total) / slope if 0.0 < slope < np.inf else np.inf
        if not low < following < high:
            if high == np.inf:
                return low  # a rigid contact at its first touch
            following = 0.5 * (low + high)
            if not low < following < high:
                return high
        shift = following
    return shift


def solve_equilibrium(
    influence: Influence | None,
    contacts: Contacts,
    start: np.ndarray,
    target: float,
    tolerance: float,
    matrix: np.ndarray | None = None,
    pushed: np.ndarray | None = None,
) -> Equilibrium:
    """Forces in equilibrium at the overlapping cells.

    Parameters
    ----------
    influence : Influence or None
        None in a scene without interaction.
    contacts : Contacts
    start : array (n,)
        Forces to start from [N]: a guess, of which what is not finite or is
        negative counts as 0. A guess that leads nowhere is dropped for 0.
    target : float
        Total force [N] that the shift is to bring about; NaN for a shift of 0.
    tolerance : float
        Relative residual to reach; below `ROUNDING` none does.
    matrix : array (n, n), optional
        The contacts' `influence_matrix` where it is at hand already.
    pushed : array (n,), optional
        The interaction [m] of the forces to start from, or about that, where it is
        at hand: saves a product.

    Returns
    -------
    Equilibrium
        Converged where its residual is at most the tolerance. Infinite forces
        where a rigid contact (flat, without substrate) overlaps. A residual of
        NaN where no equilibrium was found, or there can be none: an overlap or
        a compliance that is not finite, a negative limit, a target that is not
        positive and finite; then all forces are NaN.
    """
    n = contacts.cells.size
    given = (contacts.overlap, contacts.compliance, contacts.substrate)
    sound = all(np.isfinite(values).all() for values in given) and (contacts.limit >= 0.0).all()
    if not sound or target <= 0.0 or math.isinf(target):
        nowhere = np.full(n, np.nan)
        return Equilibrium(nowhere, nowhere.copy(), np.empty((0, 0)), math.nan, math.nan, 0, 0)
    if influence is None or n == 0:
        found = _separate(contacts, float(target))
        return found._replace(residual=max(found.residual, ROUNDING if n else 0.0))
    if matrix is None:
        dense = n <= dense_limit(influence.table.shape)
        matrix = influence_matrix(influence.table, contacts.cells[: n if dense else 0])
    usable = np.where(np.isfinite(start) & (start > 0.0), start, 0.0)
    # an interaction that belongs to a guess which was not taken is of no use
    if pushed is None or not np.isfinite(pushed).all() or not np.array_equal(usable, start):
        pushed = np.empty(0)
    problem, sought = (influence, matrix, contacts), (float(target), float(tolerance))
    found = interacting_equilibrium(*problem, usable, pushed, *sought)
    if not found.residual <= tolerance and usable.any():
        again = interacting_equilibrium(*problem, 0.0 * usable, np.empty(0), *sought)
        again = again._replace(products=again.products + found.products)
        found = again if not found.residual <= again.residual else found
    if not math.isnan(target) and not found.residual <= tolerance:
        found = _bracketed(*problem, *sought, found)
    # how well forces answer their overlaps is not known better than this
    return found._replace(residual=max(found.residual, ROUNDING))


def _separate(contacts: Contacts, target: float) -> Equilibrium:
    """Contacts without interaction: one equation for the shift, if any."""
    given = math.isnan(target) or contacts.cells.size == 0
    shift = 0.0 if given else separate_shift(contacts, target)
    force = separate_equilibrium(contacts, shift)
    total = float(force.sum())
    if given:
        residual = 0.0 if math.isfinite(total) else np.inf
    else:
        residual = abs(total - target) / target if total > 0.0 else np.inf
    return Equilibrium(force, np.zeros(force.size), np.empty((0, 0)), shift, residual, 0, 0)


def _bracketed(influence, matrix, contacts, target, tolerance, start: Equilibrium) -> Equilibrium:
    """The shift as a root of the total force at a given shift, which rises with it."""
    best, products = start, start.products
    if math.isnan(start.residual):
        best = start._replace(force=np.zeros(start.force.size))

    def at(shift: float) -> float:
        nonlocal best, products
        moved = contacts._replace(overlap=contacts.overlap + shift)
        found = interacting_equilibrium(
            influence, matrix, moved, best.force, np.empty(0), np.nan, 0.1 * tolerance
        )
        products += found.products
        best = found._replace(shift=shift)
        return float(found.force.sum()) - target

    low = -float(contacts.overlap.max())
    high = max(start.shift if math.isfinite(start.shift) else low, 0.5 * low)
    for _ in range(_MOST_DOUBLINGS):
        excess = at(high)
        if not excess < 0.0:
            break
        high += high - low
    if not 0.0 <= excess < np.inf:
        return best._replace(residual=math.nan, products=products)
    at(scipy.optimize.brentq(at, low, high, xtol=1e-14 * (high - low), rtol=1e-14))
    missing = abs(float(best.force.sum()) - target) / target
    return best._replace(residual=max(best.residual, missing), products=products)
