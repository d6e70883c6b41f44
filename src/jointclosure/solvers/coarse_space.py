"""Preconditioner of the interaction from patches of cells with a common displacement.

The conjugate gradients of `jointclosure.solvers.newton` are slow for smooth fields, where many
contacts displace each other over long distances. Patches of several cells, whose contacts share one
overlap, remove most of these: a small dense system between the patches is solved once and applied
many times.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.solvers.interaction_operator import Influence
from jointclosure.solvers.products import symmetric_inverse, symmetric_times

_FEWEST_CONTACTS = 100
"""Smallest number of contacts for patches; with fewer, plain steps are cheaper."""


class CoarseSpace(NamedTuple):
    """Patch (n,) of each contact, -1 for none, and the inverse (c, c) of the patches' system."""

    patch: np.ndarray
    inverse: np.ndarray


class Shares(NamedTuple):
    """Contacts (m,) with a share in a patch, the patch (m,), and the share (m,)."""

    contact: np.ndarray
    patch: np.ndarray
    share: np.ndarray


@kernel
def no_coarse_space(n):
    """Return a `CoarseSpace` of contacts (n,) without patches, which changes nothing."""
    return CoarseSpace(np.full(n, -1), np.empty((0, 0)))


@large_kernel
def coarse_space(influence: Influence, cells, stiffness):
    """Make patches of contacts, and the inverse of the system between them.

    Parameters
    ----------
    influence : Influence
    cells : int64 array (n,)
        Flat indices of the contacts.
    stiffness : array (n,)
        k [N/m], the slopes of the contacts' laws; 0 without contact.

    Returns
    -------
    CoarseSpace
        Without patches (c = 0) if the contacts are few or the influence has no patches.

    Notes
    -----
    In y = d / sqrt(k) the system is A = I + W K W, W = sqrt(k). With
    z_P = W 1_P / sqrt(s_P), s_P the stiffness of a patch, Z^T A Z is
    I + sqrt(s_P s_Q) K_PQ, K_PQ the mean influence between two patches, which is
    approximated by the mean over all their cells instead of their contacts.
    """
    n = cells.size
    if n < _FEWEST_CONTACTS or influence.patch_table.size == 0:
        return no_coarse_space(n)
    patch = np.full(n, -1)
    nx = influence.table.shape[1]
    side = influence.patch
    rows, columns = influence.patch_table.shape
    of_contact = np.empty(n, np.int64)
    stiff = np.zeros(rows * columns, np.bool_)
    for i in range(n):
        y, x = divmod(cells[i], nx)
        of_contact[i] = (y // side) * columns + x // side
        stiff[of_contact[i]] |= stiffness[i] > 0.0
    number = np.full(rows * columns, -1)
    place = np.empty((rows * columns, 2), np.int64)
    count = 0
    for i in range(n):
        # a patch without contacts is not coupled with others
        if number[of_contact[i]] < 0 and stiff[of_contact[i]]:
            number[of_contact[i]] = count
            place[count, 0], place[count, 1] = divmod(of_contact[i], columns)
            count += 1
        patch[i] = number[of_contact[i]]
    total = np.zeros(count)
    for i in range(n):
        if patch[i] >= 0:
            total[patch[i]] += stiffness[i]
    system = np.empty((count, count))
    for p in range(count):
        for q in range(p + 1):
            distance = (abs(place[p, 0] - place[q, 0]), abs(place[p, 1] - place[q, 1]))
            system[p, q] = np.sqrt(total[p] * total[q]) * influence.patch_table[distance]
            system[q, p] = system[p, q]
        system[p, p] += 1.0
    return CoarseSpace(patch, symmetric_inverse(system))


@kernel
def patch_shares(space: CoarseSpace, weight):
    """Return the `Shares` of the contacts in their patches: W over its norm in the patch."""
    n, count = weight.size, space.inverse.shape[0]
    contact = np.empty(n if count > 0 else 0, np.int64)
    square = np.zeros(count)
    m = 0
    for i in range(contact.size):
        if weight[i] > 0.0 and space.patch[i] >= 0:
            square[space.patch[i]] += weight[i] * weight[i]
            contact[m] = i
            m += 1
    contact = contact[:m]
    patch, share = np.empty(m, np.int64), np.empty(m)
    for k in range(m):
        patch[k] = space.patch[contact[k]]
        share[k] = weight[contact[k]] / np.sqrt(square[patch[k]])
    return Shares(contact, patch, share)


@kernel
def precondition(space: CoarseSpace, shares: Shares, residual):
    """Multiply a residual (n,) by (I + Z (E^-1 - I) Z^T), E the patches' system."""
    answer = residual.copy()
    count = space.inverse.shape[0]
    if count == 0:
        return answer
    contact, patch, share = shares.contact, shares.patch, shares.share
    coarse = np.zeros(count)
    for k in range(contact.size):
        coarse[patch[k]] += share[k] * residual[contact[k]]
    coarse = symmetric_times(space.inverse, coarse) - coarse
    for k in range(contact.size):
        answer[contact[k]] += share[k] * coarse[patch[k]]
    return answer
