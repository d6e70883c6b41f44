"""Measured curves are read, or refused with what is wrong with them."""

import re

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import cautions
from jointclosure.measured.curves import MeasuredCurve, check_curve, parsed_curve
from jointclosure.measured.headings import CLOSURE_UNITS, FORCE_UNITS, heading_of
from jointclosure.measured.joint_arguments import asked_joints
from jointclosure.measured.likelihood import reading_sentences, readings_of_curve
from studies.frame.rocks import MeasuredFile
from studies.paper.measured_curves import CurveSettings, curve_settings, measured_curves
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
        (HEADER + '"1,5",0.1,1\n', "lab.csv, line 2: stress = '1,5': must be a finite number"),
        (HEADER + "1,0.1,0\n", "lab.csv, line 2: cycle = 0: must be a whole number of at least 1"),
        ("stress_MPa,stress_Pa,closure_mm,cycle\n1,1,1,1\n", "must be the only one of stress"),
        (HEADER + "1,0,1,1\n", "line 2: '1,0,1,1' has 4 values, the header has 3"),
        ("stress_MPa,closure_mm\n1,2\n", "line 1: lacks cycle"),
        ("stress_MPa,depth_mm,cycle\n1,2,1\n", "lacks closure (columns are stress_MPa,closure_mm"),
        ("stress_MPa;closure_mm;cycle\n1;0,2,3;1\n", "closure = '0,2,3'"),
        ("stress_psf,closure_mm,cycle\n1,2,1\n", "unit 'psf' must be one of Pa, kPa, MPa, GPa"),
        ("stress,closure,cycle\n0,0,1\n", "or state the key stress_unit: one of"),
        (("0,0\n5,1\n", 1, ["1", "3"]), "or their numbers from 1 to 2"),
    ],
)
def test_an_error_of_a_curve_names_its_place_in_the_file(text, printed):
    text, *stated = (text,) if isinstance(text, str) else text
    with pytest.raises(InputError) as error:
        curve_of(text, **dict(zip(("cycle", "names"), stated, strict=False)))
    assert printed in str(error.value)


# Units: each heading of a stress of 1 MPa, or of a closure of 0.1 mm, and the number that it has


@pytest.mark.parametrize(
    ("heading", "number"),
    [
        ("Stress [N/mm²]", 1.0),
        ("stress_bar", 10.0),
        ("sigma / MPa", 1.0),
        ("Normal stress, kPa", 1000.0),
        ("Normal stress (psi)", 145.037738),
        ("stress (kN m^-2)", 1000.0),
        ("Stress (MPa) (corrected)", 1.0),
        ("CLOSURE (MM)", 0.1),
        ("Closure, microns", 100.0),
        ("closure [µm]", 100.0),
        ("d (in)", 0.1 / 25.4),
    ],
)
@pytest.mark.parametrize("named", ["by headings", "by numbers"])
def test_the_unit_in_a_heading_converts_the_column(heading, number, named):
    closes = heading_of(heading).unit in CLOSURE_UNITS
    head = f"stress_MPa;{heading}" if closes else f"{heading};closure_mm"
    row = f"1;{number}" if closes else f"{number};0.1"
    cells = head.split(";") if named == "by headings" else ["1", "2"]
    curve = curve_of(f"{head}\n{row}\n", cycle=1, names=cells, stress_unit="GPa")
    np.testing.assert_allclose([curve.stress[0], curve.closure[0]], [1e6, 1e-4])


@pytest.mark.parametrize("heading", ["Load (kN)", "Force (kN)", "Normal load (kN)", "load_kN"])
def test_a_heading_of_forces_is_recognised_without_names_of_columns(heading):
    text = f"lab of rocks\nTime (s),{heading},closure_mm\n7,2.5,0.1\n"
    with pytest.raises(InputError, match="is a unit of force; state the loaded area, --area"):
        curve_of(text, cycle=1)
    assert curve_of(text, cycle=1, area=2500e-6).stress[0] == pytest.approx(1e6)


