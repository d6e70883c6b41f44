"""Keys of the experiment on measured joints."""

from typing import Annotated

from pydantic import Field

from studies.frame.config.keys.entries import Keys, entry


class MeasuredJointsKeys(Keys):
    """Design of the comparison with measured joints (measured_joints.yaml)."""

    mismatch_wavelength_mm: list[Annotated[float, Field(gt=0)]] = entry(
        "Mismatch wavelengths [mm] among which that of a measured joint is fitted.",
        min_length=2,
        json_schema_extra={"uniqueItems": True},
    )
    compressive_strength_MPa: list[Annotated[float, Field(gt=0)]] = entry(
        "Compressive strengths that are tried besides that of the rock."
    )
    peak_modulus_ratio: list[Annotated[float, Field(gt=0, le=1)]] = entry(
        "Peak modulus ratios that are tried besides choices.peak_modulus_ratio."
    )
    largest_radius_mm: list[Annotated[float, Field(gt=0)]] = entry(
        "Largest radii [mm] of asperities that are tried besides choices.largest_radius_mm."
    )
    hardness_over_strength: list[Annotated[float, Field(gt=0)]] = entry(
        "Hardnesses over the compressive strength that are tried as a limit of the pressure, "
        "without gouge."
    )
    reseating_shift_in_cells: list[Annotated[int, Field(ge=0)]] = entry(
        "Shifts of the upper wall along x between the first and the later loading, in cells."
    )
