"""Section of the study in which properties and open choices vary together."""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from jointclosure.inputs import did_you_mean
from jointclosure.parameters import PROPERTIES, key_of
from studies.frame.configuration import Configuration, StudySection
from studies.frame.keys import Name, Section, Several, Text, entry, must

ROCK = "ROCK"
"""Placeholder for the name of a rock in the key of an input."""
VARIED = ("rocks", "surface", "effects", "choices", "numerics")
"""Sections of a configuration whose keys can vary; others would change the set of surfaces."""
PROPERTY_OF = {f"rocks.{ROCK}.{key_of(name)}": name for name in PROPERTIES}
"""Properties of a rock by their keys."""


class Input(Section):
    """A key that varies in a study of global sensitivity."""

    title: Text = entry("Its name in tables and figures.")
    path: Annotated[str, StringConstraints(pattern=r"^[a-z]+([.][A-Za-z_]+)+$")] = entry(
        "Its path, as surface.hurst; ROCK stands for the rock, as rocks.ROCK.jrc.", alias="key"
    )
    between: (
        Annotated[str, StringConstraints(pattern="^levels$")]
        | Annotated[Several[float], Field(min_length=2, max_length=2)]
        | None
    ) = entry("Ends of its range; levels: the outermost of the rock's own.", None)
    logarithmic: bool = entry("Whether it is uniform in its logarithm.", False)
    values: Annotated[Several[Any], Field(min_length=2)] | None = entry(
        "The few values that it has, in place of a range.", None
    )

    @property
    def parts(self) -> list[str]:
        """Return the names of the sections and of the key."""
        return self.path.split(".")

    @property
    def of_rock(self) -> str | None:
        """Return the name of the rock's property that the key sets; None if it sets none."""
        return PROPERTY_OF.get(self.path)


class Dependent(Section):
    """Two inputs that depend on each other, for Shapley effects."""

    inputs: Several[Name] = entry("Their names.", min_length=2, max_length=2)
    correlation: float = entry("Of the normal variables whose ranks they have.", gt=-1, lt=1)


class GlobalSensitivitySection(StudySection):
    """Design of a study in which properties and open choices vary together
    (global_sensitivity.yaml)."""

    rows: Annotated[int, must("be a power of 2", lambda rows: not rows & (rows - 1))] = entry(
        "Rows of the design, a power of 2; each closes two joints at every point, of which there "
        "are two more than inputs.",
        ge=16,
        le=65536,
    )
    rows_per_job: int = entry("Rows that a job closes.", ge=1)
    inputs: dict[Name, Input] = entry("What varies, by name.", min_length=2)
    dependent: Several[Dependent] = entry("Inputs that depend on each other.", ())

    def problems(self, configuration: Configuration) -> Iterator[str]:
        """Generate contradictions of inputs and rows."""
        for name, one in self.inputs.items():
            yield from _input_problems(f"global_sensitivity.inputs.{name}", one)
        for pair in self.dependent:
            for name in pair.inputs:
                if name not in self.inputs:
                    known = ", ".join(self.inputs)
                    meant = did_you_mean(name, self.inputs)
                    yield f"global_sensitivity.dependent = {name!r}: must be one of {known}{meant}"


def _input_problems(where: str, one: Input) -> Iterator[str]:
    if (one.between is None) == (not one.values):
        yield f"{where}: must have either between or values"
    if one.path.partition(".")[0] not in VARIED:
        yield f"{where}.key = {one.path}: must begin with {', '.join(VARIED)}"
    if isinstance(one.between, tuple):
        low, high = one.between
        if one.logarithmic and not low > 0.0:
            yield f"{where}.between = {[low, high]}: must be positive"
        if not low < high:
            yield f"{where}.between = {[low, high]}: must ascend"
    elif one.between == "levels" and one.path not in PROPERTY_OF:
        yield f"{where}.between = levels: {one.path} has none"