def test_a_column_of_stresses_is_read_before_one_of_forces():
    curve = curve_of("load_kN,stress_MPa,closure_mm\n2.5,3,0.1\n", cycle=1)
    assert curve.stress[0] == pytest.approx(3e6)


@pytest.mark.parametrize("heading", ["Normal load (kN)", "load_kN", "F [MN]", "kN load", "F_kN_1"])
def test_a_force_becomes_a_stress_by_the_loaded_area_alone(heading):
    text, units = f"{heading};closure_mm\n2.5;0.1\n", {"cycle": 1, "names": ["1", "2"]}
    with pytest.raises(InputError, match="is a unit of force; state the loaded area, --area"):
        curve_of(text, stress_unit="MPa", **units)
    newtons = 2.5 * FORCE_UNITS[heading_of(heading).unit]
    curve = curve_of(text, area=2500e-6, **units)
    assert curve.stress[0] == pytest.approx(newtons / 2500e-6)
    with pytest.raises(InputError, match="MPa is a unit of stress; leave out the loaded area"):
        curve_of("stress_MPa;closure_mm\n1;0.1\n", area=2500e-6, **units)


@pytest.mark.parametrize(
    ("heading", "unit"),
    [
        ("Stress (kip/ft2)", "kip/ft2"),
        ("Load (kg)", "kg"),
        ("load_lbs", "lbs"),
        ("Stress (mPa)", "mPa"),
        ("Stress (x10 MPa)", "Stress (x10 MPa)"),
        ("Load (kN) stress (MPa)", "kN, MPa"),
        ("Displacement (mm)", "mm"),
    ],
)
def test_an_unknown_unit_in_a_heading_is_refused_whatever_unit_is_stated(heading, unit):
    text = f"{heading};closure_mm\n1;0.1\n"
    with pytest.raises(InputError, match=re.escape(f"unit {unit!r} must be one of Pa, kPa")):
        curve_of(text, cycle=1, names=["1", "2"], stress_unit="MPa")


@pytest.mark.parametrize(
    "heading", ["Closure (%)", "LVDT volts", "closure percent", "closure_1e-3mm", "d (MPa)"]
)
def test_a_column_that_is_no_length_is_refused_as_closure(heading):
    text = f"stress_MPa;{heading}\n1;0.1\n"
    with pytest.raises(InputError, match="must be one of m, cm, mm, um"):
        curve_of(text, cycle=1, names=["1", "2"], closure_unit="mm")


def test_units_that_contradict_each_other_are_refused():
    with pytest.raises(InputError, match="its unit is MPa and in the line below it kPa"):
        curve_of("stress_MPa,closure_mm\nkPa,mm\n1,0.1\n", cycle=1)
    for line in ("# Units: kN, mm", "Unit of load: kN", "stress in kPa"):
        with pytest.raises(InputError, match=r"line 1: .* states other units than"):
            curve_of(f"{line}\nstress_MPa,closure_mm\n1,0.1\n", cycle=1)
    with pytest.raises(InputError, match=r"line 1: .*load \[kN\].* states other units than"):
        curve_of("# load [kN], d [mm]\n1,0.1\n", **NUMBERED | {"stress_unit": "MPa"})
    capacity = "Load cell: 100 kN\n# load in kN, and\n"  # of other columns
    assert curve_of(f"{capacity}stress_MPa,closure_mm\n1,0.1\n", cycle=1).stress[0] == 1e6


# Files of testing machines: what stands above, between and below the rows


@pytest.mark.parametrize("columns", [None, ["2", "3"], ["Stress (MPa)", "Closure (mm)"]])
@pytest.mark.parametrize("below", ["", "s;MPa;mm\n"])
def test_lines_above_the_headings_are_no_part_of_the_table(columns, below):
    heading = "t;Stress;Closure\n" if below else "t (s);Stress (MPa);Closure (mm)\n"
    columns = ["Stress", "Closure"] if columns and below and columns[0] != "2" else columns
    above = "Laboratory of joints\nSpecimen: J12; dry\nDate;12.3.2024;14:30\n\n"
    curve = curve_of(above + heading + below + "0;1;0,1\n1;2;0,2\n", cycle=1, names=columns)
    np.testing.assert_allclose(curve.stress, [1e6, 2e6])
    np.testing.assert_allclose(curve.closure, [1e-4, 2e-4])


