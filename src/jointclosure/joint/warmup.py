"""Compile kernels before processes fan out.

Two processes that fill a cold cache at once can swap each other's machine
code, so one process compiles all that the others will need.
"""

from collections.abc import Iterable
from typing import Literal

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
from jointclosure.surface.synthesis import wall_pair


def kernels_of(
    settings: Iterable[tuple[Effects, Choices, Numerics]],
) -> list[list[str]]:
    """What the kernels of some settings depend on: scene, peaks, solver and breakage, each once."""
    found = {
        (scene_name(effects), choices.peaks, numerics.solver, numerics.breakage)
        for effects, choices, numerics in settings
    }
    return [list(each) for each in sorted(found)]


def compile_kernels(
    effects: Effects,
    choices: Choices,
    solver: str,
    breakage: Literal["fixed_step", "resolved"],
) -> None:
    """Close a small joint in a scene, which compiles what it needs."""
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
    # of a figure
    strength_factor(rock.poisson_ratio)
    von_mises_on_axis(0.5, rock.poisson_ratio)
    if not effects.breakage:
        equilibrium(
            *walls, spacing=spacing, rock=rock, closure=1e-4, effects=effects, numerics=numerics
        )


if __name__ == "__main__":
    from jointclosure.solvers.registry import SOLVERS

    for scene in well_posed_scenes():
        for peaks in ("pristine", "current"):
            for name in SOLVERS:
                compile_kernels(scene, Choices(peaks=peaks), name, "fixed_step")
            compile_kernels(scene, Choices(peaks=peaks), "fast", "resolved")
