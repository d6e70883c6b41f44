"""Compilation of kernels before parallel processes start.

Two processes that compile into an empty cache at the same time can store each other's machine code.
Therefore one process first compiles all kernels that the others need.
"""

import sys
from collections.abc import Iterable
from typing import Literal

import numpy as np

from jointclosure.joint.simulation import equilibrium, simulate
from jointclosure.mechanics.strength import strength_factor, von_mises_on_axis
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
    scene_name,
    well_posed_scenes,
)
from jointclosure.solvers.interaction_operator import influence_matrix
from jointclosure.walls.synthesis import wall_pair


def kernels_of(
    settings: Iterable[tuple[Effects, Choices, Numerics]],
) -> list[list[str]]:
    """Return the distinct settings that kernels depend on: scene, peaks, solver and breakage."""
    distinct = {
        (scene_name(effects), choices.peaks, numerics.solver, numerics.breakage)
        for effects, choices, numerics in settings
    }
    return [list(kernel) for kernel in sorted(distinct)]


def compile_kernels(
    effects: Effects,
    choices: Choices,
    solver: str,
    breakage: Literal["fixed_step", "resolved"],
) -> None:
    """Close a small joint in a scene, to compile the kernels that it needs."""
    spacing, rock = 0.25e-3, Rock(78e9, 0.2, 165e6)
    walls = wall_pair(8.0, (24, 24), spacing, seed=1)
    numerics = Numerics(solver=solver, breakage=breakage)
    simulate(
        *walls,
        spacing=spacing,
        rock=rock,
        max_normal_stress=1e6,
        cycles=1,
        effects=effects,
        choices=choices,
        numerics=numerics,
    )
    if effects.interaction and solver == "fast":  # with more contacts than the small joint has
        influence_matrix(np.zeros(walls[0].shape), np.empty(0, np.int64))
    # kernels that a figure uses
    strength_factor(rock.poisson_ratio)
    von_mises_on_axis(0.5, rock.poisson_ratio)
    if not effects.breakage:
        equilibrium(
            *walls, spacing=spacing, rock=rock, closure=1e-4, effects=effects, numerics=numerics
        )


def main(words: list[str]) -> None:
    """Compile the kernels of all scenes; with "close", those of `jointclosure.close` only."""
    from jointclosure.solvers.registry import SOLVERS

    only_close = words == ["close"]
    for scene in [Effects()] if only_close else well_posed_scenes():
        for peaks in ("pristine", "current"):
            for name in ["fast"] if only_close else SOLVERS:
                compile_kernels(scene, Choices(peaks=peaks), name, "fixed_step")
            compile_kernels(scene, Choices(peaks=peaks), "fast", "resolved")


if __name__ == "__main__":
    main(sys.argv[1:])
