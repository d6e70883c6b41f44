"""Section of the study of the scale effect."""

import math
from collections.abc import Iterator

from jointclosure.inputs import InputError
from jointclosure.walls.synthesis import spectrum_of
from studies.frame.configuration import Configuration, StudySection
from studies.frame.keys import Ascending, Name, Positive, Section, SurfaceSynthesis, entry


class SizeSpectrum(Section):
    """Spectrum of the walls of a study of the scale effect; as in `surface`."""

    hurst: float = SurfaceSynthesis.model_fields["hurst"]  # type: ignore[assignment]
    roll_off: float | None = SurfaceSynthesis.model_fields["roll_off"]  # type: ignore[assignment]


class SizeSection(StudySection):
    """Design of a study of the scale effect (size.yaml): patches cut out of larger walls,
    and sampled at several spacings."""

    mates = True
    patch: Ascending[Positive] = entry(
        "Side lengths of the square patches [mm], each a whole number of times in the largest; "
        "that of the grid must be among them.",
        alias="patch_mm",
        min_length=2,
    )
    spacing: Ascending[Positive] = entry(
        "Spacings [mm], whole multiples of the finest; that of the grid must be among them.",
        alias="spacing_mm",
        min_length=1,
    )
    most_cells: int = entry(
        "Cells along a side beyond which a patch is closed at the spacing of the grid only.",
        ge=3,
        le=4096,
    )
    spectra: dict[Name, SizeSpectrum] = entry(
        "Spectra of the walls by name, all made of the same noise.", min_length=1
    )

    def problems(self, configuration: Configuration) -> Iterator[str]:
        """Generate what is not allowed: sizes that do not fit into each other, a wrong spectrum."""
        grid = configuration.grid
        surface = configuration.surface
        finest = self.spacing[0]
        largest = self.patch[-1]
        for spacing in self.spacing:
            if not _whole(spacing / finest):
                yield f"size.spacing_mm = {1e3 * spacing:g}: must be a multiple of {1e3 * finest:g}"
        for patch in self.patch:
            if not _whole(largest / patch):
                yield f"size.patch_mm = {1e3 * patch:g}: must be a whole part of {1e3 * largest:g}"
            for spacing in self.spacing:
                if not _whole(patch / spacing):
                    yield (
                        f"size.patch_mm = {1e3 * patch:g}: must be a multiple of the spacing "
                        f"{1e3 * spacing:g}"
                    )
        base = (grid.cells_x * grid.spacing, grid.cells_y * grid.spacing)
        if base[0] != base[1] or not _among(base[0], self.patch):
            yield f"size.patch_mm: must have the side of the grid, {1e3 * base[0]:g} (a square)"
        if not _among(grid.spacing, self.spacing):
            yield f"size.spacing_mm: must have grid.spacing_mm = {1e3 * grid.spacing:g}"
        for name, spectrum in self.spectra.items():
            try:
                spectrum_of(spectrum.hurst, surface.rule, spectrum.roll_off, finest)
            except InputError as error:
                yield f"size.spectra.{name}: {error}"


def _whole(ratio: float) -> bool:
    return math.isfinite(ratio) and abs(ratio - round(ratio)) < 1e-9 * ratio


def _among(value: float, values: tuple[float, ...]) -> bool:
    return any(abs(value - other) < 1e-9 * value for other in values)