ROWS = "0,0\n1,0.1\n2,0.15\n"


@pytest.mark.parametrize(
    ("between", "printed"),
    [
        ("Specimen 2\n", "line 5: 'Specimen 2' stands among the rows"),
        ("stress_MPa,closure_mm\n", "line 5: 'stress_MPa,closure_mm' stands among the rows"),
        ("\n", "line 6: rows are divided by a line that is no row"),
        ("# specimen 2\n", "line 6: rows are divided by a line that is no row"),
    ],
)
def test_specimens_below_each_other_are_refused(between, printed):
    with pytest.raises(InputError, match=re.escape(printed)):
        curve_of(f"stress_MPa,closure_mm\n{ROWS}{between}{ROWS}", cycle=1)


def test_a_later_loading_that_closes_further_is_no_cycle_unless_a_column_says_so():
    loops = [(0, 0), (5, 0.1), (10, 0.12), (0, 0), (5, 0.2), (10, 0.3)]
    rows = [f"{stress},{closure}" for stress, closure in loops]
    with pytest.raises(InputError, match=r"line 5: .* closes by 0.3 mm and the first one by 0.12"):
        curve_of("\n".join(["stress_MPa,closure_mm", *rows]), cycle=1)
    numbered = [f"{row},{1 + number // 3}" for number, row in enumerate(rows)]
    assert curve_of(HEADER + "\n".join(numbered)).cycles == [1, 2]


def test_a_column_of_several_specimens_is_refused():
    rows = "A,0,0,1\nA,2,0.1,1\nB,0,0,2\nB,2,0.1,2\n"
    with pytest.raises(InputError, match="column 'specimen' has 2 values, A, B"):
        curve_of(f"specimen,{HEADER}{rows}")


def two_loops(cycles=None, scatter=0.0):
    """Two loops of one joint, the second at other closures, as text with or without cycles."""
    part = np.concatenate([np.linspace(0.0, 1.0, 200), np.linspace(1.0, 0.0, 200)])
    stress = np.tile(10.0 * part, 2) + scatter * np.random.default_rng(1).standard_normal(800)
    closure = np.concatenate([0.1 * part**0.4, 0.05 + 0.05 * part**0.4])
    columns = [stress, closure] if cycles is None else [stress, closure, cycles]
    rows = "".join(",".join(f"{x:.6f}" for x in row) + "\n" for row in zip(*columns, strict=True))
    return ("stress_MPa,closure_mm\n" if cycles is None else HEADER) + rows


@pytest.mark.parametrize("scatter", [0.0, 0.1])
def test_loadings_without_a_column_of_cycles_are_cycles(scatter):
    curve = curve_of(two_loops(scatter=scatter), cycle=1)
    assert curve.cycles == [1, 2]
    check_curve(curve, "lab.csv", 0.6e6)
    readings = readings_of_curve(curve, 0.6e6)
    sentence, *_ = reading_sentences(curve, readings, 0.02)
    assert sentence.startswith("without a column of cycles, the 2 loadings of the curve are its")
    rises = [0.1 * (1.0 - 0.06**0.4), 0.05 * (1.0 - 0.06**0.4)]
    read = [readings.values[readings.places().index((n, readings.levels[-1]))] for n in (1, 2)]
    np.testing.assert_allclose(1e3 * np.array(read), rises, rtol=0.05 if scatter else 0.01)


def settings(tmp_path, text, **about):
    path = tmp_path / "lab.csv"
    path.write_text(text)
    about = {"largest": 2e6} | about
    measured = MeasuredFile(file=str(path), **{n: about[n] for n in about if n != "largest"})
    return {"one": CurveSettings(measured, about["largest"], 2, 0.5e6)}


