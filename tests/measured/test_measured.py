"""Measured curves: what can be read and what is refused."""

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.measured.curves import parsed_curve
from studies.frame.rocks import MeasuredFile
from studies.paper.measured import CurveSettings, measured_curves
from studies.paper.needs import curve_settings
from tests.studied import study_of

HEADER = "stress_MPa,closure_mm,cycle\n"
GOOD = HEADER + "0,0,1\n1,0.1,1\n2,0.15,1\n1,0.14,1\n0,0.1,1\n"


def curve_of(text, **units):
    return parsed_curve(text, "lab.csv", **units)


def test_a_curve_is_read_in_si_with_its_lines():
    curve = curve_of("# a comment\n\n" + GOOD)
    np.testing.assert_allclose(curve.stress, [0.0, 1e6, 2e6, 1e6, 0.0])
    np.testing.assert_allclose(curve.closure, [0.0, 1e-4, 1.5e-4, 1.4e-4, 1e-4])
    assert curve.cycle.tolist() == [1] * 5
    assert curve.line.tolist() == [4, 5, 6, 7, 8]
    up, down = curve.branches(1).values()
    assert up[0].tolist() == [0.0, 1e6, 2e6]
    assert down[0].tolist() == [1e6, 0.0]


NUMBERED = {"names": ["1", "2"], "stress_unit": "kPa", "closure_unit": "um", "cycle": 1}


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("cycle, closure_um ,stress_GPa\n1,100,0.001\n", {}),
        ("stress,closure,cycle\n1,0.1,1\n", {"stress_unit": "MPa", "closure_unit": "mm"}),
        ("\ufeffstress_Pa,closure_m,cycle\n1e6,1e-4,1\n", {"stress_unit": "GPa"}),
        ("stress_MPa  closure_mm cycle\n1 0,1  1\n", {}),
        ("stress_MPa;closure_mm;cycle\n1,0;0,1;1\n", {}),
        ("Stress (MPa); t (s); Closure [mm]; cycle\n1;7;0.1;1\n", {}),
        ("stress\tclosure\tcycle\tx\nMPa\tmm\t-\ts\n1\t0.1\t1\tfree text\n", {}),
        ("stress_kPa,closure_um\n1000,100\n", {"cycle": 1}),
        ("sigma_n,d\n1000,100\n", NUMBERED),
        ("1000,100\n", NUMBERED),
    ],
)
def test_units_are_those_of_the_header_or_of_the_configuration(text, units):
    curve = curve_of(text, **units)
    np.testing.assert_allclose([curve.stress[0], curve.closure[0]], [1e6, 1e-4])


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("", "lab.csv: has no header"),
        (HEADER + "1,0.1x,1\n", "lab.csv, line 2: closure = '0.1x': must be a finite number"),
        (HEADER + "1,0.1,1.5\n", "lab.csv, line 2: cycle = 1.5: must be a whole number"),
        (HEADER + "1,0,1,1\n", "line 2: '1,0,1,1' has 4 values, the header has 3"),
        ("stress_MPa,closure_mm\n1,2\n", "line 1: lacks cycle"),
        ("stress_MPa,depth_mm,cycle\n1,2,1\n", "lacks closure (columns are stress_MPa,closure_mm"),
        ("stress_MPa;closure_mm;cycle\n1;0,2,3;1\n", "closure = '0,2,3'"),
        ("stress_psi,closure_mm,cycle\n1,2,1\n", "unit 'psi' must be one of Pa, kPa, MPa, GPa"),
        ("stress,closure,cycle\n0,0,1\n", "or state the key stress_unit: one of"),
        (("0,0\n5,1\n", 1, ["1", "3"]), "or their numbers from 1 to 2"),
    ],
)
def test_what_is_wrong_is_said_with_file_line_and_value(text, printed):
    text, *stated = (text,) if isinstance(text, str) else text
    with pytest.raises(InputError) as error:
        curve_of(text, **dict(zip(("cycle", "names"), stated, strict=False)))
    assert printed in str(error.value)


def settings(tmp_path, text):
    path = tmp_path / "lab.csv"
    path.write_text(text)
    return {"one": CurveSettings(MeasuredFile(file=str(path)), 2e6, 2, 0.5e6)}


def test_only_rocks_with_a_file_have_a_curve(tmp_path):
    assert list(measured_curves(settings(tmp_path, GOOD))) == ["one"]
    rocks = {"slate": {"measured": {"file": "lab.csv", "stress_unit": "MPa"}}}
    (stated,) = curve_settings(study_of({"rocks": rocks})).values()
    assert stated == CurveSettings(MeasuredFile(file="lab.csv", stress_unit="MPa"), 30e6, 2, 0.5e6)


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        (GOOD + "0,0,3\n", "line 7: cycle = 3: the study has study.cycles = 2"),
        (HEADER + "0,0,2\n0,0,1\n", "line 3: cycle = 1 after cycle 2"),
        (HEADER + "0,0,1\n2.5,1,1\n", "line 3: stress = 2.5 MPa: must be at most rocks.one.max"),
        (HEADER + "0,0,1\n0.4,1,1\n", "no stress of cycle 1 is above seating_stress_MPa = 0.5"),
    ],
)
def test_a_curve_that_the_study_cannot_be_held_against_is_refused(tmp_path, text, printed):
    with pytest.raises(InputError) as error:
        measured_curves(settings(tmp_path, text))
    assert printed in str(error.value)
    assert "lab.csv" in str(error.value)
