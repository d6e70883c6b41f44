"""Newton direction towards equilibrium, by conjugate gradients preconditioned by patches of cells.

Conjugate gradients are slow for smooth fields, where many contacts displace each other over long
distances. The preconditioner removes most of the smooth part of the residual: the contacts of a
patch of several cells share one overlap, and a small dense system between the patches is inverted
once and applied many times.
"""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.solvers.interaction_operator import (
    Influence,
    add_scaled_displacements,
    single_product,
)
from jointclosure.solvers.products import inner, symmetric_inverse, symmetric_times

MOST_CONJUGATE_GRADIENT_STEPS = 1000  # products of one Newton direction, which ends there
_FEWEST_CONTACTS = 100
"""Number of contacts from which there is a preconditioner; with fewer, plain steps are cheaper."""


@large_kernel
def newton_direction(
    influence, matrix, cells, space, step, secant, shortfall, tolerance, displacement
):
    """Solve (D + K) d = D step + shift by conjugate gradients, D the secant compliances.

    It differs from the textbook's conjugate gradients with a preconditioner in four ways. The
    unknowns are scaled: with y = sqrt(D) d the system is I + W K W, W = D^(-1/2). If a
    ``shortfall`` [N] of the total force is given, the sum of d is equal to it, so that y lies in a
    plane: residual and preconditioned residual are projected on this plane, and the shift is the
    Lagrange multiplier of this condition. Products with K are in single precision, which limits the
    residual. The displacement K d, summed from these products, is added to ``displacement`` in
    place, without another product. The iteration also ends when the product of residual and
    preconditioned residual is no longer positive, where only rounding is left, and after
    `MOST_CONJUGATE_GRADIENT_STEPS` products.

    Parameters
    ----------
    influence, matrix, cells
        Interaction K [m/N], as a convolution or a matrix, and the cells (n,) of the contacts.
    space : CoarseSpace
        Preconditioner.
    step, secant
        Step (n,) [N] that each contact would take alone, and its secant compliance (n,) [m/N],
        infinite if it is open.
    shortfall
        Missing total force [N], NaN if the shift is given.
    tolerance
        Norm of the residual in y over that at the start, at which the iteration ends.
    displacement
        Displacements [m] by the present forces, as `Iterate.field`; changed in place.

    Returns
    -------
    The direction d (n,) [N], 0 for open contacts, the change of the shift [m], 0 if the shift is
    given, and the number of products.
    """
    # most cells that overlap without interaction are out of contact with it
    active = np.arange(step.size) if matrix.size > 0 else np.flatnonzero(secant < np.inf)
    n = active.size
    cells = cells[active]
    weight, rest = scaled_steps(step[active], secant[active])
    normal = np.zeros(n)
    size = np.sqrt(inner(weight, weight))
    bound = not math.isnan(shortfall) and size > 0.0
    solution = np.zeros(n)
    image = np.zeros(n)
    used = 0
    if bound:
        normal = weight / size
        solution = normal * (shortfall / size)
        product, unit = single_product(influence, matrix, cells, weight * solution)
        add_scaled_displacements(influence, matrix, 1.0, product, unit, displacement)
        rest -= solution + weight * product
        used += 1
    # the shift removes the part of the residual along the normal
    shift = -inner(normal, rest) / size if bound else 0.0
    inside = rest + normal * (shift * size) if bound else rest
    shares = patch_shares(space, influence, cells, weight)
    across = precondition(space, shares, normal)
    depth = inner(normal, across) if bound else 1.0
    search = precondition(space, shares, inside)
    search -= across * (inner(normal, search) / depth)
    square = inner(inside, search)
    enough = tolerance * tolerance * inner(inside, inside)
    # not positive: the plane is a point, or only rounding errors are left
    while square > 0.0 and inner(inside, inside) > enough and used < MOST_CONJUGATE_GRADIENT_STEPS:
        product, unit = single_product(influence, matrix, cells, weight * search)
        used += 1
        for i in range(n):
            image[i] = search[i] + weight[i] * product[i]
        length = square / inner(search, image)
        add_scaled_displacements(influence, matrix, length, product, unit, displacement)
        along = inner(normal, image)
        for i in range(n):
            solution[i] += length * search[i]
            inside[i] -= length * (image[i] - along * normal[i])
        if bound:
            shift += length * along / size
        ahead = precondition(space, shares, inside)
        ahead -= across * (inner(normal, ahead) / depth)
        following = inner(inside, ahead)
        for i in range(n):
            search[i] = ahead[i] + following / square * search[i]
        square = following
    direction = np.zeros(step.size)
    for i in range(n):
        direction[active[i]] = weight[i] * solution[i]
    return direction, shift, used


@kernel
def scaled_steps(step, secant):
    """Return weights W = D^(-1/2) (n,) of contacts, and their scaled steps (n,), step / W.

    D is the secant compliance (n,) [m/N] of each contact, ``step`` (n,) [N] its step alone. Both
    results are 0 for open contacts, which have an infinite D.
    """
    weight = np.empty(step.size)
    scaled = np.empty(step.size)
    for i in range(step.size):
        of_contact = 1.0 / np.sqrt(secant[i])
        step_of_contact = step[i] / of_contact
        # selections and not branches, so that this becomes vector code
        touches = secant[i] < np.inf
        weight[i] = of_contact if touches else 0.0
        scaled[i] = step_of_contact if touches else 0.0
    return weight, scaled


