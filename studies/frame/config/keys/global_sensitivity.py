"""Keys of the experiment in which properties and open choices vary together."""

from typing import Annotated, Any

from pydantic import Field, StringConstraints

from studies.frame.config.keys.entries import Keys, Name, Text, entry


class InputKeys(Keys):
    """A key that varies in a study of global sensitivity."""

    title: Text = entry("Its name in tables and figures.")
    key: Annotated[str, StringConstraints(pattern=r"^[a-z]+([.][A-Za-z_]+)+$")] = entry(
        "Its path, as surface.hurst; ROCK stands for the rock, as rocks.ROCK.jrc."
    )
    between: (
        Annotated[str, StringConstraints(pattern="^levels$")]
        | Annotated[list[float], Field(min_length=2, max_length=2)]
        | None
    ) = entry("Ends of its range; levels: the outermost of the rock's own.", None)
    logarithmic: bool = entry("Whether it is uniform in its logarithm.", False)
    values: list[Any] | None = entry("The few values that it has, in place of a range.", None)


class DependentKeys(Keys):
    """Two inputs that depend on each other, for Shapley effects."""

    inputs: list[Name] = entry("Their names.", min_length=2, max_length=2)
    correlation: float = entry("Of the normal variables whose ranks they have.", gt=-1, lt=1)


class GlobalSensitivityKeys(Keys):
    """Design of a study in which properties and open choices vary together
    (global_sensitivity.yaml)."""

    rows: int = entry(
        "Rows of the design, a power of 2; each closes two joints at every point, of which there "
        "are two more than inputs.",
        ge=16,
        le=65536,
    )
    rows_per_job: int = entry("Rows that a job closes.", ge=1)
    inputs: dict[Name, InputKeys] = entry("What varies, by name.", min_length=2)
    dependent: list[DependentKeys] = entry("Inputs that depend on each other.", [])
