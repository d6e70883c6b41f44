"""Section of the comparison with measured joints."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from studies.frame.configuration import Configuration, StudySection, stress_problems
from studies.frame.keys import Ascending, Positive, Several, entry


class MeasuredJointsSection(StudySection):
    """Design of the comparison with measured joints (measured_joints.yaml)."""

    mates = True
    mismatch_wavelength: Ascending[Positive] = entry(
        "Mismatch wavelengths [mm] among which that of a measured joint is fitted.",
        alias="mismatch_wavelength_mm",
        min_length=2,
    )
    compressive_strength: Several[Positive] = entry(
        "Compressive strengths that are tried besides that of the rock.",
        alias="compressive_strength_MPa",
    )
    peak_modulus_ratio: Several[Annotated[float, Field(gt=0, le=1)]] = entry(
        "Peak modulus ratios that are tried besides choices.peak_modulus_ratio."
    )
    largest_radius: Several[Positive] = entry(
        "Largest radii [mm] of asperities that are tried besides choices.largest_radius_mm.",
        alias="largest_radius_mm",
    )
    hardness_over_strength: Several[Positive] = entry(
        "Hardnesses over the compressive strength that are tried as a limit of the pressure, "
        "without gouge."
    )
    crushed_strength_ratio: Several[Annotated[float, Field(gt=0, le=1)]] = entry(
        "Strengths of crushed rock over that of the rock that are tried, besides "
        "choices.crushed_strength_ratio, with each strength."
    )
    reseating_shift_in_cells: Several[Annotated[int, Field(ge=0)]] = entry(
        "Shifts of the upper wall along x between the first and the later loading, in cells."
    )

    def problems(self, configuration: Configuration) -> Iterator[str]:
        """Generate what is not allowed: rocks, cycles, strengths and shifts."""
        study = configuration.study
        cells = configuration.grid.cells_x
        if len(study.rocks) != 1:
            yield f"study.rocks = {list(study.rocks)}: must be one rock (measured_joints)"
        if study.cycles < 2:
            yield f"study.cycles = {study.cycles}: must be at least 2 (measured_joints)"
        changed = "measured_joints.compressive_strength_MPa ="
        for name, rock in configuration.rocks.items():
            weaker = [
                (changed, f"{1e-6 * strength:g}", rock._replace(compressive_strength=strength))
                for strength in self.compressive_strength
            ]
            key = f"rocks.{name}.max_normal_stress_MPa"
            yield from stress_problems(key, rock.max_normal_stress, weaker, configuration)
        largest = max(self.reseating_shift_in_cells, default=0)
        if largest > cells - 8:
            yield (
                f"measured_joints.reseating_shift_in_cells = {largest}: must leave at least 8 of "
                f"grid.cells_x = {cells}"
            )
