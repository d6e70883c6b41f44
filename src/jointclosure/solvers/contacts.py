"""Contacts that may carry force: their laws, their energy, and their separate responses.

The system of all contacts is described in `jointclosure.solvers.equilibrium`.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.mechanics.contact import (
    MOST_ROOT_STEPS,
    bound_by_guess,
    bound_by_terms,
    cube_root,
    force_of_overlap,
    force_of_root,
    overlap_of_force,
    shorter_root,
)


class Contacts(NamedTuple):
    """Contacts that may carry force, in the symbols of `jointclosure.solvers.equilibrium`."""

    cells: np.ndarray  # flat index (n,)
    overlap: np.ndarray  # g (n,) [m], without interaction; negative where the walls are apart
    compliance: np.ndarray  # B of the asperities (n,) [m N^(-2/3)]
    limit: np.ndarray  # C, largest force (n,) [N]
    substrate: float  # compliance A [m/N]


@large_kernel
def contact_roots(contacts, overlap, guess):
    """Compute F^(1/3) (n,) of contacts at overlaps (n,) [m], starting from guesses of it (n,).

    A guess of 0 stands for none. The root is 0 where the overlap is not positive; the limits of the
    forces are not applied. Newton's method is as in `force_of_overlap`, but each step is done for
    all contacts at once, so that steps become vector code. A root that is found does not change any
    more.
    """
    n = overlap.size
    substrate = contacts.substrate
    root = np.zeros(n)
    pressed = np.empty(n, np.int64)
    m = 0
    for i in range(n):
        pressed[m] = i
        m += overlap[i] > 0.0  # without a branch, because it would be unpredictable
    sought = np.empty(m)
    compliance = np.empty(m)
    start = np.empty(m)
    for k in range(m):
        sought[k] = overlap[pressed[k]]
        compliance[k] = contacts.compliance[pressed[k]]
        start[k] = guess[pressed[k]]
    bound = np.empty(m)
    left = np.empty(m)
    for k in range(m):
        bound[k], is_bound = bound_by_guess(sought[k], substrate, compliance[k], start[k])
        left[k] = 1.0 if is_bound else 0.0
    for k in range(m):
        if left[k] == 0.0:
            bound[k], exact = bound_by_terms(sought[k], substrate, compliance[k])
            left[k] = 0.0 if exact else 1.0
    for _ in range(MOST_ROOT_STEPS):
        number = 0.0
        for k in range(m):
            t, exact = shorter_root(sought[k], substrate, compliance[k], bound[k])
            bound[k] = t if left[k] > 0.0 else bound[k]
            left[k] = 0.0 if exact else left[k]
        for k in range(m):
            number = max(number, left[k])
        if number == 0.0:
            break
    for k in range(m):
        root[pressed[k]] = bound[k]
    return root


@kernel
def contact_response(contacts, shift, elastic_displacement, force, answer, secant):
    """Set ``answer`` (n,) [N] to G = min(C, psi(g + D - K F)), and ``secant`` (n,) [m/N].

    The answers G are the forces that the contacts would carry at the overlaps that the forces F
    (n,) [N] leave. ``shift`` is D [m], ``elastic_displacement`` is K F (n,) [m]. A secant is the
    change of the overlap of the contact law over the change of force, from F to G. Where F and G
    are equal it is the tangent, which is infinite for a contact that is open or at its limit.
    Return sum |F - G| and sum G [N].
    """
    n = force.size
    substrate = contacts.substrate
    overlaps = contacts.overlap + shift - elastic_displacement
    # selections and not branches, so that loops become vector code
    present_root = np.empty(n)
    for i in range(n):
        root = cube_root(force[i])
        present_root[i] = root if force[i] > 0.0 else 0.0
    roots = contact_roots(contacts, overlaps, present_root)
    slopes = np.empty(n)
    for i in range(n):
        answer[i], slopes[i] = force_of_root(roots[i], substrate, contacts.compliance[i])
    for i in range(n):
        if answer[i] > contacts.limit[i]:
            answer[i] = contacts.limit[i]
            slopes[i] = 0.0
            overlaps[i] = overlap_of_force(answer[i], substrate, contacts.compliance[i])
    for i in range(n):
        root = present_root[i]
        step = answer[i] - force[i]
        present = (substrate * root + contacts.compliance[i]) * root * root
        of_step = (overlaps[i] - present) / step
        tangent = 1.0 / slopes[i]
        tangent = tangent if slopes[i] > 0.0 else np.inf
        secant[i] = of_step if abs(step) > 1e-7 * force[i] else tangent
    difference = 0.0
    total = 0.0
    for i in range(n):
        difference += abs(answer[i] - force[i])
        total += answer[i]
    return difference, total


@kernel
def energy(contacts, shift, elastic_displacement, force):
    """Compute the energy [J] of contacts under forces F (n,) [N], which equilibrium minimises.

    ``shift`` is D [m], ``elastic_displacement`` is K F (n,) [m], see `solvers.equilibrium`.
    """
    total = 0.0
    for i in range(force.size):
        root = cube_root(force[i])
        local = 0.5 * contacts.substrate * force[i] + 0.6 * contacts.compliance[i] * root * root
        total += force[i] * (local + 0.5 * elastic_displacement[i] - contacts.overlap[i] - shift)
    return total


@kernel
def coordinate_sweep(table, contacts, shift, force):
    """Minimise the energy of contacts exactly one by one, in one pass over forces (n,) [N].

    The forces are changed in place (Gauss-Seidel). ``table`` is `Influence.table` [m/N], ``shift``
    is D [m]. Return the largest relative change of a force, infinite if one falls to 0.
    """
    nx = table.shape[1]
    cells = contacts.cells
    change = 0.0
    for i in range(force.size):
        y, x = divmod(cells[i], nx)
        elastic_displacement = 0.0
        for j in range(force.size):
            if force[j] > 0.0:
                v, w = divmod(cells[j], nx)
                elastic_displacement += table[abs(y - v), abs(x - w)] * force[j]
        overlap = contacts.overlap[i] + shift - elastic_displacement
        answer = force_of_overlap(overlap, contacts.substrate, contacts.compliance[i])[0]
        answer = min(answer, contacts.limit[i])
        if answer != force[i]:
            change = max(change, abs(answer - force[i]) / answer if answer > 0.0 else np.inf)
        force[i] = answer
    return change


@kernel
def separate_equilibrium(contacts, shift):
    """Compute forces (n,) [N] of contacts that do not interact, at a shift D [m].

    No force exceeds its limit.
    """
    overlap = contacts.overlap + shift
    root = contact_roots(contacts, overlap, np.zeros(overlap.size))
    return np.minimum(root * root * root, contacts.limit)


@kernel
def separate_shift(contacts, target):
    """Compute the shift D [m] at which contacts (n,), n > 0, carry a total force ``target`` [N].

    Interaction and the limits of the forces are left out. It is found by Newton's method for the
    total force, which increases with the shift, within a bracket: where a step leaves it, the
    bracket is halved instead. The start is the shift at which the tallest contact alone carries the
    force. If a rigid contact can carry any force, the result is the shift at which it touches.
    """
    tallest = 0
    for i in range(1, contacts.overlap.size):
        if contacts.overlap[i] > contacts.overlap[tallest]:
            tallest = i
    unknown = np.zeros(contacts.overlap.size)
    low = -contacts.overlap[tallest]
    shift = low + overlap_of_force(target, contacts.substrate, contacts.compliance[tallest])
    high = np.inf
    for _ in range(200):
        total = 0.0
        slope = 0.0
        root = contact_roots(contacts, contacts.overlap + shift, unknown)
        for i in range(root.size):
            compliance = contacts.compliance[i]
            force, stiffness = force_of_root(root[i], contacts.substrate, compliance)
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


@kernel
def unlimited(cells, overlap, compliance, substrate):
    """Return `Contacts` whose forces have no limit."""
    return Contacts(cells, overlap, compliance, np.full(cells.size, np.inf), substrate)


@kernel
def contacts_among(contacts, slot, cells):
    """Return contacts (n,) extended to more cells (m,), among which they have the indices ``slot``.

    The other cells get an overlap of -1 m, and are therefore not in contact.
    """
    overlap = np.full(cells.size, -1.0)
    compliance = np.ones(cells.size)
    limit = np.full(cells.size, np.inf)
    for i in range(slot.size):
        overlap[slot[i]] = contacts.overlap[i]
        compliance[slot[i]] = contacts.compliance[i]
        limit[slot[i]] = contacts.limit[i]
    return Contacts(cells, overlap, compliance, limit, contacts.substrate)


@kernel
def start_forces(force, cells, overlap):
    """Return the forces (n,) [N] at cells (n,) of a field ``force`` (y, x) [N], none negative.

    A negative force counts as 0, and so does any force of a cell whose ``overlap`` (n,) [m] is not
    positive, where the walls are apart.
    """
    start = np.empty(cells.size)
    flat = force.ravel()
    for i in range(cells.size):
        present = flat[cells[i]]
        start[i] = present if (overlap[i] > 0.0) & (present > 0.0) else 0.0
    return start


@kernel
def usable_start(force, field):
    """Return starting forces (n,) [N] that are usable, and their interaction ``field`` (y, x) [m].

    A given force that is negative or not finite is replaced by 0. If any force was replaced, or a
    value of the field is not finite, the returned field has no rows.
    """
    usable = np.empty(force.size)
    changed = 0
    for i in range(force.size):
        given = force[i]
        usable[i] = given if (given > 0.0) & (given < np.inf) else 0.0
        changed += usable[i] != given
    for row in field:
        for x in range(row.size):
            changed += not (abs(row[x]) < np.inf)
    return usable, field[: field.shape[0] if changed == 0 else 0]


@kernel
def are_sound(contacts):
    """Return whether contacts can be solved.

    Their overlaps, the compliances of their asperities and that of the substrates must be finite,
    and their limits of force at least 0, or infinite. Signs of compliances are not checked.
    """
    sound = np.isfinite(contacts.substrate)
    for i in range(contacts.overlap.size):
        finite = np.isfinite(contacts.overlap[i]) and np.isfinite(contacts.compliance[i])
        sound = sound and finite and contacts.limit[i] >= 0.0
    return sound
