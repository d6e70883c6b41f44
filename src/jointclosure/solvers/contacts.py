"""Contacts that may carry force: their laws, their energy, and what they do one by one.

The problem that they pose together is in `jointclosure.solvers.equilibrium`.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import (
    cube_root,
    force_near,
    force_of_overlap,
    overlap_of_force,
)


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


@kernel
def contact_response(contacts, shift, elastic_displacement, force, answer, secant):
    """Forces that answer the overlaps, and secants from the present forces.

    Parameters
    ----------
    contacts : Contacts
    shift : float
        D [m].
    elastic_displacement, force : array (n,)
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
        overlap = contacts.overlap[i] + shift - elastic_displacement[i]
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
def energy(contacts, shift, elastic_displacement, force):
    """The energy that equilibrium minimises [J], K F given as ``elastic_displacement``."""
    total = 0.0
    for i in range(force.size):
        root = cube_root(force[i])
        own = 0.5 * contacts.substrate * force[i] + 0.6 * contacts.compliance[i] * root * root
        total += force[i] * (own + 0.5 * elastic_displacement[i] - contacts.overlap[i] - shift)
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


@kernel
def are_sound(contacts):
    """Whether overlaps and compliances are finite, and no limit negative or NaN."""
    sound = np.isfinite(contacts.substrate)
    for i in range(contacts.overlap.size):
        finite = np.isfinite(contacts.overlap[i]) and np.isfinite(contacts.compliance[i])
        sound = sound and finite and contacts.limit[i] >= 0.0
    return sound
