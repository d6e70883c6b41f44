"""How long jointclosure and other contact codes take for one elastic closure curve.

The same two walls are closed to 30 MPa in 20 equal steps of stress. The peers solve frictionless
elasticity at the scale of a cell: one rigid surface, the sum of both walls, on a half-space of
modulus 1/(1/E1* + 1/E2*) with free boundaries and a constant pressure on each cell; whether they
agree is in the second table. jointclosure solves another model on the same walls, so that its
closures are others, and its error is the residual of its own equilibrium.

Every peer has its fastest set-up: one thread, each stress started from the scaled forces of the
last, and its loosest tolerance (in quarters of a decade) that keeps error = sum p (gap - least
gap) / (sum p * closure) <= 1e-6 at every stress, measured by one operator for all. What is built
once for a surface is not timed. "own, by matrix" shows how much is due to working in the contacts
only (one cell in a hundred), as jointclosure does. Times are medians of runs in turn, also in pairs
of transforms that are timed in between.

    pip install ContactMechanics tamaas pyfftw tinydb && pip install --no-deps slippy
    CMAKE_ARGS=-DASPHER_NATIVE=ON pip install aspher

A peer that is not installed is named and left out. Run as `python benchmarks/peers.py`.
"""

import itertools
from importlib.metadata import version
from pathlib import Path

import yardstick
from yardstick import DOLERITE, SPACING

# isort: split
import numpy as np
import pandas as pd
import scipy.fft

import jointclosure as jc

MODULUS = 0.5 * DOLERITE.youngs_modulus / (1.0 - DOLERITE.poisson_ratio**2)  # 1/(1/E1* + 1/E2*)
CELLS = 100
SIDE, CELL, PADDED = CELLS * SPACING, SPACING**2, (2 * CELLS, 2 * CELLS)
STRESSES = np.linspace(0.0, 30e6, yardstick.POINTS + 1)[1:]
TOLERANCE = 1e-6


def love_table() -> np.ndarray:
    """Return displacements [m/Pa] by pressure on one cell, over wrapped distance (Love 1929)."""
    at = np.roll(np.arange(-CELLS, CELLS), CELLS) * SPACING
    table = np.zeros(PADDED)
    for i, j in itertools.product((-1, 1), repeat=2):
        y = at[:, None] + 0.5 * i * SPACING
        x = at + 0.5 * j * SPACING
        table += i * j * (x * np.arcsinh(y / abs(x)) + y * np.arcsinh(x / abs(y)))
    return table / (np.pi * MODULUS)


TABLE = love_table()
SPECTRUM = scipy.fft.rfft2(TABLE, workers=1)


def displacement(pressure: np.ndarray) -> np.ndarray:
    """Return displacements (y, x) [m] of the half-space by pressures (y, x) [Pa]."""
    wave = scipy.fft.rfft2(pressure, PADDED, workers=1) * SPECTRUM
    return scipy.fft.irfft2(wave, PADDED, workers=1)[:CELLS, :CELLS]


# A peer is set up for a gap (y, x) [m], which is 0 at first touch. It returns a function
# solve(stress, guess, tolerance, closure), which returns the closure [m], the pressures (y, x) [Pa]
# and the number of products with the half-space (or None). The mean of the guess (y, x) [Pa] is the
# stress. The given closure is the solution, to which tolerances may be relative.


def polonsky_keer(product, gap, load, pressure, tolerance):
    """Solve by Polonsky & Keer (1999): conjugate gradients in the contacts at given load.

    ``product`` returns displacements by pressures. Returns closure, pressures and products.
    """
    direction = np.zeros_like(gap)
    keep = 0.0
    before = 1.0
    for iteration in range(5000):
        deformed = product(pressure) + gap
        touching = pressure > 0.0
        closure = deformed[touching].mean()
        if np.vdot(pressure, deformed - deformed.min()) <= tolerance * load * closure:
            return closure, pressure, 2 * iteration + 1
        deformed -= closure
        square = np.sum(deformed[touching] ** 2)
        direction = np.where(touching, deformed + keep * square / before * direction, 0.0)
        before = square
        answer = product(direction)
        answer -= answer[touching].mean()
        length = np.vdot(deformed, direction) / np.vdot(answer, direction)
        pressure = np.maximum(pressure - length * direction, 0.0)
        overlapping = (pressure == 0.0) & (deformed < 0.0)
        pressure[overlapping] -= length * deformed[overlapping]
        keep = 0.0 if overlapping.any() else 1.0
        pressure *= load / pressure.sum()
    raise RuntimeError("no convergence")


def own(gap):
    """Set up `polonsky_keer` with transforms of the whole surface, as in the peers."""

    def solve(stress, guess, tolerance, _):
        return polonsky_keer(displacement, gap, stress * gap.size, guess, tolerance)

    return solve


