"""Walls that are difficult for a solver, and keys of hard_cases.yaml, with extreme values."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import numpy as np
import pydantic
from pydantic import ConfigDict, Field, StringConstraints

from jointclosure.inputs import InputError
from jointclosure.joint.status import FLAGS
from jointclosure.walls.synthesis import wall_pair
from studies.frame.rocks import intact_keys


def shapes(shape: tuple[int, int], height: float) -> dict[str, Callable[[], tuple]]:
    """Return functions by kind of walls that make upper and lower wall (ny, nx) of a height [m]."""
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
        # one cell wide, along y above and along x below: they touch in single cells
        "ridges": lambda: (height * (x % 3 == 1), height * (y % 3 == 1)),
        # one cell wide, without curvature along them
        "parallel_ridges": lambda: (height * (x % 4 == 1),) * 2,
        # a level table: flat contacts inside, edges around
        "plateau": lambda: raised(tuple(slice(n // 4, n - n // 4) for n in shape)),
    }


SHAPES = tuple(shapes((4, 4), 1.0))


def hard_walls(
    kind: str, cells: tuple[int, int], spacing: float, height: float, jrc: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return upper and lower wall (ny, nx), heights towards the other wall [m].

    Raises
    ------
    InputError
        If the kind does not exist.
    """
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


class Keys(pydantic.BaseModel):
    """Group of keys; infinite numbers are allowed."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class RockKeys(intact_keys(Keys)):
    """Intact rock."""


def keys_like(values: Mapping[str, Any], **kinds: Any) -> type[Keys]:
    """Return a model of keys that have the types ``kinds``, or else those of their default values.

    A default of null stands for a number or null. A list has as many values as its default.
    """
    kinds = {name: _kind_of(value) for name, value in values.items()} | kinds
    return pydantic.create_model("Keys", __base__=Keys, **{k: (v, ...) for k, v in kinds.items()})


def _kind_of(value: Any) -> Any:
    if isinstance(value, dict):
        return keys_like(value)
    if isinstance(value, list):
        size = Field(min_length=len(value), max_length=len(value))
        return Annotated[list[_kind_of(value[0])], size]
    if isinstance(value, bool | str):
        return type(value)
    return float if value is not None else float | None


class MustKeys(Keys):
    """Requirements of a single case, see `studies.verification.hard_cases`."""

    same_as: keys_like({"case": "", "within": 0.0}) | None = None
    no_drift: keys_like({"from_cycle": 1, "within": 0.0}) | None = None
    forgets: keys_like({"within": 0.0}) | None = None
    closure: keys_like({"value_m": 0.0, "within": 0.0}) | None = None
    contact_fraction: keys_like({"least": 0.0, "most": 1.0}) | None = None
    nothing_breaks: bool | None = None
    no_force: bool | None = None


def case_keys(defaults: Mapping[str, Any]) -> type[Keys]:
    """Return the model of the keys of a case that is merged over the defaults."""
    words = {"name": Name, "group": Name, "hard": Sentence, "must_hold": Sentence}
    return keys_like(
        defaults,
        **words,
        walls=keys_like(defaults["walls"], kind=Literal[("self_affine", "mated", *SHAPES)]),
        rock=RockKeys,
        lower_rock=RockKeys | None,
        history_MPa=list[float] | None,
        breakage=Annotated[list[Literal["fixed_step", "resolved"]], Field(min_length=1)],
        expect=Literal[("answer", "refused", "success", *FLAGS.values())],
        must=MustKeys,
    )


class HardCasesKeys(Keys):
    """The file: defaults of all cases, and the cases."""

    defaults: dict[str, Any]
    cases: Annotated[list[dict[str, Any]], Field(min_length=1)]
