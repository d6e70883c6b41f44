"""The paper's formulas as printed, those of the package, and exact values.

Eqs. (13), (17) and (29) as in the paper, in plain numpy and double precision; the package's forms
of the same; and exact values by mpmath in 50 digits for the same double-precision inputs. They show
the errors of each form.
"""

from typing import Any

import mpmath
import numpy as np
import pandas as pd
import scipy

from jointclosure.mechanics.contact import force_of_overlap
from jointclosure.mechanics.interaction import interaction_displacement
from jointclosure.statistics.indifference import indifference_interval

DIGITS = 50
OVERLAP = 1e-6
"""delta_S for the errors of the cubic [m]; they depend only on the stiffness ratio g."""
MEANS, DEVIATIONS, SAMPLES = (0.091, 0.081, 0.074), (0.0081, 0.0078, 0.0083), 20
"""Closures [mm] and their deviations for the errors of the quartic, near those of dolerite."""


def deformations_as_printed(overlap: float, gamma: float, sign: int) -> np.ndarray:
    """Compute delta_a [m] (upper and lower sign, cube root, principal first), Eqs. (11), (13)."""
    under = complex(sign * (81.0 * gamma**2 * overlap**2 - 12.0 * overlap))
    signs = np.array([[1.0], [-1.0]])
    with np.errstate(divide="ignore", invalid="ignore"):  # failures of the formula are measured
        cube = (2.0 - 27.0 * gamma**2 * overlap + signs * 3.0 * gamma * np.sqrt(under)) / 2.0
        root = cube ** (1.0 / 3.0) * np.exp(2j * np.pi / 3.0 * np.arange(3.0))
        return (-1.0 / (3.0 * gamma) * (1.0 + root + 1.0 / root)) ** 2


def deformation_by_force(overlap: float, gamma: float) -> float:
    """Compute delta_a [m] as the package does, through the force."""
    force, _ = force_of_overlap(overlap, gamma, 1.0)  # the unit of force is arbitrary
    return float(np.cbrt(force) ** 2)


def exact_deformation(overlap: float, gamma: float) -> mpmath.mpf:
    """Compute delta_a [m]: the positive root x of gamma x^3 + x^2 = delta_S, squared, Eq. (10)."""
    with mpmath.workdps(DIGITS + 20):
        d, g = mpmath.mpf(overlap), mpmath.mpf(gamma)
        x = mpmath.sqrt(d)
        if g:
            x = min(x, mpmath.cbrt(d / g))
        for _ in range(200):  # from the right to the root of a convex function
            shorter = x - (g * x**3 + x**2 - d) / (3 * g * x**2 + 2 * x)
            if abs(shorter - x) <= x * mpmath.mpf(10) ** -(DIGITS + 10):
                return shorter**2
            x = shorter
    raise ArithmeticError(f"gamma = {gamma}, delta_S = {overlap}: no root in 200 steps")


def cubic_errors(ratios: np.ndarray) -> pd.DataFrame:
    """Compute relative errors of delta_a at stiffness ratios g = gamma sqrt(delta_S) (k,)."""
    rows = []
    for g in ratios:
        gamma = float(g / np.sqrt(OVERLAP))
        exact = exact_deformation(OVERLAP, gamma)
        printed, corrected = (deformations_as_printed(OVERLAP, gamma, sign) for sign in (-1, 1))
        # of both signs and all cube roots: what remains once misprint and branch are corrected
        series: dict[str, Any] = {
            "Eq. (13) as printed": printed[:, 0],
            "sign corrected, principal root": corrected[:, 0],
            "sign corrected, best root": corrected.ravel(),
            "jointclosure": [deformation_by_force(OVERLAP, gamma)],
        }
        for name, values in series.items():
            rows.append((name, g, min(relative_error(complex(value), exact) for value in values)))
    return _table("cubic", rows)


def displacement_as_printed(distance: float, base_radius: float, modulus: float) -> float:
    """Compute displacement per unit force [m/N] by Eqs. (17) and (19) as printed."""
    zeta, r = np.float64(distance), np.float64(base_radius)
    pressure = 3.0 / (2.0 * np.pi * r**2)
    bracket = (2.0 * r**2 - zeta**2) * np.arcsin(r / zeta) + r * np.sqrt(zeta**2 - r**2)
    return float(pressure / (2.0 * modulus * r) * bracket)


