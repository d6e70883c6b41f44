"""Measured closure curves that a study names, checked against its load."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve, check_loadings, parsed_curve
from studies.frame.config.model import Configuration
from studies.frame.config.rocks import MeasuredFile


class CurveSettings(NamedTuple):
    """Settings for the check of the measured curve of a rock [SI], and its file."""

    measured: MeasuredFile
    max_normal_stress: float
    cycles: int
    seating_stress: float


def curve_settings(configuration: Configuration) -> dict[str, CurveSettings]:
    """Return settings of the measured curves by rock, for rocks of the study that have one."""
    return {
        name: CurveSettings(
            rock.measured,
            rock.max_normal_stress,
            configuration.study.cycles,
            configuration.seating_stress,
        )
        for name, rock in configuration.rocks.items()
        if rock.measured
    }


def measured_curves(
    settings: dict[str, CurveSettings], read: Callable[[str], str]
) -> dict[str, MeasuredCurve]:
    """Read and check measured curves by rock; ``read`` returns the text of a file.

    Raises
    ------
    InputError
        If a curve is not valid; names file, line and value, or the key of a missing file.
    """
    curves = {}
    for name, curve_of_rock in settings.items():
        about = curve_of_rock.measured
        file = about.file
        if not Path(file).is_file():
            raise InputError(f"rocks.{name}.measured.file = {file!r}: file not found")
        curves[name] = parsed_curve(read(file), file, about.stress_unit, about.closure_unit)
        _check_curve(curves[name], name, curve_of_rock)
    return curves


def _check_curve(curve: MeasuredCurve, rock: str, settings: CurveSettings) -> None:
    """Refuse a curve that cannot be compared with the study."""
    name, cycles, largest = settings.measured.file, settings.cycles, settings.max_normal_stress
    for i in range(curve.stress.size):
        where = f"{name}, line {curve.line[i]}"
        if curve.cycle[i] > cycles:
            raise InputError(
                f"{where}: cycle = {curve.cycle[i]}: the study has study.cycles = {cycles}"
            )
        if curve.stress[i] > largest * (1.0 + 1e-12):
            raise InputError(
                f"{where}: stress = {1e-6 * curve.stress[i]:g} MPa: must be at most "
                f"rocks.{rock}.max_normal_stress_MPa = {1e-6 * largest:g}"
            )
    check_loadings(curve, name, settings.seating_stress)