def by_study(tmp_path, text, **about):
    return measured_curves(settings(tmp_path, text, **about))


def by_fit(tmp_path, text, **about):
    path = tmp_path / "fit.csv"
    path.write_text(text)
    joint = {"rock": "granite", "jrc": 10.0, "shape": (16, 16), "seating_stress": 0.5e6}
    return asked_joints(path, joint, "fit", 6)


def by_curve(tmp_path, text, **about):
    joint = {"rock": "granite", "jrc": 10.0, "shape": (16, 16), "seating_stress": 0.5e6}
    return asked_joints(parsed_curve(text, "lab.csv", cycle=1), joint, "validate", 6)


@pytest.mark.parametrize("door", [by_study, by_fit, by_curve])
@pytest.mark.parametrize(
    ("text", "printed"),
    [
        (HEADER + "0,0,1\n1,-.1,1\n2,-.15,1\n", "closure of cycle 1 must increase with stress"),
        (GOOD + "0,0,2\n1,-.1,2\n2,-.11,2\n", "closure of cycle 2 must increase with stress"),
        (HEADER + "0,0,1\n2,.1,1\n0,.2,1\n", "closure of cycle 1 must decrease on unloading"),
        (HEADER + "0,0,1\n-1,.1,1\n-2,.15,1\n", "compression is positive, change the sign"),
        (GOOD.replace("_mm", "_m"), "must be at most 20 mm; is their unit right?"),
        (GOOD.replace("_mm", "_nm"), "must be at least 0.0002 mm; is their unit right?"),
        (GOOD.replace("_MPa", "_GPa"), "must be at most 1000 MPa; is their unit right?"),
        (GOOD + "0,.1,1\n1,.11,1\n2,.15,1\n", "line 6: cycle 1 is loaded again from 0 MPa"),
    ],
)
def test_every_door_refuses_a_curve_of_wrong_sign_size_or_loadings(tmp_path, door, text, printed):
    with pytest.raises(InputError, match=re.escape(printed)):
        door(tmp_path, text, largest=1e12)


def test_a_study_reads_forces_by_the_area_of_its_rock(tmp_path):
    text = "load_kN,closure_mm,cycle\n0,0,1\n2.5,0.1,1\n5,0.15,1\n"
    with pytest.raises(InputError, match="state the loaded area, the key area_mm2"):
        by_study(tmp_path, text.replace("load", "stress"))
    curve = by_study(tmp_path, text.replace("load", "stress"), area_mm2=2500.0)["one"]
    np.testing.assert_allclose(curve.stress, [0.0, 1e6, 2e6])


# Dense logs whose values scatter, of a hyperbola: kni = 10 MPa/mm, Vm = 0.1 mm


def hyperbola(stress):
    return 0.1 * stress / (1.0 + stress)


