"""Measured curves that a study has for its rocks."""

from pathlib import Path
from typing import NamedTuple

from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve, check_loadings, parsed_curve
from jointclosure.storage.files import read_text
from studies.frame.rocks import MeasuredFile


class CurveSettings(NamedTuple):
    """Settings for the check of the measured curve of a rock [SI], and its file."""

    measured: MeasuredFile
    max_normal_stress: float
    cycles: int
    seating_stress: float


def measured_curves(settings: dict[str, CurveSettings]) -> dict[str, MeasuredCurve]:
    """Read and check measured curves by rock."""
    curves = {}
    for rock, of_rock in settings.items():
        about, largest = of_rock.measured, of_rock.max_normal_stress
        file = about.file
        if not Path(file).is_file():
            raise InputError(f"rocks.{rock}.measured.file = {file!r}: file not found")
        curve = parsed_curve(read_text(file), file, about.stress_unit, about.closure_unit)
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
