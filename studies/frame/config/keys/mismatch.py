"""Keys of the experiment on mated, natural and non-mated walls."""

from typing import Annotated

from pydantic import Field

from studies.frame.config.keys.entries import Keys, entry


class MismatchKeys(Keys):
    """Design of a study of mated, natural and non-mated walls (mismatch.yaml)."""

    wavelength_mm: list[Annotated[float, Field(ge=0)]] = entry(
        "Mismatch wavelengths [mm], 0 for mates; independent walls are closed too.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    shift_in_cells: list[Annotated[int, Field(ge=0, le=4096)]] = entry(
        "Shifts of the walls along x, in cells; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    tolerance: float = entry(
        "Shifted walls behave as independent ones where the mean closure since seating of the "
        "first cycle is less below theirs than this share.",
        gt=0,
        lt=1,
    )
