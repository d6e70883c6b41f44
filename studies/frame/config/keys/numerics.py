"""Keys of the solver: steps, tolerances, and the accuracy wanted."""

from typing import Annotated, Literal

from pydantic import Discriminator, Tag

from jointclosure.parameters import SOLVER_NAMES
from studies.frame.config.keys.entries import Keys, Share, entry


class WantedKeys(Keys):
    """The accuracy of a result: chooses preset, number of surfaces and control variates, and
    `make study` adds surfaces until it is reached (docs/accuracy.md)."""

    of: Literal["mean", "interval"] = entry(
        "mean: every case's mean maximum closure; interval: every indifference interval."
    )
    within: Share = entry(
        "Total error that is wanted, relative: bias and half the 95 % confidence interval."
    )
    most: int = entry("Surfaces a case beyond which none are added.", 200, ge=10, le=1_000_000)
    surfaces: int | None = entry(
        "Surfaces a case; null: as many as are predicted. `make study` sets it.", None, ge=10
    )


Accuracy = Annotated[
    Annotated[WantedKeys, Tag("wanted")] | Annotated[Share, Tag("number")],
    Discriminator(lambda value: "wanted" if isinstance(value, dict) else "number"),
]


class NumericsKeys(Keys):
    """Solver, steps and tolerances."""

    preset: str | None = entry(
        "A word for the other keys, as measured by the study of accuracy: quick, paper, accurate "
        "or converged.",
        None,
    )
    accuracy: Accuracy | None = entry(
        "What mean maximum closures may be off by, relative: takes the cheapest numerics that were "
        "found to reach it (needs choices.largest_radius_mm where anything breaks). Or the "
        "accuracy of a result, {of: mean, within: 0.05}.",
        None,
    )
    solver: Literal[SOLVER_NAMES] = entry(
        "fast, or reference: the paper's own loop, for small grids."
    )
    breakage: Literal["fixed_step", "resolved"] = entry(
        "fixed_step: contacts break by the breakage steps (the paper's); resolved: by what brings "
        "them back to their strength, in steps controlled by an error estimate (fast solver)."
    )
    tolerance: float = entry(
        "What mean closures may be off by, relative, where breakage is resolved.", gt=0, le=0.1
    )
    displacement_step_um: float = entry("Displacement step of the first loading [um].", gt=0)
    breakage_step_um: float = entry(
        "Breakage step of the first loading [um]; smaller than the displacement step.", gt=0
    )
    later_displacement_step_um: float = entry(
        "Displacement step of every branch after the first loading [um].", gt=0
    )
    later_breakage_step_um: float = entry(
        "Breakage step of every branch after the first loading [um].", gt=0
    )
    target: Literal["equilibrate", "interpolate"] = entry(
        "equilibrate: repeat the last step, smaller, until the stress is met; interpolate: the "
        "paper's."
    )
    stress_tolerance: float = entry(
        "Relative distance to the maximum stress that counts as met.", gt=0, lt=1
    )
    force_tolerance: float = entry(
        "Relative residual of equilibrium that the fast solver reaches.", gt=0, lt=1
    )
    sweep_tolerance: float = entry(
        "Largest relative change of a force between two sweeps at which the reference stops.",
        gt=0,
        lt=1,
    )
    curve_points: int = entry(
        "Stresses of a closure curve, evenly spaced up to the maximum, where nothing breaks (fast "
        "solver).",
        ge=1,
        le=100_000,
    )
    most_steps: float = entry(
        "Displacement steps of a simulation, beyond which it is refused, or ends as "
        "too_many_steps.",
        ge=1,
    )
    most_breakage_steps: float = entry(
        "Breakage steps of a simulation for each of its cells, beyond which it is refused, or "
        "ends as breakage_not_at_rest.",
        ge=1,
    )
    replay: bool = entry(
        "Whether a cycle like the one before, whose unloading broke nothing, is that unloading's "
        "curve, up and down; false: it is closed again."
    )
    idle_interaction: float | None = entry(
        "The interaction is left out of the first loading while it would displace no contact by "
        "more than this share of the closure; 0: never; null: effects.auto, where that is given.",
        ge=0,
        lt=1,
    )
