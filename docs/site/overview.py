"""Draw the picture of README: two walls, where they touch at the largest stress, and their closure.

    .venv/bin/python docs/site/overview.py

It takes half a minute. 20 pairs of walls are closed; the map is of the first of them.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jointclosure as jc

JRC, SHAPE, SPACING, SURFACES, STRESS = 8, (100, 100), 0.25e-3, 20, 10e6
ROCK = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
PICTURE = Path(__file__).parents[1] / "images/overview.png"


def walls_of(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A pair of independent walls."""
    return jc.wall_pair(jrc=JRC, shape=SHAPE, spacing=SPACING, seed=seed)


def main() -> None:
    """Close the joints, and draw."""
    load = {"spacing": SPACING, "rock": ROCK, "max_normal_stress": STRESS}
    upper, lower = walls_of(0)
    joint = jc.simulate(upper, lower, **load, cycles=2, snapshots=[STRESS])
    ensemble = jc.simulate_ensemble(walls_of, seeds=range(SURFACES), **load)
    figure, (section, contacts, curves) = plt.subplots(
        1, 3, figsize=(14, 4), width_ratios=(1.25, 1.1, 1.2), layout="constrained"
    )
    jc.plot.walls(upper, lower, spacing=SPACING, axes=section)
    jc.plot.aperture(joint, 0, contacts)
    jc.plot.curves(ensemble, curves)
    section.set_title("two walls at first touch")
    contacts.set_title(f"aperture at {1e-6 * STRESS:g} MPa, contacts red")
    curves.set_title(f"closure of {SURFACES} pairs of walls, and their mean")
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
