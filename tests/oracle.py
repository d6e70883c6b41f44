"""A joint judged by code that shares nothing with the solvers: numpy, dense, plain loops."""

import numpy as np
from scipy.optimize import brentq


def curvature(z, h):
    """Gaussian curvature (y, x) from circles through three points, mirrored at the edges."""
    padded = np.pad(z, 1, mode="reflect")

    def circle(before, here, after):
        a = np.hypot(h, here - before)
        b = np.hypot(h, after - here)
        c = np.hypot(2 * h, after - before)
        area = 0.5 * h * np.abs(before - 2 * here + after)
        return 4 * area / (a * b * c)

    x = circle(padded[1:-1, :-2], z, padded[1:-1, 2:])
    y = circle(padded[:-2, 1:-1], z, padded[2:, 1:-1])
    return np.sqrt(x * y)


def peaks(z):
    """Cells strictly higher than all their neighbours."""
    padded = np.pad(z, 1, constant_values=-np.inf)
    ny, nx = z.shape
    return np.all(
        [
            z > padded[1 + v : 1 + v + ny, 1 + w : 1 + w + nx]
            for v in (-1, 0, 1)
            for w in (-1, 0, 1)
            if v or w
        ],
        axis=0,
    )


def moduli(rock, peak_modulus_ratio, upper_peaks, lower_peaks):
    """E_a* of every pair, and 1/(1/E_t* + 1/E_b*) of the substrates."""
    plain = rock.youngs_modulus / (1 - rock.poisson_ratio**2)
    upper = np.where(upper_peaks, peak_modulus_ratio, 1.0) * plain
    lower = np.where(lower_peaks, peak_modulus_ratio, 1.0) * plain
    return 1 / (1 / upper + 1 / lower), plain / 2


def interaction(force, h, r, modulus):
    """Displacements (y, x) by all other forces, Eqs. (17) to (20), summed one by one."""
    y, x = np.indices(force.shape)
    u = np.zeros(force.shape)
    for v, w in np.argwhere(force > 0):
        zeta = h * np.hypot(y - v, x - w)
        zeta[v, w] = np.inf
        ratio = np.where(np.isinf(zeta), 0.0, r / zeta)
        near = ratio > 0
        z = zeta[near]
        bracket = (2 * r**2 - z**2) * np.arcsin(r / z) + r * np.sqrt(z**2 - r**2)
        u[near] += 3 * force[v, w] / (2 * np.pi * r**2) / (2 * modulus * r) * bracket
    return u


def residual(
    upper,
    lower,
    force,
    *,
    h,
    rock,
    closure,
    first_touch,
    peak_maps,
    substrate=True,
    interacting=True,
    ratio=0.05,
    base_radius_in_cells=0.5,
):
    """Largest misfit of equilibrium [m]: gap where there is force, overlap where none."""
    r = base_radius_in_cells * h
    asperity, rock_modulus = moduli(rock, ratio, *peak_maps)
    u = interaction(force, h, r, rock_modulus) if interacting else np.zeros(force.shape)
    overlap = upper + lower - (first_touch - closure) - u
    kappa = curvature(upper, h) + curvature(lower, h)
    deformation = (9 * kappa * force**2 / (16 * asperity**2)) ** (1 / 3)
    if substrate:
        deformation = deformation + 3 * force / (4 * r * rock_modulus)
    return np.where(force > 0, np.abs(overlap - deformation), np.maximum(overlap, 0.0)).max()


def pressures_over_limit(upper, lower, force, *, h, rock, peak_maps, ratio=0.05):
    """c(nu) p0 / sigma_c of every contact, Eqs. (5), (22), (23)."""
    asperity, _ = moduli(rock, ratio, *peak_maps)
    kappa = curvature(upper, h) + curvature(lower, h)
    deformation = (9 * kappa * force**2 / (16 * asperity**2)) ** (1 / 3)
    pressure = 2 / np.pi * asperity * np.sqrt(deformation * kappa)
    nu = rock.poisson_ratio
    return (0.1251 * nu**2 - 0.536 * nu + 0.7695) * pressure / rock.compressive_strength


def confined(upper, lower, tolerance=1e-11):
    """Pairs of which neither wall's cell has a lower neighbour."""

    def no_lower(z):
        padded = np.pad(z, 1, constant_values=np.inf)
        ny, nx = z.shape
        lowest = np.min(
            [
                padded[1 + v : 1 + v + ny, 1 + w : 1 + w + nx]
                for v in (-1, 0, 1)
                for w in (-1, 0, 1)
                if v or w
            ],
            axis=0,
        )
        return z - lowest <= tolerance

    return no_lower(upper) & no_lower(lower)


def force_of_single_contact(overlap, curvature_, asperity, rock_modulus, r):
    """Force of one contact on its substrates, by bisection."""

    def misfit(force):
        own = (9 * curvature_ * force**2 / (16 * asperity**2)) ** (1 / 3)
        return own + 3 * force / (4 * r * rock_modulus) - overlap

    return brentq(misfit, 0.0, 2 * overlap * 4 * r * rock_modulus / 3, xtol=1e-300, rtol=1e-15)
