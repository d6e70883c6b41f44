"""Keys of hard_cases.yaml, which may have extreme values."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import pydantic
from pydantic import ConfigDict, Field, StringConstraints

from jointclosure.joint.status import FLAGS
from studies.frame.rocks import intact_keys
from studies.verification.hard_walls import SHAPES

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
