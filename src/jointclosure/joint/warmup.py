"""Compilation of kernels by one process, before parallel processes start that need them.

Two processes that compile into an empty cache at the same time can store each other's machine code.
"""

import logging
import os
import shutil
import sys
from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from jointclosure.compilation.kernels import (
    PROCESSOR,
    SHIPPED,
    all_are_shipped,
    cache_folder,
    store_number_of_kernels,
)
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.simulation import equilibrium, simulate_walls
from jointclosure.mechanics.strength import strength_factor, von_mises_on_axis
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
    scene_name,
    scene_of,
    well_posed_scenes,
)
from jointclosure.solvers.interaction_operator import (
    add_changes_of_force,
    influence_matrix,
    influence_of,
)
from jointclosure.walls.synthesis import wall_pair


def kernels_of(settings: Iterable[tuple[Effects, Choices, Numerics]]) -> list[list[str]]:
    """Return the distinct kernels that models need, each as a list of words.

    The words are those of scene, peaks, bound of strength, solver and breakage.
    """
    distinct = {
        (scene_name(scene), choices.peaks, choices.strength_bound, given.solver, given.breakage)
        for scene, choices, given in settings
    }
    return [list(kernel) for kernel in sorted(distinct)]


@lru_cache(maxsize=None)
def compile_kernels(scene: str, peaks: Any, bound: Any, solver: Any, breakage: Any) -> None:
    """Compile the kernels of an entry of `kernels_of`, or load them, by simulating small joints.

    A process does so once for each entry.
    """
    effects = scene_of(scene)
    choices = Choices(peaks=peaks, strength_bound=bound)
    joint: dict[str, Any] = {"spacing": 0.25e-3, "rock": Rock(78e9, 0.2, 165e6), "effects": effects}
    joint |= {"choices": choices, "numerics": Numerics(solver=solver, breakage=breakage)}
    walls = wall_pair(8.0, (24, 24), joint["spacing"], seed=1)
    # not by `simulate`, which refuses peaks that have no effect on these scenes
    simulate_walls(*walls, Conditions(max_normal_stress=1e6, cycles=1, **joint).checked())
    if effects.interaction and solver == "fast":  # with more contacts than the small joint has
        table = np.zeros(walls[0].shape)
        cells = np.empty(0, np.int64)
        influence_matrix(table, cells)
        force, interaction = np.zeros((2, *table.shape))
        add_changes_of_force(influence_of(table), cells, np.empty(0), force, interaction)
    strength_factor(0.2), von_mises_on_axis(0.5, 0.2)  # for a figure
    if not effects.breakage:
        equilibrium(*walls, closure=1e-4, **joint | {"choices": Choices()})


def all_kernels() -> list[list[str]]:
    """Return the entries of `kernels_of` for all well-posed scenes, as they are shipped."""
    kernels = []
    for scene, peaks in product(map(scene_name, well_posed_scenes()), ("pristine", "current")):
        kernels.append([scene, peaks, "base", "reference", "fixed_step"])
        for bound in ("base", "none") if scene_of(scene).breakage else ("base",):
            kernels += [[scene, peaks, bound, "fast", way] for way in ("fixed_step", "resolved")]
    return kernels


def prepare_kernels(models: Iterable[tuple[Effects, Choices, Numerics]], workers: int = 1) -> None:
    """Compile the kernels of models, or load them, before ``workers`` processes need them.

    With several workers this process needs no kernel itself, and skips kernels that are shipped.
    """
    shipped = all_kernels() if workers > 1 and all_are_shipped() else []
    for kernel in kernels_of(models):
        if kernel not in shipped:
            compile_kernels(*kernel)


def compile_all(kernels: list[list[Any]], log: Callable[[str], None]) -> str:
    """Compile the entries ``kernels`` of `kernels_of`, or load them; return their list as text.

    ``log`` is told the folder, and compilations are announced on standard error.
    """
    log(f"kernels are kept in {cache_folder()}")
    # the announcement of a compilation is for the user
    logging.getLogger("jointclosure").addHandler(logging.StreamHandler(sys.__stderr__))
    for kernel in kernels:
        compile_kernels(*kernel)
    return "".join(f"{', '.join(kernel)}\n" for kernel in kernels)


def main(words: list[str]) -> None:
    """Compile the kernels of all scenes, or load them.

    With "ship" they are compiled for many processors, as a part of the package (`SHIPPED`).
    """
    if words == ["ship"]:
        environment = {"NUMBA_CPU_NAME": PROCESSOR, "NUMBA_CPU_FEATURES": ""}
        environment |= {"NUMBA_DISABLE_INTEL_SVML": "1", "JOINTCLOSURE_CACHE": str(SHIPPED)}
        program = [sys.executable, "-m", "jointclosure.joint.warmup"]
        for old in set(SHIPPED.glob("*")) - {SHIPPED / cache_folder().name}:
            shutil.rmtree(old) if old.is_dir() else old.unlink()
        os.execve(sys.executable, program, os.environ | environment)
    for kernel in all_kernels():
        compile_kernels(*kernel)
    store_number_of_kernels()


if __name__ == "__main__":
    main(sys.argv[1:])
