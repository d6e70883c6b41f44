"""Which walls are closed, and how far out of alignment."""

from typing import NamedTuple

from jointclosure.config.files import ConfigurationError
from jointclosure.config.keys import MisalignmentKeys
from jointclosure.config.typed import Configuration
from jointclosure.config.units import to_si
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.wavelengths import labelled_wavelengths


class Design(NamedTuple):
    """Tilts and rotations [degrees], both with 0 first, and mismatch wavelengths [m] by label."""

    tilts: tuple[float, ...]
    rotations: tuple[float, ...]
    wavelengths: dict[str, float | None]

    @property
    def conditions(self) -> list[tuple[float, float]]:
        """Tilt and rotation of each condition: aligned first, then all tilts, then rotations."""
        return [(tilt, 0.0) for tilt in self.tilts] + [(0.0, turn) for turn in self.rotations[1:]]


class MisalignedSettings(NamedTuple):
    """What the closures of a rock's walls at one mismatch wavelength depend on.

    ``conditions`` are pairs of tilt and rotation [degrees].
    """

    closures: ClosureSettings
    mismatch_wavelength: float | None
    conditions: list[tuple[float, float]]


def design_of(keys: dict) -> Design:
    """The design in a configuration's ``misalignment`` section.

    Raises
    ------
    ConfigurationError
        Walls that are not those of the study to set, or cannot be rotated.
    """
    section = MisalignmentKeys.model_validate(keys["misalignment"])
    problems = []
    grid, surface = keys["grid"], keys["surface"]
    if grid["cells_x"] != grid["cells_y"]:
        problems.append(
            f"grid.cells_x = {grid['cells_x']}: must be cells_y ({grid['cells_y']}) where walls "
            "are rotated (misalignment)"
        )
    given = (surface["mismatch_wavelength_mm"], surface["correlation"], surface["shift_in_cells"])
    if given != (None, 0.0, 0):
        problems.append(
            "misalignment: the study sets surface.mismatch_wavelength_mm; it, correlation and "
            "shift_in_cells must be null, 0 and 0"
        )
    if surface["normalise"] != "wall":
        problems.append(
            f"surface.normalise = {surface['normalise']!r}: must be 'wall' (misalignment)"
        )
    for name in ("tilt_degrees", "rotation_degrees"):
        if 0.0 not in getattr(section, name):
            problems.append(f"misalignment.{name}: must have 0 among them")
    if problems:
        raise ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in problems))
    lengths = to_si(section.model_dump())["mismatch_wavelength"]
    return Design(
        tuple(sorted(section.tilt_degrees)),
        tuple(sorted(section.rotation_degrees)),
        labelled_wavelengths(sorted(lengths)),
    )


def settings_of(
    design: Design, configuration: Configuration, rock: str, label: str
) -> MisalignedSettings:
    """Settings of a rock's closures at one mismatch wavelength; all have the same surfaces."""
    case = base_case(rock, configuration.rocks[rock])
    surfaces = surface_settings(configuration, case, range(configuration.study.realizations))
    closures = closure_settings(configuration, case, surfaces)
    return MisalignedSettings(closures, design.wavelengths[label], design.conditions)