class CoarseSpace(NamedTuple):
    """Preconditioner of conjugate gradients: a system of equations between patches of cells.

    It differs from the textbook's two-level methods in three ways. The coarse functions are
    constant overlaps of the contacts of a patch. There is no smoothing, as conjugate gradients
    remove the rest. The coarse system is made not of the influence matrix of the contacts but of
    the mean influence between whole patches. It can still be used when contacts and stiffnesses
    have changed; contacts in patches that had no contact when it was made are then not
    preconditioned.
    """

    number: np.ndarray  # of each patch of the grid (p,) in the system; -1: not in it
    inverse: np.ndarray  # of the system between the patches (c, c)


class Shares(NamedTuple):
    """Values of the coarse functions Z of a `CoarseSpace` at the m contacts in its patches."""

    contact: np.ndarray  # index of the contact among all contacts (m,)
    patch: np.ndarray  # number (m,) of the contact's patch in the system
    share: np.ndarray  # value of the patch's function at the contact (m,), of norm 1 per patch


NO_COARSE_SPACE = CoarseSpace(np.empty(0, np.int64), np.empty((0, 0)))
"""A `CoarseSpace` without patches, which changes nothing."""


@large_kernel
def coarse_space(influence: Influence, cells, stiffness):
    """Return the preconditioner of contacts: their patches, and the inverse of their system.

    ``cells`` (n,) are the cells of the contacts, ``stiffness`` (n,) [N/m] is 0 for an open contact,
    which is left out. There are no patches for fewer than `_FEWEST_CONTACTS` cells, or for the
    influence of `dense_influence`. In y = d / sqrt(k), with the stiffness k, the system of all
    contacts is A = I + W K W, W = sqrt(k). The coarse function of a patch P is z_P = W 1_P /
    sqrt(s_P), with the sum s_P of the stiffnesses in the patch. Z^T A Z is then I + sqrt(s_P s_Q)
    K_PQ, with the mean influence K_PQ between the contacts of two patches. It is approximated by
    the mean over all cells of both patches.
    """
    n = cells.size
    if n < _FEWEST_CONTACTS or influence.patch_table.size == 0:
        return CoarseSpace(np.empty(0, np.int64), np.empty((0, 0)))  # `NO_COARSE_SPACE`
    rows, columns = influence.patch_table.shape
    number = np.full(rows * columns, -1)
    place = np.empty((rows * columns, 2), np.int64)
    count = 0
    for i in range(n):
        patch = influence.patch_of[cells[i]]
        # a patch without contacts is not coupled with others
        if number[patch] < 0 and stiffness[i] > 0.0:
            number[patch] = count
            place[count, 0], place[count, 1] = divmod(patch, columns)
            count += 1
    total = np.zeros(count)
    for i in range(n):
        if stiffness[i] > 0.0:
            total[number[influence.patch_of[cells[i]]]] += stiffness[i]
    system = np.empty((count, count))
    root = np.sqrt(total)
    for p in range(count):
        for q in range(p + 1):
            distance = (abs(place[p, 0] - place[q, 0]), abs(place[p, 1] - place[q, 1]))
            system[p, q] = root[p] * root[q] * influence.patch_table[distance]
            system[q, p] = system[p, q]
        system[p, p] += 1.0
    return CoarseSpace(number, symmetric_inverse(system))


@kernel
def patch_shares(space: CoarseSpace, influence: Influence, cells, weight):
    """Return the `Shares` of contacts in the patches of a preconditioner.

    ``cells`` (n,) are the cells of the contacts, ``weight`` (n,) their weights W of `scaled_steps`.
    The share of a contact is its weight over the norm of all weights in its patch. Open contacts,
    of weight 0, and contacts in patches that are not in the system are left out.
    """
    n = weight.size
    count = space.inverse.shape[0]
    contact = np.empty(n if count > 0 else 0, np.int64)
    patch = np.empty(contact.size, np.int64)
    square = np.zeros(count)
    m = 0
    for i in range(contact.size):
        number = space.number[influence.patch_of[cells[i]]]
        if weight[i] > 0.0 and number >= 0:
            square[number] += weight[i] * weight[i]
            contact[m] = i
            patch[m] = number
            m += 1
    contact = contact[:m]
    patch = patch[:m]
    norm = np.sqrt(square)
    share = np.empty(m)
    for k in range(m):
        share[k] = weight[contact[k]] / norm[patch[k]]
    return Shares(contact, patch, share)


@kernel
def precondition(space: CoarseSpace, shares: Shares, residual):
    """Return the preconditioned residual (n,) of contacts, (I + Z (E^-1 - I) Z^T) residual.

    E is the system between the patches, Z the coarse functions in ``shares``. Without patches it is
    a copy of the residual.
    """
    answer = residual.copy()
    count = space.inverse.shape[0]
    if count == 0:
        return answer
    contact = shares.contact
    patch = shares.patch
    share = shares.share
    coarse = np.zeros(count)
    for k in range(contact.size):
        coarse[patch[k]] += share[k] * residual[contact[k]]
    coarse = symmetric_times(space.inverse, coarse) - coarse
    for k in range(contact.size):
        answer[contact[k]] += share[k] * coarse[patch[k]]
    return answer
