"""Keys of the experiment on tilted and rotated walls."""

from typing import Annotated

from pydantic import Field

from studies.frame.config.keys.entries import Keys, entry


class MisalignmentKeys(Keys):
    """Design of a study of walls that are tilted or rotated (misalignment.yaml)."""

    tilt_degrees: list[Annotated[float, Field(ge=0, le=5)]] = entry(
        "Tilts of one wall about an axis in its mean plane [degrees]; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    rotation_degrees: list[Annotated[float, Field(ge=0, lt=360)]] = entry(
        "Rotations of one wall about the normal [degrees]; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    mismatch_wavelength_mm: list[Annotated[float, Field(gt=0)]] = entry(
        "Mismatch wavelengths [mm] of walls that are closed besides independent ones.",
        json_schema_extra={"uniqueItems": True},
    )
