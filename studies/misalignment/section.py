"""Section of the study of tilted and rotated walls."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from studies.frame.configuration import Configuration, StudySection
from studies.frame.keys import Ascending, Positive, WithZero, entry


class MisalignmentSection(StudySection):
    """Design of a study of walls that are tilted or rotated (misalignment.yaml)."""

    mates = True
    tilt_degrees: WithZero[Annotated[float, Field(ge=0, le=5)]] = entry(
        "Tilts of one wall about an axis in its mean plane [degrees]; 0 must be among them.",
        min_length=1,
    )
    rotation_degrees: WithZero[Annotated[float, Field(ge=0, lt=360)]] = entry(
        "Rotations of one wall about the normal [degrees]; 0 must be among them.", min_length=1
    )
    mismatch_wavelength: Ascending[Positive] = entry(
        "Mismatch wavelengths [mm] of walls that are closed besides independent ones.",
        alias="mismatch_wavelength_mm",
    )

    def problems(self, configuration: Configuration) -> Iterator[str]:
        """Generate what is not allowed: a grid that is not square, another normalisation."""
        grid = configuration.grid
        surface = configuration.surface
        if grid.cells_x != grid.cells_y:
            yield (
                f"grid.cells_x = {grid.cells_x}: must be cells_y ({grid.cells_y}) where walls "
                "are rotated (misalignment)"
            )
        if surface.normalise != "wall":
            yield f"surface.normalise = {surface.normalise!r}: must be 'wall' (misalignment)"
