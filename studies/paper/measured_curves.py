"""Measured curves that a study has for its rocks."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve, check_curve, parsed_curve
from jointclosure.storage.files import read_text
from studies.frame.configuration import Configuration
from studies.frame.rocks import MeasuredFile


class CurveSettings(NamedTuple):
    """File of a rock's measured curve, and settings [SI] by which the curve is checked."""

    measured: MeasuredFile
    max_normal_stress: float
    cycles: int
    seating_stress: float


def curve_settings(study: Configuration) -> dict[str, CurveSettings]:
    """Return the settings of the measured curves of a study by rock."""
    cycles = study.study.cycles
    seating = study.seating_stress
    return {
        name: CurveSettings(rock.measured, rock.max_normal_stress, cycles, seating)
        for name, rock in study.rocks.items()
        if rock.measured
    }


def measured_curves(settings: dict[str, CurveSettings]) -> dict[str, MeasuredCurve]:
    """Read and check measured curves by rock, whose files exist (`check_files` of rocks).

    Raises
    ------
    InputError
        If a file is not a curve, or if a curve has more cycles or larger stresses than the study.
    """
    curves = {}
    for rock, of_rock in settings.items():
        about = of_rock.measured
        largest = of_rock.max_normal_stress
        file = about.file
        area = None if about.area_mm2 is None else 1e-6 * about.area_mm2
        units = about.stress_unit, about.closure_unit
        curve = parsed_curve(read_text(file), file, *units, area=area)
        for cycle in curve.cycles:
            here = curve.cycle == cycle
            if cycle > of_rock.cycles:
                raise InputError(
                    f"{file}, line {curve.line[here][0]}: cycle = {cycle}: the study has "
                    f"study.cycles = {of_rock.cycles}"
                )
            # branches average the points of a dense log, so that its scatter does not count
            highest = max(float(stress.max()) for stress, _ in curve.branches(cycle).values()
                          if stress.size)  # fmt: skip
            if highest > largest * (1.0 + 1e-12):
                line = curve.line[here][int(np.argmax(curve.stress[here]))]
                raise InputError(
                    f"{file}, line {line}: stress = {1e-6 * highest:g} MPa: must be at most "
                    f"rocks.{rock}.max_normal_stress_MPa = {1e-6 * largest:g}"
                )
        check_curve(curve, file, of_rock.seating_stress)
        curves[rock] = curve
    return curves
