"""Sections of a configuration: keys of a file with unit, bounds and description, read in SI.

A section is checked in the units of its keys, and has SI values once it is read: the key
``spacing_mm`` of a file is the attribute ``spacing`` [m].
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    Strict,
    StringConstraints,
)
from pydantic_core import CoreSchema, core_schema

from jointclosure.parameters import PROPERTIES
from jointclosure.parameters.units import name_and_unit, to_si

if TYPE_CHECKING:
    from studies.frame.config.model import Configuration

T = TypeVar("T")
Several = Annotated[tuple[T, ...], Strict(False)]
Ascending = Annotated[Several[T], AfterValidator(lambda values: tuple(sorted(values)))]
Name = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]{0,40}$")]
Text = Annotated[str, StringConstraints(min_length=1)]
Positive = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(gt=0, lt=1)]
Jrc = Annotated[float, Field(**PROPERTIES["jrc"].bounds)]
Poisson = Annotated[float, Field(**PROPERTIES["poisson_ratio"].bounds)]


def entry(description: str, default: Any = ..., *, alias: str | None = None, **about: Any) -> Any:
    """Declare a key: what it is, its default in SI if it may be left out, and its bounds.

    ``alias`` is its name in files where that ends in a unit; bounds are in this unit. Other
    arguments are those of `pydantic.Field`; ``unique`` keys are lists without equal values.
    """
    if about.pop("unique", False):
        about["json_schema_extra"] = {"uniqueItems": True}
    field = Field(default, description=description, alias=alias, **about)
    if alias is not None and name_and_unit(alias)[1]:
        field.metadata.append(AfterValidator(lambda value: _in_si(alias, value)))
    return field


def _in_si(name: str, value: Any) -> Any:
    (converted,) = to_si({name: value}).values()
    return tuple(converted) if isinstance(converted, list) else converted


class Section(BaseModel):
    """Keys that stand together; an unknown one is an error."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)

    def _replace(self, **changes: Any) -> Self:
        """Return a copy with other values [SI], which are not checked."""
        return self.model_copy(update=changes)


class Made:
    """Annotation of a named tuple that is read as a section with keys of its fields."""

    def __init__(self, section: type[Section]):
        self.section = section

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the section, whose result is the named tuple."""

        def made(section: Section) -> Any:  # checked with the whole configuration
            return kind._make(getattr(section, name) for name in kind._fields)

        return core_schema.no_info_after_validator_function(made, handler(self.section))


class OrNull:
    """Annotation of a value that is null in a file until the section is read as a whole."""

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the value, or of null."""
        return core_schema.nullable_schema(handler(kind))


class StudySection(Section):
    """Section of one experiment, in the module ``section`` of its folder as ``SECTION``."""

    name: ClassVar[str]
    """Key of the section."""
    separate: ClassVar[bool] = False
    """Whether it holds keys of other configurations, which are checked with these."""

    def problems(self, configuration: "Configuration") -> Iterator[str]:
        """Generate contradictions within the section, and with the study; one line each."""
        yield from ()