def exact_displacement(distance: float, base_radius: float, modulus: float) -> mpmath.mpf:
    """Compute `displacement_as_printed` exactly, with more digits than cancel."""
    with mpmath.workdps(DIGITS + 60):
        zeta, r, e = (mpmath.mpf(float(value)) for value in (distance, base_radius, modulus))
        root = mpmath.sqrt((zeta - r) * (zeta + r))
        bracket = (2 * r**2 - zeta**2) * mpmath.asin(r / zeta) + r * root
        return 3 * bracket / (4 * mpmath.pi * e * r**3)


def far_field_errors(ratios: np.ndarray) -> pd.DataFrame:
    """Compute relative errors of the displacement at distances zeta/r (k,)."""
    forms = {"Eq. (17) as printed": displacement_as_printed, OURS: interaction_displacement}
    rows = []
    for ratio in ratios:
        arguments = (0.125e-3 * float(ratio), 0.125e-3, 40e9)
        exact = exact_displacement(*arguments)
        rows += [(name, ratio, relative_error(f(*arguments), exact)) for name, f in forms.items()]
    return _table("far field", rows)


def length_as_printed(levels, means, deviations, samples: int, critical: float) -> float:
    """Compute the indifference interval's length by Eqs. (25), (27) and (29) as printed.

    The correlations and the quartic are in powers of the parameter itself, and the roots by
    `numpy.roots`; a root is real if `numpy.roots` returns it as real.
    """
    powers = np.vander(np.asarray(levels, dtype=float), 3)
    values = np.stack([np.asarray(means, dtype=float), np.asarray(deviations, dtype=float)], 1)
    try:
        (b, bs), (c, cs), (d, ds) = np.linalg.solve(powers, values)
    except np.linalg.LinAlgError:  # in double precision the levels are equal
        return float("nan")
    of_mean, of_deviation = (b, c, d - means[1]), (bs, cs, ds)
    roots = np.roots(_quartic(of_mean, of_deviation, deviations[1], float(samples), critical**2))
    real = roots[np.isreal(roots)].real
    return float(np.min(np.abs(real - levels[1]))) if real.size else float("nan")


def _quartic(mean: tuple, deviation: tuple, at_base, n, t2) -> list:
    """Return the coefficients of Eq. (29), highest power first, from those of Eqs. (25), (27)."""
    (b, c, rise), (bs, cs, ds) = mean, deviation
    return [
        n * b**2 - t2 * bs**2,
        2 * n * b * c - 2 * t2 * bs * cs,
        n * c**2 + 2 * n * b * rise - t2 * cs**2 - 2 * t2 * bs * ds,
        2 * n * c * rise - 2 * t2 * cs * ds,
        n * rise**2 - t2 * (ds**2 + at_base**2),
    ]


def exact_length(levels, means, deviations, samples: int, critical: float) -> mpmath.mpf:
    """Compute `length_as_printed` exactly; NaN without a real root.

    It uses all roots of the quartic in a parameter counted from p_M, which loses no digits in exact
    arithmetic. Double roots are distinguished from pairs of complex roots by a gap of 1e-30 in
    their imaginary parts.
    """
    with mpmath.workdps(3 * DIGITS):
        p = [mpmath.mpf(float(value)) for value in levels]
        half_range = (p[2] - p[0]) / 2
        u = [(value - p[1]) / half_range for value in p]
        (b, c, d), (bs, cs, ds) = (_exact_quadratic(u, v) for v in (means, deviations))
        of_mean, at_base = (b, c, d - mpmath.mpf(float(means[1]))), mpmath.mpf(float(deviations[1]))
        n, t2 = mpmath.mpf(samples), mpmath.mpf(critical) ** 2
        coefficients = _quartic(of_mean, (bs, cs, ds), at_base, n, t2)
        largest = max(abs(value) for value in coefficients)
        while coefficients and abs(coefficients[0]) <= largest * mpmath.mpf(10) ** -(2 * DIGITS):
            del coefficients[0]
        if len(coefficients) < 2:
            return mpmath.nan
        ascending = coefficients[::-1]
        roots = mpmath.polyroots(ascending, maxsteps=5000, extraprec=20 * DIGITS, asc=True)
        size = mpmath.mpf(10) ** -30
        real = [abs(mpmath.re(r)) for r in roots if abs(mpmath.im(r)) <= size * (1 + abs(r))]
        return min(real) * half_range if real else mpmath.nan