def own_dense(gap):
    """Set up `polonsky_keer` with the matrix of the cells that overlap at the given closure.

    This closure is at least the solution, so that no other cell can touch.
    """

    def solve(stress, guess, tolerance, closure):
        y, x = cells = np.nonzero(gap <= closure)
        matrix = TABLE[y[:, None] - y, x[:, None] - x]
        pressure = np.zeros_like(gap)
        closure, pressure[cells], products = polonsky_keer(
            matrix.__matmul__, gap[cells], stress * gap.size, guess[cells], tolerance
        )
        return closure, pressure, products

    return solve


def contact_mechanics(gap):
    """Set up ContactMechanics: its dual problem (forces), by conjugate gradients with restart.

    NuMPI's solver takes a load. `minimize_proxy` takes twice as long, and `dual_minimize_proxy` is
    for given closures.
    """
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from NuMPI.Optimization.CCGWithRestart import constrained_conjugate_gradients_with_restart
    from SurfaceTopography import Topography

    half_space = FreeFFTElasticHalfSpace(gap.shape, MODULUS, (SIDE, SIDE))
    system = NonSmoothContactSystem(half_space, Topography(-gap, physical_sizes=(SIDE, SIDE)))

    def solve(stress, guess, tolerance, closure):
        answer = constrained_conjugate_gradients_with_restart(
            system.dual_objective(0.0),
            system.dual_hessian_product,
            x0=guess * CELL,
            mean_val=stress * CELL,
            gtol=tolerance * closure,
        )
        force = answer.x.reshape(gap.shape)
        deformed = half_space.evaluate_disp(-force) + gap
        return deformed[force > 0.0].mean(), force / CELL, 2 * answer.nit + 1

    return solve


def tamaas(gap):
    """Set up tamaas: Polonsky-Keer-Rey in the pressures.

    The moduli must be set before the non-periodic operator is registered, and this operator must be
    selected. The solver returns shifted displacements, so that they are computed again.
    """
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.Model(tm.model_type.basic_2d, [SIDE, SIDE], list(gap.shape))
    model.E = MODULUS
    model.nu = 0.0
    tm.ModelFactory.registerNonPeriodic(model, "free")
    solver = tm.PolonskyKeerRey(model, -gap, TOLERANCE)
    solver.setIntegralOperator("free")
    deformed = np.empty_like(gap)

    def solve(stress, guess, tolerance, _):
        solver.tolerance = tolerance
        model.traction[...] = guess
        solver.solve(stress)
        pressure = np.array(model.traction)
        model.operators["free"](pressure, deformed)
        return (deformed + gap)[pressure > 0.0].mean(), pressure, None

    return solve


def slippy(gap):
    """Set up slippy: `bccg`, conjugate gradients with bounds.

    It takes closures (those of our own solution) instead of stresses. `polonsky_and_keer`, which
    takes loads, needs twice as long.
    """
    import slippy

    slippy.CUDA = False
    slippy.CORES = 1
    from slippy.core import bccg, elastic_influence_matrix_spatial, plan_convolve

    step = (SPACING, SPACING)
    table = elastic_influence_matrix_spatial("zz", PADDED, step, shear_mod=MODULUS / 2, v=0.0)
    half_space = plan_convolve(gap, table, gap < np.inf, fft_im=False)

    def solve(_, guess, tolerance, closure):
        overlap = closure - gap
        pressure = np.zeros_like(gap)
        products = itertools.count()
        cells = overlap > 0.0
        half_space.change_domain(cells)

        def product(values):
            next(products)
            return half_space(values)

        carried = bccg(product, overlap[cells], tolerance, 5000, guess[cells])[0]
        pressure[cells] = carried
        return (product(carried) + gap[cells])[carried > 0.0].mean(), pressure, next(products)

    return solve


def aspher(gap):
    """Set up aspher: its exact transforms and its preconditioner on the contacts.

    Its other backend, "h2", needs a power of two. Its tolerance is relative to the range of
    heights, and is converted from one relative to the closure.
    """
    import aspher as hc

    solver = hc.ContactSolver(CELLS, domain_size=SIDE, E_star=MODULUS, backend="fft")

    def solve(stress, guess, tolerance, closure):
        target = tolerance * closure / np.ptp(gap)
        answer = solver.solve(gap, stress, tol=target, precond="fourier", p_init=guess)
        return answer.approach, answer.pressure, answer.matvec_count

    return solve


PEERS = {
    "own, by transforms": own,
    "own, by matrix": own_dense,
    "ContactMechanics": contact_mechanics,
    "tamaas": tamaas,
    "slippy": slippy,
    "aspher": aspher,
}
GIVEN_CLOSURES = ("own, by matrix", "slippy")


def curve(solve, gap, tolerance, given) -> tuple:
    """Return closures (20,) [m], pressures (20, y, x) [Pa] and products at all `STRESSES`.

    ``given`` are the closures that `solve` takes.
    """
    pressure = np.ones_like(gap)
    answers = []
    for stress, closure in zip(STRESSES, given, strict=True):
        answers.append(solve(stress, pressure * (stress / pressure.mean()), tolerance, closure))
        pressure = answers[-1][1]
    closures, pressures, products = zip(*answers, strict=True)
    return np.array(closures), np.array(pressures), None if None in products else sum(products)


