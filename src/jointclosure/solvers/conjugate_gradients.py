"""Newton direction towards equilibrium, by preconditioned conjugate gradients."""

import math

import numpy as np

from jointclosure.compilation.kernels import large_kernel
from jointclosure.solvers.coarse_space import patch_shares, precondition
from jointclosure.solvers.interaction_operator import interaction_product
from jointclosure.solvers.products import inner

MOST_CONJUGATE_GRADIENT_STEPS = 1000


@large_kernel
def newton_direction(influence, matrix, cells, space, step, secant, shortfall, tolerance, scratch):
    """Solve (D + K) d = D step + shift by conjugate gradients, D the secant compliances.

    In y = sqrt(D) d the system is I + W K W, W = D^(-1/2). The condition on sum d keeps y in a
    plane. The residual and the preconditioned residual are projected on this plane.
    """
    direction = np.zeros(step.size)
    # most cells that overlap are out of contact
    active = np.arange(step.size) if matrix.size > 0 else np.flatnonzero(secant < np.inf)
    n = active.size
    forces = scratch.ravel()
    for cell in cells:  # forces of contacts that are at their limit
        forces[cell] = 0.0
    cells, step, secant = cells[active], step[active], secant[active]
    weight = np.zeros(n)
    rest = np.zeros(n)
    normal = np.zeros(n)
    for i in range(n):
        if secant[i] < np.inf:
            weight[i] = 1.0 / np.sqrt(secant[i])
            rest[i] = step[i] / weight[i]
    size = np.sqrt(inner(weight, weight))
    bound = not math.isnan(shortfall) and size > 0.0
    solution = np.zeros(n)
    used = 0
    if bound:
        normal = weight / size
        solution = normal * (shortfall / size)
        elastic_displacement = interaction_product(
            influence, matrix, cells, weight * solution, scratch
        )
        rest -= solution + weight * elastic_displacement
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
        image = interaction_product(influence, matrix, cells, weight * search, scratch)
        used += 1
        for i in range(n):
            image[i] = search[i] + weight[i] * image[i]
        length = square / inner(search, image)
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
    for i in range(n):
        direction[active[i]] = weight[i] * solution[i]
    return direction, shift, used
