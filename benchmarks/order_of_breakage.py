"""What the order of breakage is worth, and whether fast and reference solver agree in the mean.

Mirrored walls are the same joint, met in another order: the scatter over the
four mirror images of a surface pair is what the order is worth. The reference
goes tallest first, the fast solver in nine colours that take turns: their difference is
paired over surfaces. Run as `python benchmarks/order_of_breakage.py`.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse

import numpy as np
from yardstick import DOLERITE, SPACING, machine

import jointclosure as jc


def closures(walls, solver: str, stress: float) -> np.ndarray:
    """Maximum closures of both cycles [mm]."""
    numerics = jc.Numerics(solver=solver)
    closed = jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=stress, numerics=numerics
    )
    return 1e3 * closed.max_closure.values


def images(walls):
    """The four mirror images of both walls."""
    for flip in ((), (0,), (1,), (0, 1)):
        yield tuple(np.flip(wall, flip) for wall in walls)


def main(cells: int, surfaces: int, stress: float) -> None:
    """Print means, scatter and differences."""
    print(machine())
    pairs = [
        jc.wall_pair(8.0, (cells, cells), SPACING, seed, roll_off=None) for seed in range(surfaces)
    ]
    fast = np.array([[closures(w, "fast", stress) for w in images(pair)] for pair in pairs])
    slow = np.array([[closures(w, "reference", stress) for w in images(pair)] for pair in pairs])
    print(f"{surfaces} surfaces of {cells} x {cells} cells, dolerite, JRC 8, {1e-6 * stress:g} MPa")
    for cycle in (0, 1):
        for name, values in (("fast", fast), ("reference", slow)):
            order = values[..., cycle].std(axis=1, ddof=1)
            means = values[..., cycle].mean(axis=1)
            print(
                f"cycle {cycle + 1}, {name:9}: mean {means.mean():.5f} mm, over surfaces "
                f"{100 * means.std(ddof=1) / means.mean():.1f} %, over mirror images "
                f"{100 * np.sqrt(np.mean(order**2)) / means.mean():.2f} %"
            )
        difference = (fast - slow)[..., cycle].mean(axis=1)
        error = difference.std(ddof=1) / np.sqrt(surfaces)
        base = slow[..., cycle].mean()
        print(
            f"cycle {cycle + 1}, fast - reference: {100 * difference.mean() / base:+.2f} % "
            f"+- {100 * error / base:.2f} % (standard error)"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=24)
    parser.add_argument("--surfaces", type=int, default=60)
    parser.add_argument("--stress", type=float, default=3e6, help="maximum stress [Pa]")
    arguments = parser.parse_args()
    main(arguments.cells, arguments.surfaces, arguments.stress)
