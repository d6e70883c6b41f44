"""Section of the assessment of a study's rocks."""

from collections.abc import Iterator

from studies.frame.configuration import Configuration, StudySection, stress_problems
from studies.frame.keys import Jrc, Positive, Several, Share, entry


class AssessmentSection(StudySection):
    """Assessment of a study's rocks by variants of their base case: in the report, whose share of
    the time is limited, and by `make assess`, which closes all joints; null: none in the report.
    """

    of_scans = True
    by_default = True
    share: Share = entry(
        "Share of the expected time of the study that the joints of the assessment in its report "
        "may take, apart from four joints, which may take a minute; with `assessment: null` no "
        "joint is simulated.",
        0.1,
    )
    joints: int = entry(
        "Pairs of walls of each condition; in the report the largest number of them.",
        8,
        ge=2,
        le=1_000,
    )
    within: Share = entry(
        "Relative error that is requested of mean closures, and up to which an effect can be left "
        "out.",
        0.05,
    )
    jrc: Several[Jrc] = entry("Joint roughness coefficients; none: that of each rock.", ())
    stress: Several[Positive] = entry(
        "Maximum normal stresses [MPa]; none: that of each rock.", (), alias="stress_MPa"
    )

    def problems(self, configuration: Configuration) -> Iterator[str]:
        """Generate a line for each stress [Pa] that is not above the seating stress of the study.

        Further lines are for stresses that no walls of a rock can carry.
        """
        for stress in self.stress:
            if stress <= configuration.seating_stress:
                yield (
                    f"assessment.stress_MPa = {1e-6 * stress:g}: must be more than "
                    f"seating_stress_MPa ({1e-6 * configuration.seating_stress:g})"
                )
            rocks = configuration.rocks.items()
            cases = [("the strength of", f"rocks.{name}", rock) for name, rock in rocks]
            yield from stress_problems("assessment.stress_MPa", stress, cases, configuration)
