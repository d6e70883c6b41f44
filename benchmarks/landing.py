"""What landing on the maximum does to the normal stiffness of first loadings.

    python benchmarks/landing.py --surfaces 16 --stresses 10 30

Closes walls of the default study's kind (JRC 8, roll-off 3 mm) by its fixed steps, for dolerite,
and prints the chord from half of the maximum stress: to the maximum, and to the end of the last
whole displacement step (`jointclosure.engineering.stiffness.secant_stiffness`), with their paired
difference: docs/engineering.md.
"""

import argparse

import numpy as np

import jointclosure as jc
from jointclosure.engineering.stiffness import closures_at, secant_stiffness
from jointclosure.joint.history import GROSS
from jointclosure.statistics.standard_errors import mean_of, rounded

ROCK = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
SPACING, CELLS, JRC, ROLL_OFF = 0.25e-3, (100, 100), 8.0, 3e-3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--surfaces", type=int, default=16)
    parser.add_argument("--stresses", type=float, nargs="+", default=[10.0, 30.0], help="MPa")
    arguments = parser.parse_args()
    for largest in arguments.stresses:
        chords = np.array([_chords(1e6 * largest, seed) for seed in range(arguments.surfaces)])
        whole, without, last = chords.T
        higher = mean_of(100.0 * (whole / without - 1.0))
        print(
            f"{largest:g} MPa: kn {rounded(*mean_of(whole))} MPa/mm to the maximum, "
            f"{rounded(*mean_of(without))} without landing: higher by {rounded(*higher)} %; the "
            f"last twentieth {rounded(*mean_of(last / without))} times that without"
        )


def _chords(largest: float, seed: int) -> tuple[float, float, float]:
    """Normal stiffness [MPa/mm] from half of a stress [Pa]: to it, to the landing, at the end."""
    walls = jc.wall_pair(JRC, CELLS, SPACING, seed, roll_off=ROLL_OFF)
    joint = jc.simulate(*walls, spacing=SPACING, rock=ROCK, max_normal_stress=largest, cycles=1)
    half, before, end = closures_at(joint, largest * np.array([0.5, 0.95, 1.0]), GROSS)[0, 0]
    return (
        1e-9 * 0.5 * largest / (end - half),
        1e-9 * secant_stiffness(joint, 1, 0.5 * largest, largest, GROSS),
        1e-9 * 0.05 * largest / (end - before),
    )


if __name__ == "__main__":
    main()
