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

MOST_CONJUGATE_GRADIENT_STEPS = 1000  # of one Newton direction, which then is what was reached
_FEWEST_CONTACTS = 100
"""Smallest number of contacts for patches; with fewer, plain steps are cheaper."""


@large_kernel
def newton_direction(
    influence, matrix, cells, space, step, secant, shortfall, tolerance, displacement
):
    """Solve (D + K) d = D step + shift by conjugate gradients, D the secant compliances.

    It differs from the textbook's conjugate gradients with a preconditioner in four ways. The
    unknowns are scaled: in y = sqrt(D) d the system is I + W K W, W = D^(-1/2). A ``shortfall`` [N]
    of the total force, if given, is the sum of d, so that y lies in a plane: residual and
    preconditioned residual are projected on this plane, and the shift is the Lagrange multiplier of
    the condition. Products with K are in single precision, which limits the residual. Their sum is
    the displacement K d, which is added to ``displacement`` (see `Iterate.field`) without another
    product. The iteration also ends when the product of residual and preconditioned residual is no
    longer positive, where only rounding is left.

    Parameters
    ----------
    influence, matrix, cells
        Interaction, as a convolution or a matrix, and the cells (n,) of the contacts.
    space : CoarseSpace
        Preconditioner.
    step, secant
        Step (n,) [N] of each contact alone, and secant compliance (n,) [m/N], infinite if open.
    shortfall
        Missing total force [N], NaN if the shift is given.
    tolerance
        Largest norm of the residual of y over that at the start.
    displacement
        Interaction [m] of the present forces.

    Returns
    -------
    The direction d (n,) [N], the shift [m], and the number of products.
    """
    # most cells that overlap are out of contact
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
    """Return weights W = D^(-1/2) (n,) and scaled steps W^-1 step (n,), 0 for open contacts."""
    weight = np.empty(step.size)
    scaled = np.empty(step.size)
    for i in range(step.size):
        of_contact = 1.0 / np.sqrt(secant[i])
        step_of_contact = step[i] / of_contact
        # selections and not branches, so that this is vector code
        touches = secant[i] < np.inf
        weight[i] = of_contact if touches else 0.0
        scaled[i] = step_of_contact if touches else 0.0
    return weight, scaled


class CoarseSpace(NamedTuple):
    """Preconditioner of conjugate gradients: a system between patches of cells.

    It differs from the textbook's two-level methods: coarse functions are constant overlaps of the
    contacts of a patch, there is no smoothing, as conjugate gradients remove the rest, and the
    coarse system is not made of the matrix but of the mean influence between whole patches. It
    stays a preconditioner when contacts and stiffnesses change; contacts in new patches have no
    share.
    """

    number: np.ndarray  # of each patch of the grid (p,) in the system, -1 without contact
    inverse: np.ndarray  # of the system between the patches (c, c)


class Shares(NamedTuple):
    """Coarse functions Z at the m contacts that are in a patch of the coarse space."""

    contact: np.ndarray  # index of the contact (m,)
    patch: np.ndarray  # its patch (m,)
    share: np.ndarray  # value of the patch's function, of norm 1 over the patch (m,)


NO_COARSE_SPACE = CoarseSpace(np.empty(0, np.int64), np.empty((0, 0)))
"""A `CoarseSpace` without patches, which changes nothing."""


@large_kernel
def coarse_space(influence: Influence, cells, stiffness):
    """Make patches of contacts, and the inverse of the system between them.

    In y = d / sqrt(k) the system is A = I + W K W, W = sqrt(k). With z_P = W 1_P / sqrt(s_P), s_P
    the stiffness of a patch, Z^T A Z is I + sqrt(s_P s_Q) K_PQ, K_PQ the mean influence between two
    patches, which is approximated by the mean over all their cells instead of their contacts.
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
    """Return the `Shares` of the contacts in the patches of the preconditioner's coarse space.

    A share is the weight W of a contact over the norm of all weights in its patch of cells.
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
    """Multiply a residual (n,) by (I + Z (E^-1 - I) Z^T), E the patches' system."""
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