def noisy_log(seed, count=7364, scatter=(0.1, 1e-3), rate=1.0, digits=6):
    """A log of one loading and unloading to 10 MPa, with scatter of stress [MPa] and closure [mm].

    Half of the closure above zero stays on unloading.
    """
    rng, time = np.random.default_rng(seed), np.linspace(0.0, 1.0, count // 2) ** rate
    stress = 10.0 * np.append(time, time[::-1])
    back = 0.5 * hyperbola(10.0) * (1.0 + (stress[count // 2 :] / 10.0) ** 0.5)
    closure = np.append(hyperbola(stress[: count // 2]), back)
    stress += scatter[0] * rng.standard_normal(stress.size)
    closure += scatter[1] * rng.standard_normal(stress.size)
    line = np.arange(2, 2 + stress.size)
    return MeasuredCurve(1e6 * np.round(stress, digits), 1e-3 * closure, np.ones_like(line), line)


def readings_over_truth(curve):
    """Readings since 0.5 MPa over those of the hyperbola at the levels, and relative errors."""
    check_curve(curve, "log.csv", 0.5e6)
    readings = readings_of_curve(curve, 0.5e6)
    true = hyperbola(1e-6 * readings.levels) - hyperbola(0.5)
    recovered = 0.5 * hyperbola(10.0) * (1.0 - 0.05**0.5)
    over = 1e3 * readings.values / np.append(true, recovered)
    return over, np.zeros(4) if readings.errors is None else readings.errors / readings.values


@pytest.mark.parametrize(
    "log",
    [{}, {"rate": 3.0}, {"count": 1600}, {"scatter": (0.02, 5e-4), "digits": 1}],
    ids=["even", "slow at first", "fewer points", "stresses in steps"],
)
def test_a_dense_log_that_scatters_is_read_without_bias(log):
    over = np.array([readings_over_truth(noisy_log(seed, **log))[0] for seed in range(12)])
    error = over.std(axis=0, ddof=1) / np.sqrt(12)
    assert (np.abs(over.mean(axis=0) - 1.0) < 0.005 + 3.0 * error).all()


def test_the_stated_error_of_a_reading_is_its_scatter_between_logs():
    pairs = [readings_over_truth(noisy_log(seed)) for seed in range(24)]
    over, stated = map(np.array, zip(*pairs, strict=True))
    ratio = np.sqrt((stated**2).mean(axis=0)) / over.std(axis=0, ddof=1)
    assert ((ratio > 0.7) & (ratio < 1.6)).all()


def test_points_without_scatter_are_read_as_they_are():
    curve = noisy_log(1, scatter=(0.0, 0.0))
    assert sum(stress.size for stress, _ in curve.branches(1).values()) == 7364
    over, errors = readings_over_truth(curve)
    np.testing.assert_allclose(over, 1.0, rtol=1e-4)
    assert not errors.any()


def test_a_log_that_ends_with_a_hold_at_its_largest_stress_is_a_loading_without_an_unloading():
    rising = np.append(np.linspace(0.0, 1.0, 300), np.ones(60))
    scatter = 1e-6 * np.random.default_rng(1).standard_normal(360)
    line = np.arange(2, 362)
    closure = 1e-4 * np.sqrt(rising) + scatter
    curve = MeasuredCurve(10e6 * rising, closure, np.ones_like(line), line)
    check_curve(curve, "log.csv", 0.5e6)
    readings = readings_of_curve(curve, 0.5e6)
    assert readings.unloaded == ()
    assert np.isfinite(readings.values).all()


def test_scatter_above_the_stated_closure_error_is_warned_of():
    curve = noisy_log(1)
    readings = readings_of_curve(curve, 0.5e6)
    (plain,) = reading_sentences(curve, readings, 0.05)
    assert "from means of the 7364 measured points" in plain
    worst = (readings.errors / readings.values).max()
    *_, warning = reading_sentences(curve, readings, 0.9 * worst)
    assert cautions([warning])
    assert "more than the stated closure_error" in warning
    plain = noisy_log(1, scatter=(0.0, 0.0))
    assert reading_sentences(plain, readings_of_curve(plain, 0.5e6), 0.02) == []


def test_points_that_are_passed_over_are_counted_in_a_warning():
    rows = "0,0,1\n1,.05,1\n.9,.06,1\n2,.08,1\n2,.09,1\n5,.1,1\n"
    curve = curve_of(HEADER + rows)
    (warning,) = reading_sentences(curve, readings_of_curve(curve, 0.5e6), 0.02)
    assert cautions([warning])
    assert "2 of 6 measured points do not exceed all stresses before them" in warning


def test_a_column_of_cycles_counts_where_only_others_are_named():
    rows = "0,0,1\n2,.1,1\n0,0,2\n2,.09,2\n"
    assert curve_of(HEADER + rows, cycle=1, names=["1", "2"]).cycles == [1, 2]


def test_a_heading_that_stands_twice_is_refused_by_name():
    head = "stress_MPa,closure_mm,stress_MPa,closure_mm\n1,.1,1,.2\n"
    names = ["stress_MPa", "closure_mm"]
    with pytest.raises(InputError, match="column 'stress_MPa' stands there 2 times"):
        curve_of(head, cycle=1, names=names)
    assert curve_of(head, cycle=1, names=["3", "4"]).closure[0] == pytest.approx(2e-4)


def test_a_curve_given_as_numbers_is_checked_as_one_of_a_file():
    joint = {"rock": "granite", "jrc": 10.0, "shape": (16, 16)}
    bad = MeasuredCurve([0.0, 1e6], [0.0, np.nan], [1, 1], [1, 2])
    with pytest.raises(InputError, match="curve: closure has values that are not finite"):
        asked_joints(bad, joint, "fit", 6)
    with pytest.raises(InputError, match="curve: stress, closure, cycle and line have shapes"):
        asked_joints(bad._replace(closure=[0.0]), joint, "fit", 6)


def test_closures_since_seating_of_a_study_are_those_of_the_regression():
    _, (branch, stress, closure), *_ = ((), *noisy_log(3).since_seating(1, 0.5e6))
    assert branch == "loading"
    np.testing.assert_allclose(1e3 * closure, hyperbola(1e-6 * stress) - hyperbola(0.5), atol=2e-3)


def test_scatter_above_the_maximum_of_a_study_is_no_larger_stress(tmp_path):
    curve = noisy_log(1)
    rows = zip(1e-6 * curve.stress, 1e3 * curve.closure, strict=True)
    text = HEADER + "".join(f"{x},{y},1\n" for x, y in rows)
    assert curve.stress.max() > 10.2e6
    by_study(tmp_path, text, largest=10.1e6)
    with pytest.raises(InputError, match=r"must be at most rocks.one.max_normal_stress"):
        by_study(tmp_path, text, largest=9.8e6)


def test_a_spike_in_a_dense_log_is_refused():
    curve = noisy_log(1)
    curve.closure[1000] += 1e-3
    with pytest.raises(InputError, match=r"line 1002: closure = .* lies far from the points"):
        check_curve(curve, "log.csv", 0.5e6)


def test_stresses_below_zero_are_scatter_or_refused():
    curve = noisy_log(1)
    assert curve.stress.min() < 0.0
    check_curve(curve, "log.csv", 0.5e6)
    with pytest.raises(InputError, match="must be 0 or above"):
        check_curve(curve._replace(stress=curve.stress - 1e6), "log.csv", 0.5e6)


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
        (HEADER + "0,0,1\n0.4,1,1\n", "0.4 MPa: is the unit of the stress right?"),
    ],
)
def test_a_curve_that_the_study_cannot_be_held_against_is_refused(tmp_path, text, printed):
    with pytest.raises(InputError) as error:
        measured_curves(settings(tmp_path, text))
    assert printed in str(error.value)
    assert "lab.csv" in str(error.value)


def test_closures_count_from_where_the_loading_reaches_seating():
    curve = curve_of(HEADER + "0,0.1,1\n0.4,0.2,1\n0.6,0.4,1\n2,0.6,1\n0.3,0.5,1\n0,0.45,1\n")
    (_, up, closed), (_, down, left) = curve.since_seating(1, 0.5e6)
    assert (up.tolist(), down.tolist()) == ([0.6e6, 2e6], [0.3e6, 0.0])
    np.testing.assert_allclose(closed, [0.1e-3, 0.3e-3])
    np.testing.assert_allclose(left, [0.2e-3, 0.15e-3])


def checked_curve(stress, closure):
    """Check a curve of two points: the first of a stress [MPa], the second of a closure [mm]."""
    check_curve(curve_of(HEADER + f"{stress},0,1\n2,{closure},1\n"), "lab.csv", 0.5e6)


def test_curves_start_at_or_below_seating():
    checked_curve(0.5, 19.9)
    with pytest.raises(InputError, match="must start at or below"):
        checked_curve(0.51, 19.9)


def test_curves_close_by_at_most_two_centimetres():
    with pytest.raises(InputError, match=r"closures range over 20.1 mm: must be at most 20 mm"):
        checked_curve(0.5, 20.1)
