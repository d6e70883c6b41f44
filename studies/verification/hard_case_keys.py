"""Walls that are difficult for a solver, and keys of hard_cases.yaml, extreme values allowed."""

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
import pydantic
from pydantic import ConfigDict, Field, StringConstraints

from jointclosure.inputs import InputError
from jointclosure.joint.protocol import FLAGS
from jointclosure.walls.synthesis import wall_pair
from studies.frame import keys
from studies.frame.keys import entry
from studies.frame.rocks import intact_keys


def shapes(shape: tuple[int, int], height: float) -> dict[str, Callable[[], tuple]]:
    """Return functions that make upper and lower wall (ny, nx) of each kind."""
    y, x = np.indices(shape)
    v, u = np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in shape), indexing="ij")
    tie = np.random.default_rng(7)

    def raised(cells: tuple) -> tuple[np.ndarray, np.ndarray]:
        upper = np.zeros(shape)
        upper[cells] = height
        return upper, np.zeros(shape)

    def saddles() -> tuple[np.ndarray, np.ndarray]:
        saddle = height * (u**2 - v**2)
        return saddle, saddle.T.copy() if shape[0] == shape[1] else saddle.copy()

    return {
        "flat": lambda: (np.zeros(shape), np.zeros(shape)),
        "spike": lambda: raised((shape[0] // 2, shape[1] // 2)),
        # equal sums everywhere, and equal neighbours
        "tie": lambda: tuple(height * tie.integers(0, 4, shape).astype(float) for _ in range(2)),
        # crossed: one curves up where the other curves down
        "saddles": saddles,
        # concave everywhere, in touch at the corners
        "valleys": lambda: (height * (u**2 + v**2), height * (u**2 + v**2)),
        # every second cell a peak and the others valleys, in phase
        "egg_box": lambda: (height * np.where((y + x) % 2 == 0, 1.0, -1.0),) * 2,
        # of one cell, along y above and along x below: they cross in single cells
        "ridges": lambda: (height * (x % 3 == 1), height * (y % 3 == 1)),
        # without curvature along them
        "parallel_ridges": lambda: (height * (x % 4 == 1),) * 2,
        # a level table: flat contacts inside, edges around
        "plateau": lambda: raised(tuple(slice(n // 4, n - n // 4) for n in shape)),
    }


SHAPES = tuple(shapes((4, 4), 1.0))


def hard_walls(
    kind: str, cells: tuple[int, int], spacing: float, height: float, jrc: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return upper and lower wall (ny, nx), heights towards the other wall [m]."""
    shape = cells[0], cells[1]
    if kind == "self_affine":
        return wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
    if kind == "mated":
        upper, _ = wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
        return upper, -upper
    if kind not in SHAPES:
        raise InputError(f"walls.kind = {kind!r}: must be one of {', '.join(SHAPES)}")
    return shapes(shape, height)[kind]()


Name = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
Sentence = Annotated[str, StringConstraints(min_length=5)]
Within = Annotated[float, Field(ge=0)]


class Keys(pydantic.BaseModel):
    """Group of keys; infinite numbers are allowed."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class WallKeys(Keys):
    """A pair of walls."""

    kind: Literal[("self_affine", "mated", *SHAPES)] = entry("A shape, or random walls.")
    cells: list[Annotated[int, Field(ge=1)]] = entry("Along y and x.", min_length=2, max_length=2)
    height_um: float = entry("Scale of a shape's heights.")
    jrc: float = entry("Of random walls.")
    seed: int = entry("Of random walls.", ge=0)
    factor: float = entry("Of all heights.")
    offset_m: list[float] = entry("Added to upper and lower wall.", min_length=2, max_length=2)


class RockKeys(intact_keys(Keys)):
    """Intact rock."""


def _unbounded(model: type[pydantic.BaseModel], *left_out: str) -> type[pydantic.BaseModel]:
    """Keys of a section of a configuration, without bounds and without some of them."""
    keys: dict[str, Any] = {
        field.alias or name: (field.annotation, entry("As in the keys of a configuration."))
        for name, field in model.model_fields.items()
        if name not in left_out
    }
    return pydantic.create_model(model.__name__, __base__=Keys, __doc__=model.__doc__, **keys)


EffectKeys = _unbounded(keys.StudyEffects, "auto")
ChoiceKeys = _unbounded(keys.ChoiceKeys, "concave")
NumericsKeys = _unbounded(keys.NumericsKeys, "breakage", "target")


class SameAsKeys(Keys):
    """Another case that must have the same closures."""

    case: str = entry("Another case of the same way of breakage.")
    within: Within = entry("Relative.")


class NoDriftKeys(Keys):
    """Residual closures that must not drift."""

    from_cycle: int = entry("First cycle that counts.", ge=1)
    within: Within = entry("Of the residual closure, over the last cycle's maximum closure.")


class ForgetsKeys(Keys):
    """Cycles that must become equal."""

    within: Within = entry("Relative spread of the maximum closures from cycle 2 on.")


class ClosureKeys(Keys):
    """Known closure."""

    value_m: float = entry("Of the first cycle.")
    within: Within = entry("Relative.")


class FractionKeys(Keys):
    """Fraction of cells in contact."""

    least: float = entry("Of the largest fraction of cells in contact.")
    most: float = entry("The same.")


class MustKeys(Keys):
    """Requirements of a single case, see `studies.verification.requirements`."""

    same_as: SameAsKeys | None = entry(SameAsKeys.__doc__, None)
    no_drift: NoDriftKeys | None = entry(NoDriftKeys.__doc__, None)
    forgets: ForgetsKeys | None = entry(ForgetsKeys.__doc__, None)
    closure: ClosureKeys | None = entry(ClosureKeys.__doc__, None)
    contact_fraction: FractionKeys | None = entry(FractionKeys.__doc__, None)
    nothing_breaks: bool | None = entry("Whether there is no breakage step.", None)
    no_force: bool | None = entry("Whether no cell carries force.", None)


class CaseKeys(Keys):
    """A case, merged over the defaults."""

    name: Name = entry("Its row and its test.")
    group: Name = entry("Cases of a group are one job.")
    hard: Sentence = entry("What makes it hard.")
    must_hold: Sentence = entry("What must hold of it.")
    walls: WallKeys = entry(WallKeys.__doc__)
    spacing_mm: float = entry("Grid spacing.")
    rock: RockKeys = entry("Of both walls.")
    lower_rock: RockKeys | None = entry("Of the lower wall, where it differs.")
    swapped: bool = entry("The upper wall and its rock below.")
    max_normal_stress_MPa: float = entry("Target of every cycle.")
    max_normal_stress_Pa: float | None = entry("The same, in Pa.", None)
    target_is_first_step: bool = entry(
        "The target is the elastic stress at the end of the first displacement step."
    )
    closure_um: float | None = entry("A closure to find the equilibrium at, instead of cycles.")
    cycles: int = entry("Load cycles.")
    scale_lengths: float = entry("Of walls, spacing, steps and radius.")
    scale_stresses: float = entry("Of moduli, strengths and the load.")
    effects: EffectKeys = entry(EffectKeys.__doc__)
    choices: ChoiceKeys = entry(ChoiceKeys.__doc__)
    numerics: NumericsKeys = entry(NumericsKeys.__doc__)
    breakage: list[Literal["fixed_step", "resolved"]] = entry(
        "The ways of breakage to run the case with.", min_length=1
    )
    expect: Literal[("answer", "refused", "success", *FLAGS.values())] = entry(
        'What must come out, see docs/reference.md; "answer" is a success with or without remarks.'
    )
    message: str = entry("What the message of a refusal must hold.")
    seconds: float = entry("Time budget on one idle core: reported, not required.", gt=0)
    may_fall_short: float = entry(
        "Share of the target by which a maximum may lie below it where breakage jumps over it.",
        ge=0,
        le=1,
    )
    slow: bool = entry("Whether its test is marked slow.")
    must: MustKeys = entry(MustKeys.__doc__)


class HardCasesKeys(Keys):
    """The file: defaults of all cases, and the cases."""

    defaults: dict[str, Any] = entry("All keys of a case but its name and words.")
    cases: list[dict[str, Any]] = entry("Cases, see `CaseKeys`.", min_length=1)
