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
    cycles, seating = configuration.study.cycles, configuration.seating_stress
    return {
        name: CurveSettings(rock.measured, rock.max_normal_stress, cycles, seating)
        for name, rock in configuration.rocks.items()
        if rock.measured
    }


def measured_curves(
    settings: dict[str, CurveSettings], read: Callable[[str], str]
) -> dict[str, MeasuredCurve]:
    """Read and check measured curves by rock; ``read`` returns the text of a file.

    `InputError` if one is not valid; it names file, line and value, or the key of a missing file.
    """
    curves = {}
    for rock, of_rock in settings.items():
        about, largest = of_rock.measured, of_rock.max_normal_stress
        file = about.file
        if not Path(file).is_file():
            raise InputError(f"rocks.{rock}.measured.file = {file!r}: file not found")
        curve = parsed_curve(read(file), file, about.stress_unit, about.closure_unit)
        for line, cycle, stress in zip(curve.line, curve.cycle, curve.stress, strict=True):
            where = f"{file}, line {line}"
            if cycle > of_rock.cycles:
                raise InputError(
                    f"{where}: cycle = {cycle}: the study has study.cycles = {of_rock.cycles}"
                )
            if stress > largest * (1.0 + 1e-12):
                raise InputError(
                    f"{where}: stress = {1e-6 * stress:g} MPa: must be at most "
                    f"rocks.{rock}.max_normal_stress_MPa = {1e-6 * largest:g}"
                )
        check_loadings(curve, file, of_rock.seating_stress)
        curves[rock] = curve
    return curves