def _exact_quadratic(u, values):
    """Return coefficients of the quadratic through three points, highest power first."""
    matrix = mpmath.matrix([[x**2, x, 1] for x in u])
    return mpmath.lu_solve(matrix, mpmath.matrix([mpmath.mpf(float(v)) for v in values]))


def quartic_errors(half_ranges: np.ndarray, base: float) -> pd.DataFrame:
    """Compute relative errors of the length for levels base (1 -+ half range) (k,)."""
    critical = float(scipy.stats.t.ppf(0.975, 2 * SAMPLES - 2))
    rows = []
    for half in half_ranges:
        levels = base * np.array([1.0 - half, 1.0, 1.0 + half])
        exact = exact_length(levels, MEANS, DEVIATIONS, SAMPLES, critical)
        printed = length_as_printed(levels, MEANS, DEVIATIONS, SAMPLES, critical)
        ours = indifference_interval(levels, MEANS, DEVIATIONS, SAMPLES).length
        rows += [
            (f"Eq. (29) as printed, p = {base:g}", half, relative_error(printed, exact)),
            (f"jointclosure, p = {base:g}", half, relative_error(ours, exact)),
        ]
    return _table("quartic", rows)


def relative_error(value: complex, exact: mpmath.mpf) -> float:
    """Return |value/exact - 1|; infinite if the value is not a number but the exact one is."""
    if not np.isfinite(value):
        return float("inf")
    with mpmath.workdps(DIGITS):
        return float(abs(mpmath.mpmathify(complex(value)) / exact - 1))


def _table(subject: str, rows: list[tuple[str, float, float]]) -> pd.DataFrame:
    """Return rows (series, at, error) of one subject, in the long form of `numerics.csv`."""
    frame = pd.DataFrame(rows, columns=["series", "at", "error"])
    frame.insert(0, "subject", subject)
    return frame


FORMULAS = {
    "cubic": ("contact law over 24 decades of g", 1e-14),
    "far field": ("interaction up to zeta/r = 1e9", 1e-13),
    "quartic": ("indifference interval of levels 1e-9 apart, relative", 1e-13),
}
"""Difficulty of each formula, and the largest allowed relative error."""
OURS = "jointclosure"
_SOLVED = 1.01e-10


def formula_rows(errors: pd.DataFrame, loads: pd.DataFrame) -> list[dict]:
    """Return rows for the table of hard cases, with ``largest_error`` besides its columns."""
    rows = []
    for subject, (hard, limit) in FORMULAS.items():
        ours = errors[(errors.subject == subject) & errors.series.str.startswith(OURS)]
        worst = float(np.max(ours.error.to_numpy())) if len(ours) else np.inf
        must = f"relative error at most {limit:g}"
        rows.append(_row(subject.replace(" ", "_"), hard, must, worst, limit))
    for joint, part in loads.groupby("joint", sort=False):
        name = joint.replace("'s", "").replace(" ", "_")
        hard = f"{len(part)} loads, on {np.sum(part.spectral_radius >= 1.0)} of which the sweep of "
        hard += "the paper, read as simultaneous, does not converge"
        must = f"the fast solver's residual is at most {_SOLVED:g}, by a dense matrix"
        worst = float(np.max(part.fast_residual.to_numpy()))
        rows.append(_row(f"interaction_{name}", hard, must, worst, _SOLVED))
    return rows


def _row(name: str, hard: str, must_hold: str, worst: float, limit: float) -> dict:
    holds = bool(worst <= limit)
    return {
        "name": name,
        "group": "numerics",
        "hard": hard,
        "must_hold": must_hold,
        "expected": "answer",
        "status": "success" if np.isfinite(worst) else "not found",
        "holds": holds,
        "failed": "" if holds else f"error {worst:.3g}, at most {limit:g}",
        "largest_error": worst,
    }
