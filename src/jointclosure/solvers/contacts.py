"""Contacts that may carry force: their laws, their energy, and their separate responses.

The system of all contacts is described in `jointclosure.solvers.equilibrium`.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import (
    MOST_ROOT_STEPS,
    cube_root,
    force_of_overlap,
    force_of_root,
    overlap_of_force,
    root_bound,
    shorter_root,
)


class Contacts(NamedTuple):
    """Contacts that may carry force, in the symbols of `jointclosure.solvers.equilibrium`."""

    cells: np.ndarray  # flat index (n,)
    overlap: np.ndarray  # g (n,) [m], without interaction
    compliance: np.ndarray  # B of the asperities (n,) [m N^(-2/3)]
    limit: np.ndarray  # C, largest force (n,) [N]
    substrate: float  # compliance A [m/N]


@kernel
def contact_roots(contacts, overlap, guess):
    """Compute F^(1/3) (n,) of the contacts at overlaps (n,) [m] from guesses (n,), 0 for none.

    Newton's method is as in `force_of_overlap`, but each step is done for all contacts at once, so
    that steps are vector code. A root that is found is kept.
    """
    n = overlap.size
    substrate = contacts.substrate
    root = np.empty(n)
    unsolved = np.empty(n, np.int64)
    sought = np.empty(n)
    compliance = np.empty(n)
    bound = np.empty(n)
    left = np.ones(n)
    m = 0
    for i in range(n):
        root[i], exact = root_bound(overlap[i], substrate, contacts.compliance[i], guess[i])
        if not exact:
            unsolved[m] = i
            sought[m] = overlap[i]
            compliance[m] = contacts.compliance[i]
            bound[m] = root[i]
            m += 1
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
        root[unsolved[k]] = bound[k]
    return root


@kernel
def contact_response(contacts, shift, elastic_displacement, force, answer, secant):
    """Set answers G = min(C, psi(g + D - K F)) (n,) [N] to forces F, and secants (n,) [m/N].

    ``shift`` is D [m], ``elastic_displacement`` K F (n,) [m]. A secant is the change of a contact's
    overlap over that of its force, from F to G. For equal forces it is the tangent, and infinite
    for an open contact. Return sum |F - G| and sum G [N].
    """
    difference = 0.0
    total = 0.0
    substrate = contacts.substrate
    overlaps = contacts.overlap + shift - elastic_displacement
    present_root = np.zeros(force.size)
    for i in range(force.size):
        if force[i] > 0.0:
            present_root[i] = cube_root(force[i])
    roots = contact_roots(contacts, overlaps, present_root)
    for i in range(force.size):
        overlap = overlaps[i]
        compliance = contacts.compliance[i]
        root = present_root[i]
        new, slope = force_of_root(roots[i], substrate, compliance)
        if new > contacts.limit[i]:
            new = contacts.limit[i]
            slope = 0.0
            overlap = overlap_of_force(new, substrate, compliance)
        answer[i] = new
        step = new - force[i]
        difference += abs(step)
        total += new
        if abs(step) > 1e-7 * force[i]:
            present = (substrate * root + compliance) * root * root
            secant[i] = (overlap - present) / step
        elif slope > 0.0:
            secant[i] = 1.0 / slope
        else:
            secant[i] = np.inf
    return difference, total


@kernel
def energy(contacts, shift, elastic_displacement, force):
    """Compute the energy that equilibrium minimises [J], with K F as ``elastic_displacement``."""
    total = 0.0
    for i in range(force.size):
        root = cube_root(force[i])
        local = 0.5 * contacts.substrate * force[i] + 0.6 * contacts.compliance[i] * root * root
        total += force[i] * (local + 0.5 * elastic_displacement[i] - contacts.overlap[i] - shift)
    return total


@kernel
def coordinate_sweep(table, contacts, shift, force):
    """Minimise the energy exactly contact by contact, in one pass and in place (Gauss-Seidel).

    Return the largest relative change of a force.
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
    """Compute forces (n,) [N] of contacts that do not interact."""
    overlap = contacts.overlap + shift
    root = contact_roots(contacts, overlap, np.zeros(overlap.size))
    return np.minimum(root * root * root, contacts.limit)


@kernel
def separate_shift(contacts, target):
    """Compute the shift D [m] at which contacts without interaction or limit carry a force [N].

    Newton's method for the total force, which increases with the shift, within a bracket: where a
    step leaves it, the bracket is halved instead. The start is the shift at which the tallest
    contact alone carries the force.
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
def start_forces(force, cells, overlap):
    """Return the values of ``force`` (y, x) [N] at cells (n,).

    A negative force, and that of a cell whose walls are apart, is 0.
    """
    start = np.zeros(cells.size)
    flat = force.ravel()
    for i in range(cells.size):
        if overlap[i] > 0.0 and flat[cells[i]] > 0.0:
            start[i] = flat[cells[i]]
    return start


@kernel
def usable_start(force, field):
    """Return a guess of forces (n,) [N], 0 where negative or not finite, and its interaction [m].

    The interaction is ``field`` (y, x), or has no rows if it is not finite or a force was replaced.
    """
    usable = np.zeros(force.size)
    as_given = True
    for i in range(force.size):
        if 0.0 < force[i] < np.inf:
            usable[i] = force[i]
        as_given = as_given and usable[i] == force[i]
    as_given = as_given and np.isfinite(field.sum())
    return usable, field[: field.shape[0] if as_given else 0]


@kernel
def are_sound(contacts):
    """Return whether overlaps and compliances are finite, and no limit is negative or NaN."""
    sound = np.isfinite(contacts.substrate)
    for i in range(contacts.overlap.size):
        finite = np.isfinite(contacts.overlap[i]) and np.isfinite(contacts.compliance[i])
        sound = sound and finite and contacts.limit[i] >= 0.0
    return sound
