"""Section of the study of mated, natural and non-mated walls."""

from typing import Annotated

from pydantic import Field

from studies.frame.configuration import StudySection
from studies.frame.keys import Ascending, WithZero, entry


class MismatchSection(StudySection):
    """Design of a study of mated, natural and non-mated walls (mismatch.yaml)."""

    mates = True
    wavelength: Ascending[Annotated[float, Field(ge=0)]] = entry(
        "Mismatch wavelengths [mm], 0 for mates; independent walls are closed too.",
        alias="wavelength_mm",
        min_length=1,
    )
    shift_in_cells: WithZero[Annotated[int, Field(ge=0, le=4096)]] = entry(
        "Shifts of the walls along x, in cells; 0 must be among them.", min_length=1
    )
    tolerance: float = entry(
        "Shifted walls behave as independent ones where the mean closure since seating of the "
        "first cycle is less below theirs than this share.",
        gt=0,
        lt=1,
    )