def error_of(gap, closures, pressures) -> float:
    """Return the largest error along a curve, as the docstring of this module defines it."""
    deformed = [displacement(pressure) + gap for pressure in pressures]
    excess = [np.vdot(p, g - g.min()) for p, g in zip(pressures, deformed, strict=True)]
    return np.max(excess / (pressures.sum(axis=(1, 2)) * closures))


def peer_row(name, solve, gap, exact) -> dict:
    """Return the row of a peer, with differences from our own solution to 1e-10 (``exact``)."""
    for tolerance in 10.0 ** -np.arange(4.5, 9.1, 0.25):
        closures, pressures, products = curve(solve, gap, tolerance, exact[0])
        if (error := error_of(gap, closures, pressures)) <= TOLERANCE:
            break
    forces = abs(pressures - exact[1]).sum(axis=(1, 2)) / exact[1].sum(axis=(1, 2))
    return {
        "products": products or "-",
        "tolerance": tolerance,
        "error": error,
        "d closure": abs(closures / exact[0] - 1.0).max(),
        "d force": forces.max(),
        "closure": closures,
        "cells": np.count_nonzero(pressures, (1, 2)),
        "solves": "elastic half-space" + ", closures given" * (name in GIVEN_CLOSURES),
    }


def simulate(walls):
    """Simulate the joint by jointclosure at the same stresses."""
    numerics = jc.Numerics(force_tolerance=TOLERANCE, curve_points=yardstick.POINTS)
    return yardstick.close(walls, yardstick.ELASTIC, STRESSES[-1], numerics=numerics)


def joint_row(walls) -> dict:
    """Return the row of jointclosure, read from its loading branch."""
    cycle = simulate(walls)
    up = cycle.isel(step=cycle.branch == "loading")
    down = cycle.step.size - up.step.size
    shares = np.interp(STRESSES, up.normal_stress, up.contact_fraction)
    return {
        "version": jc.__version__,
        "products": int(cycle.solver_iterations),
        "tolerance": TOLERANCE,
        "error": float(cycle.equilibrium_residual.max()),
        "closure": np.interp(STRESSES, up.normal_stress, up.closure),
        "cells": np.rint(shares * CELLS**2).astype(int),
        "solves": f"Hertz asperities and half-space, {up.step.size - 1} points up, {down} down",
    }


def main(seed: int, repeats: int, output: Path | None) -> None:
    """Print the machine, the times and the curves of all codes; write the times as CSV."""
    walls = yardstick.joint_walls(CELLS, seed)
    gap = np.max(walls[0] + walls[1]) - (walls[0] + walls[1])
    exact = curve(own(gap), gap, 1e-10, STRESSES)  # the given closures are not used
    rows = {"jointclosure": joint_row(walls)}
    runs = {"jointclosure": (simulate, walls)}
    for name, set_up in PEERS.items():
        try:
            solve = set_up(gap)
        except ImportError as error:
            print(f"{name} is left out: it is not installed here ({error})")
            continue
        code = name.partition(",")[0]
        used = version(code) if code != "own" else "-"
        rows[name] = {"version": used} | peer_row(name, solve, gap, exact)
        runs[name] = (curve, solve, gap, rows[name]["tolerance"], exact[0])

    times = {name: [] for name in runs}
    pair = yardstick.Pair(PADDED[0])
    for _, (name, (run, *given)) in itertools.product(range(repeats), runs.items()):
        pair.sample()
        times[name].append(1e3 * yardstick.timed(lambda run=run, given=given: run(*given))[0])

    print(
        f"\n{yardstick.machine()}\nJRC 8, {CELLS} x {CELLS} cells of {1e3 * SPACING:g} mm, "
        f"seed {seed}; {DOLERITE}\n"
        f"medians of {repeats}; one pair of transforms {1e3 * pair.seconds:.3f} ms"
    )
    table = pd.DataFrame(rows).T.rename_axis("code")
    table["ms"] = [np.median(times[name]) for name in table.index]
    table["pairs"] = table.ms / (1e3 * pair.seconds)
    table["um at 30 MPa"] = [1e6 * closures[-1] for closures in table.closure]
    columns = ["version", "ms", "pairs", "products", "tolerance", "error", "um at 30 MPa"]
    columns += ["d closure", "d force", "solves"]
    title = "d: largest difference from our own to 1e-10, of closures, of forces sum|p-q| / sum q"
    yardstick.show(title, table[columns].reset_index(), output, "peers")
    for name, unit, title in (("closure", 1e6, "Closure [um]"), ("cells", 1, "Cells in contact")):
        curves = {code: values * unit for code, values in table[name].items()}
        shown = pd.DataFrame(curves, index=1e-6 * STRESSES).iloc[[0, 4, 9, 14, 19]].T
        print(f"\n{title} at a stress [MPa]", shown.to_string(float_format="%.4f"), sep="\n")


if __name__ == "__main__":
    asked = yardstick.options(__doc__, seed=1, repeats=7, output=Path)
    main(asked.seed, asked.repeats, asked.output)
