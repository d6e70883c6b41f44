"""Convergence of the paper's sweep over the contacts (Section 3, steps 3 to 5), and its limits.

There are two readings. *One-sided*, as in the reference solver: a contact is solved with the
present forces of the others, tallest first (Gauss-Seidel). It lowers a convex energy with every
contact and therefore converges at every load; the question is how slowly, and where the paper's 1 %
test stops it. *Simultaneous*: with the forces of the previous pass (Jacobi), as in a program that
corrects all heights at the end of a pass. It does not converge above a load.

Residuals are computed by a dense matrix and a contact law in numpy in this module, independent of
the solvers. See docs/model.md.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.mechanics.contact_law import ContactLaw, contact_law
from jointclosure.parameters import Choices, Effects, Rock
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts, coordinate_sweep
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import influence_of, influence_table
from jointclosure.walls.synthesis import wall_pair

DOLERITE = Rock(78e9, 0.2, 165e6)
SPACING = 0.25e-3
PAPER_TOLERANCE = 0.01
MOST_PASSES = 5000
MOST_SIMULTANEOUS_PASSES = 1000
FAST_TOLERANCES = 10.0 ** -np.arange(1.0, 13.0)


class Problem(NamedTuple):
    """Contacts (n,) at one closure, tallest first, and the influence between them."""

    contacts: Contacts
    table: np.ndarray  # of the solvers, by distance
    matrix: np.ndarray  # (n, n) [m/N], the same computed here, for residuals


class History(NamedTuple):
    """Forces (n,) [N] at the end, residuals (k,) after every pass, and the stop at 1 %."""

    force: np.ndarray
    residuals: np.ndarray
    stop: int  # first pass that changed no force by more than `PAPER_TOLERANCE`, or 0
    stopped: np.ndarray  # the forces then


def paper_walls() -> tuple[np.ndarray, np.ndarray]:
    """Make two walls of the paper's grid, 100 x 100 cells of 0.25 mm, JRC 8, no roll-off [m]."""
    return wall_pair(8.0, (100, 100), SPACING, seed=1, roll_off=None)


def polished_walls() -> tuple[np.ndarray, np.ndarray]:
    """Make two walls of 32 x 32 independent heights of 10 nm rms [m]: the slowest tried."""
    random = np.random.default_rng(1)
    upper, lower = 1e-8 * random.normal(size=(2, 32, 32))
    return upper, lower


def problem_at(
    upper: np.ndarray, lower: np.ndarray, closure: float, base_radius_in_cells: float, peaks: bool
) -> Problem:
    """Return the contacts of two walls (y, x) [m] in dolerite, with soft peaks or without."""
    effects = Effects(breakage=False, gouge=False, soft_peaks=peaks)
    choices = Choices(base_radius_in_cells=base_radius_in_cells)
    law = contact_law(SPACING, (DOLERITE, DOLERITE), effects, choices)
    offset = closure - float((upper + lower).max())
    peak = peak_map(upper, lower)
    cells, overlap, _, compliance = overlapping_cells(upper, lower, offset, peak, law)
    order, strength = np.argsort(-overlap, kind="stable"), np.full(cells.size, np.inf)
    of_cells = compliance[order], strength
    contacts = Contacts(cells[order], overlap[order], *of_cells, law.substrate)
    table = influence_table(*upper.shape, law.base_radius, law.substrate_modulus, law.spacing)
    return Problem(contacts, table, dense_influence_matrix(contacts.cells, upper.shape[1], law))


