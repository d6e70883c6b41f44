"""Section of the study of what each effect adds."""

from typing import Annotated

from pydantic import Field

from studies.frame.config.section import (
    Jrc,
    Poisson,
    Positive,
    Section,
    Several,
    Share,
    StudySection,
    entry,
)


class Validation(Section):
    """Random conditions at which the effects that a pilot selects (effects.auto) are compared with
    the full model."""

    scenes: int = entry(
        "Number of random conditions: rock, roughness, stress and size.", ge=1, le=100_000
    )
    realizations: int = entry("Surfaces of each.", ge=2, le=100_000)
    tolerances: Several[Share] = entry("Tolerances of the selection.", min_length=1)
    cells: Several[Annotated[float, Field(ge=3, le=512)]] = entry(
        "Range of the cells along a square joint.", min_length=2, max_length=2
    )
    youngs_modulus: Several[Positive] = entry(
        "Range of Young's modulus [GPa], uniform in its logarithm.",
        min_length=2,
        max_length=2,
        alias="youngs_modulus_GPa",
    )
    poisson_ratio: Several[Poisson] = entry("Range of Poisson's ratio.", min_length=2, max_length=2)
    compressive_strength: Several[Positive] = entry(
        "Range of the compressive strength [MPa], uniform in its logarithm.",
        min_length=2,
        max_length=2,
        alias="compressive_strength_MPa",
    )
    jrc: Several[Jrc] = entry(
        "Range of the joint roughness coefficient.", min_length=2, max_length=2
    )
    stress: Several[Positive] = entry(
        "Range of the maximum normal stress [MPa], uniform in its logarithm; at most the strength.",
        min_length=2,
        max_length=2,
        alias="stress_MPa",
    )


class Ablation(StudySection):
    """Conditions of a study of what each effect adds (effects.yaml); every well-posed
    scene is closed at each."""

    name = "ablation"
    jrc: Several[Jrc] = entry("Joint roughness coefficients.", min_length=1)
    stress: Several[Positive] = entry(
        "Maximum normal stresses [MPa].", min_length=1, alias="stress_MPa"
    )
    validation: Validation | None = None


SECTION = Ablation
