"""Section of the study of what each effect adds."""

from studies.frame.config.section import (
    Jrc,
    Positive,
    Several,
    StudySection,
    entry,
)


class Ablation(StudySection):
    """Conditions of a study of what each effect adds (effects.yaml); every well-posed
    scene is closed at each."""

    name = "ablation"
    jrc: Several[Jrc] = entry("Joint roughness coefficients.", min_length=1)
    stress: Several[Positive] = entry(
        "Maximum normal stresses [MPa].", min_length=1, alias="stress_MPa"
    )


SECTION = Ablation