def dense_influence_matrix(cells: np.ndarray, columns: int, law: ContactLaw) -> np.ndarray:
    """Compute displacements (n, n) [m/N] by unit forces as printed; error 1e-12 at 100 cells."""
    y, x = np.divmod(cells, columns)
    zeta = law.spacing * np.hypot(np.subtract.outer(y, y), np.subtract.outer(x, x))
    np.fill_diagonal(zeta, np.inf)
    ratio = law.base_radius / zeta
    bracket = (2.0 * ratio**2 - 1.0) * np.arcsin(ratio) + ratio * np.sqrt(1.0 - ratio**2)
    with np.errstate(invalid="ignore"):  # the diagonal, 0/0
        matrix = 0.75 * bracket / (ratio**3 * np.pi * law.substrate_modulus * zeta)
    np.fill_diagonal(matrix, 0.0)
    return matrix


def answers(problem: Problem, force: np.ndarray) -> np.ndarray:
    """Return the forces (n,) [N] for the overlaps that forces (n,) leave."""
    a, b = problem.contacts.substrate, problem.contacts.compliance
    overlap = problem.contacts.overlap - problem.matrix @ force
    on = overlap > 0.0
    b, overlap = b[on], overlap[on]
    t = np.cbrt(overlap / a)
    for _ in range(100):  # Newton's method for t^3 A + t^2 B = overlap, from above
        shorter = t - (a * t**3 + b * t**2 - overlap) / (3.0 * a * t**2 + 2.0 * b * t)
        if not np.any(shorter < t * (1.0 - 1e-15)):
            break
        t = np.minimum(t, shorter)
    result = np.zeros(force.size)
    result[on] = t**3
    return result


def residual(problem: Problem, force: np.ndarray) -> float:
    """Return sum |F - answer| / sum F of forces (n,) [N]; infinite without any force."""
    total = float(force.sum())
    if total == 0.0:
        return float("inf")
    return float(np.abs(force - answers(problem, force)).sum()) / total


def one_sided(problem: Problem, tolerance: float, most: int = MOST_PASSES) -> History:
    """Sweep from zero force until the residual is within a tolerance and the 1 % test is met."""
    force = np.zeros(problem.contacts.cells.size)

    def sweep() -> float:
        return coordinate_sweep(problem.table, problem.contacts, 0.0, force)

    return _history(problem, force, sweep, tolerance, most)


def simultaneous(
    problem: Problem, tolerance: float, most: int = MOST_SIMULTANEOUS_PASSES
) -> History:
    """Solve all contacts at once with the forces of the previous pass, from zero force."""
    force = np.zeros(problem.contacts.cells.size)

    def sweep() -> float:
        new = answers(problem, force)
        changed = new != force
        change = np.full(force.size, np.inf)
        np.divide(np.abs(new - force), new, out=change, where=new > 0.0)
        force[:] = new
        return float(change[changed].max(initial=0.0))

    return _history(problem, force, sweep, tolerance, most)


def _history(problem, force, sweep, tolerance, most) -> History:
    residuals: list[float] = []
    stop, stopped = 0, force
    while len(residuals) < most:
        change = sweep()
        residuals.append(residual(problem, force))
        if not stop and change <= PAPER_TOLERANCE:
            stop, stopped = len(residuals), force.copy()
        if stop and residuals[-1] <= tolerance:
            break
    return History(force, np.array(residuals), stop, stopped)


def fast(problem: Problem, tolerance: float) -> tuple[np.ndarray, int]:
    """Return forces (n,) [N] by the fast solver from zero force, and products with the matrix."""
    influence, start = influence_of(problem.table), np.zeros(problem.contacts.cells.size)
    solution = solve_equilibrium(influence, problem.contacts, start, np.nan, tolerance)
    return solution.force, solution.products


def spectral_radius(problem: Problem, force: np.ndarray) -> float:
    """Return the spectral radius of a simultaneous pass at equilibrium; it converges below 1."""
    on = force > 0.0
    contacts = problem.contacts
    compliance = contacts.substrate + 2.0 / 3.0 * contacts.compliance[on] / np.cbrt(force[on])
    scaled = problem.matrix[np.ix_(on, on)] / np.sqrt(np.outer(compliance, compliance))
    return float(np.abs(np.linalg.eigvalsh(scaled)).max())


