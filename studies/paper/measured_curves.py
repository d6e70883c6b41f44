"""Measured closure curves that the configuration of a study states for its rocks."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve, check_curve, parsed_curve
from jointclosure.storage.files import read_text
from studies.frame.configuration import Configuration
from studies.frame.rocks import MeasuredFile


class CurveSettings(NamedTuple):
    """File of a rock's measured curve, and settings [SI] of the study that the curve must fit."""

    measured: MeasuredFile
    max_normal_stress: float
    cycles: int
    seating_stress: float


def curve_settings(study: Configuration) -> dict[str, CurveSettings]:
    """Return the settings of a study's measured curves, by rock, for rocks that have one."""
    cycles = study.study.cycles
    seating = study.seating_stress
    return {
        name: CurveSettings(rock.measured, rock.max_normal_stress, cycles, seating)
        for name, rock in study.rocks.items()
        if rock.measured
    }


def measured_curves(settings: dict[str, CurveSettings]) -> dict[str, MeasuredCurve]:
    """Return the measured curves by rock, read from their files and checked.

    That the files exist has been checked before (`studies.frame.rocks.check_files`).

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
