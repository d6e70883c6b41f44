"""Keys of the experiment on the scale effect."""

from studies.frame.config.keys.entries import Keys, Name, Positive, entry


class SizeSpectrumKeys(Keys):
    """Spectrum of the walls of a study of the scale effect; as in `surface`."""

    hurst: float = entry("Hurst exponent H.", gt=0, le=1)
    roll_off_mm: float | None = entry(
        "Wavelength beyond which the power spectrum is flat [mm]; null for none.", gt=0
    )


class SizeKeys(Keys):
    """Design of a study of the scale effect (size.yaml): patches cut out of larger walls,
    and sampled at several spacings."""

    patch_mm: list[Positive] = entry(
        "Side lengths of the square patches [mm], each a whole number of times in the largest; "
        "that of the grid must be among them.",
        min_length=2,
        json_schema_extra={"uniqueItems": True},
    )
    spacing_mm: list[Positive] = entry(
        "Spacings [mm], whole multiples of the finest; that of the grid must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    most_cells: int = entry(
        "Cells along a side beyond which a patch is closed at the spacing of the grid only.",
        ge=3,
        le=4096,
    )
    spectra: dict[Name, SizeSpectrumKeys] = entry(
        "Spectra of the walls by name, all made of the same noise.", min_length=1
    )