def critical_closure(upper: np.ndarray, lower: np.ndarray, steps: int = 24) -> float:
    """Find the closure [m] above which a simultaneous pass does not contract (r = h/2)."""
    low, high = 0.0, float(np.ptp(upper + lower))
    for _ in range(steps):
        middle = 0.5 * (low + high)
        problem = problem_at(upper, lower, middle, 0.5, True)
        if spectral_radius(problem, fast(problem, 1e-12)[0]) < 1.0:
            low = middle
        else:
            high = middle
    return high


def load_table() -> pd.DataFrame:
    """Tabulate both readings and the fast solver over loads, for the paper's and polished walls.

    ``stops_after``: passes until the 1 % test (0: never, in `MOST_SIMULTANEOUS_PASSES` or
    `MOST_PASSES`), with the error of the forces then, sum |F - F*| / sum F*, and the largest one.
    """
    walls, parts = paper_walls(), (0.5, 0.95, 0.99, 1.0, 1.01, 1.05, 1.5, 2.0)
    critical = critical_closure(*walls)
    rows = [_at_load("paper's grid", *walls, part * critical, 0.5, True) for part in parts]
    walls = polished_walls()
    height, heights = float(np.ptp(walls[0] + walls[1])), (0.3, 1.0, 3.0, 10.0, 100.0)
    rows += [_at_load("polished", *walls, part * height, 1.0, False) for part in heights]
    return pd.DataFrame(rows)


def hardest_problem() -> Problem:
    """Return the slowest one-sided case: every cell of polished walls in contact, r = h."""
    upper, lower = polished_walls()
    return problem_at(upper, lower, 100.0 * float(np.ptp(upper + lower)), 1.0, False)


def convergence_histories() -> pd.DataFrame:
    """Return residuals over passes or products on the hardest case, for `numerics.csv`."""
    problem = hardest_problem()
    rows = []
    for name, history in (
        ("all contacts at once", simultaneous(problem, 1e-12, 200)),
        ("contact by contact", one_sided(problem, 1e-12)),
    ):
        rows += [(name, at, error) for at, error in enumerate(history.residuals, start=1)]
        if history.stop:
            at = history.stop
            rows.append((f"{name}, stopped at 1 %", at, history.residuals[at - 1]))
    for tolerance in FAST_TOLERANCES:
        force, products = fast(problem, float(tolerance))
        rows.append(("jointclosure", products, residual(problem, force)))
    frame = pd.DataFrame(rows, columns=["series", "at", "error"])
    frame.insert(0, "subject", "convergence")
    return frame


def _at_load(name, upper, lower, closure, base_radius_in_cells, peaks) -> dict:
    problem = problem_at(upper, lower, closure, base_radius_in_cells, peaks)
    exact, _ = fast(problem, 1e-13)
    solved, products = fast(problem, 1e-10)
    by_pass = simultaneous(problem, np.inf)
    by_contact = one_sided(problem, 1e-10)
    row = {
        "joint": name,
        "closure_um": 1e6 * closure,
        "stress_MPa": 1e-6 * exact.sum() / (upper.size * SPACING**2),
        "contacts": int(np.count_nonzero(exact)),
        "cells": upper.size,
        "spectral_radius": spectral_radius(problem, exact),
    }
    for reading, history in (("simultaneous", by_pass), ("one_sided", by_contact)):
        force, on = history.stopped if history.stop else history.force, exact > 0.0
        off = np.abs(force - exact)
        row[f"{reading}_stops_after"] = history.stop
        row[f"{reading}_error"] = float(off.sum() / exact.sum())
        row[f"{reading}_largest_error"] = float((off[on] / exact[on]).max())
    return row | {
        "one_sided_sweeps_to_1e-10": by_contact.residuals.size,
        "fast_products_to_1e-10": products,
        "fast_residual": residual(problem, solved),
    }
