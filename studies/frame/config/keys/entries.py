"""Parts of keys of a configuration's file: types with bounds, and entries with descriptions."""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from jointclosure.parameters import PROPERTIES

NAME = r"^[a-z][a-z0-9_]{0,40}$"
Name = Annotated[str, StringConstraints(pattern=NAME)]
Text = Annotated[str, StringConstraints(min_length=1)]
SectionKey = Annotated[str, StringConstraints(pattern=r"^[a-z]+[.][A-Za-z_]+$")]
Positive = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(gt=0, lt=1)]
Jrc = Annotated[float, Field(**PROPERTIES["jrc"].bounds)]
Poisson = Annotated[float, Field(**PROPERTIES["poisson_ratio"].bounds)]


def entry(description: str, default: Any = ..., **bounds):
    """A key with what it is; one with a default may be left out."""
    return Field(default, description=description, **bounds)


class Keys(BaseModel):
    """Keys that stand together; closed: an unknown one is an error."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)
