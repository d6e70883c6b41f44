"""Measured curves: what can be read, what is refused, and which realisation fits best."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve, best_fits, fit_table, parsed_curve
from studies.frame.config.rocks import MeasuredFile
from studies.frame.measured_files import CurveSettings, curve_settings, measured_curves
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


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("cycle, closure_um ,stress_GPa\n1,100,0.001\n", {}),
        ("stress,closure,cycle\n1,0.1,1\n", {"stress_unit": "MPa", "closure_unit": "mm"}),
        ("\ufeffstress_Pa,closure_m,cycle\n1e6,1e-4,1\n", {"stress_unit": "GPa"}),
        ('stress_MPa,closure_mm,cycle\n"1","0.1","1.0"\n', {}),
        ("stress_MPa  closure_mm cycle\n1 0,1  1\n", {}),
        ("stress_MPa;closure_mm;cycle\n1,0;0,1;1\n", {}),
        ("Stress (MPa); t (s); Closure [mm]; cycle\n1;7;0.1;1\n", {}),
        ("stress\tclosure\tcycle\tx\nMPa\tmm\t-\ts\n1\t0.1\t1\tfree text\n", {}),
        ("t,sigma_n,d,No\ns,MPa,mm,\n0,1,0.1,1\n", {"names": ["sigma_n", "d", "No"]}),
    ],
    ids=[
        "other order and units",
        "configured units",
        "mark of Excel",
        "quotes",
        "blanks",
        "decimal commas",
        "brackets",
        "line of units",
        "named columns",
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
        (HEADER + "0,0,1\n-1,0.1,1\n", "lab.csv, line 3: stress = -1: must be 0 or above"),
        (HEADER + "1,0.1,1.5\n", "lab.csv, line 2: cycle = 1.5: must be a whole number"),
        (HEADER + "1,0,1,1\n", "line 2: '1,0,1,1' has 4 values, the header has 3"),
        ("stress_MPa,closure_mm\n1,2\n", "line 1: lacks cycle"),
        ("stress_MPa,depth_mm,cycle\n1,2,1\n", "lacks closure (columns are stress_MPa,closure_mm"),
        ("stress_MPa\n1\n", "separated by commas, semicolons, tabs or blanks"),
        ("stress_MPa,closure_mm,cycle\n1,0,2,1\n", "decimals are written with points"),
        ("stress_MPa;closure_mm;cycle\n1;0,2,3;1\n", "closure = '0,2,3'"),
        ("stress_psi,closure_mm,cycle\n1,2,1\n", "unit 'psi' must be one of Pa, kPa, MPa, GPa"),
    ],
)
def test_what_is_wrong_is_said_with_file_line_and_value(text, printed):
    with pytest.raises(InputError) as error:
        curve_of(text)
    assert printed in str(error.value)


def settings(tmp_path, text):
    path = tmp_path / "lab.csv"
    path.write_text(text)
    return {"one": CurveSettings(MeasuredFile(file=str(path)), 2e6, 2, 0.5e6)}


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def test_only_rocks_with_a_file_have_a_curve(tmp_path):
    assert list(measured_curves(settings(tmp_path, GOOD), read)) == ["one"]
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
        measured_curves(settings(tmp_path, text), read)
    assert printed in str(error.value)
    assert "lab.csv" in str(error.value)


SEATING = 0.5e6


def study(status=(0, 0, 0)):
    """Three surfaces whose closures are 1, 2 and 3 times one curve, later cycles a tenth of it."""
    stress = np.linspace(0.0, 2e6, 9)
    loading = 1e-4 * np.sqrt(stress / 2e6)
    unloading = 1e-4 * (0.8 + 0.2 * stress / 2e6)
    scale = np.array([1.0, 2.0, 3.0])[:, None, None, None] * np.array([1.0, 0.1])[:, None, None]
    closure = scale * np.stack([loading, unloading])
    end = closure[..., 1, 0]
    start = np.concatenate([np.zeros((3, 1)), end[:, :-1]], axis=1)
    closure = closure + start[..., None, None]
    maximum = closure[..., 0, -1] - start
    seat = scale[..., 0, 0] * 1e-4 * 0.5
    bulk = np.broadcast_to(3e-5 * stress / 2e6, closure.shape)
    dimensions = ("case", "realization", "cycle")
    return xr.Dataset(
        {
            "closure": ((*dimensions, "branch", "stress"), (closure + bulk)[None]),
            "bulk_indentation": ((*dimensions, "branch", "stress"), bulk[None]),
            "status": (dimensions[:2], np.array([status], dtype=np.int16)),
            "max_closure_net": (dimensions, maximum[None]),
            "max_closure_seated_net": (dimensions, (maximum - seat)[None]),
            "residual_closure": (dimensions, (end + start)[None]),
        },
        coords={
            "case": ["one-base"], "rock": ("case", ["one"]), "parameter": ("case", ["base"]),
            "realization": [10, 11, 12], "cycle": [1, 2], "branch": ["loading", "unloading"],
            "stress": stress,
        },
    )  # fmt: skip


def like(number, cycle=1, offset=0.0):
    """A measured curve that is a modelled one, from another zero."""
    base = study().isel(case=0).sel(cycle=cycle).isel(realization=number)
    net = base.closure - base.bulk_indentation
    up, down = (net.sel(branch=name).values for name in ("loading", "unloading"))
    stress = base.stress.values
    rows = [(stress, up), (stress[::-1][1:], down[::-1][1:])]
    return MeasuredCurve(
        np.concatenate([s for s, _ in rows]),
        np.concatenate([c for _, c in rows]) + offset,
        np.full(2 * stress.size - 1, cycle),
        np.arange(2 * stress.size - 1),
    )


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("cycle", [1, 2])
@pytest.mark.parametrize("offset", [0.0, 3e-4])
def test_the_surface_that_was_measured_fits_best_and_without_misfit(number, cycle, offset):
    table = fit_table(study(), {"one": like(number, cycle, offset)}, SEATING)
    (row,) = table.itertuples()
    assert row.best_realization == 10 + number
    assert row.misfit_mm < 1e-12
    assert row.median_misfit_mm > 1e-3
    assert row.samples == 3
    # 6 above the seating on loading, and 8 on unloading
    assert row.points == 14


def test_the_misfit_is_the_root_mean_square_of_the_differences_of_closures():
    curve = like(0)
    doubled = curve._replace(closure=1.3 * curve.closure)
    table = fit_table(study(), {"one": doubled}, SEATING)
    differences = np.concatenate(
        [0.3 * closure for _, _, closure in curve.since_seating(1, SEATING)]
    )
    expected = 1e3 * np.sqrt(np.mean(differences**2))
    assert table.misfit_mm[0] == pytest.approx(expected)
    largest = 1e3 * 1.3 * (1e-4 - 0.5e-4)
    assert table.misfit_percent[0] == pytest.approx(100 * expected / largest)


def test_each_cycle_has_its_own_best_and_all_together_one():
    one, two = like(0, 1), like(2, 2)
    both = MeasuredCurve(*(np.concatenate(pair) for pair in zip(one, two, strict=True)))
    table = fit_table(study(), {"one": both}, SEATING)
    assert table.cycle.tolist() == ["1", "2", "all"]
    # the first cycle's differences are ten times those of the second
    assert table.best_realization.tolist() == [10, 12, 10]
    assert [fit[:2] for fit in best_fits(table, "one")] == [(1, 10), (2, 12)]


def test_a_failed_surface_is_never_the_best():
    table = fit_table(study(status=(16, 0, 0)), {"one": like(0)}, SEATING)
    assert table.best_realization[0] == 11
    assert table.samples[0] == 2


def test_a_surface_that_does_not_reach_a_measured_stress_is_left_out():
    found = study()
    found.closure[0, 0, 0, :, -1] = np.nan
    table = fit_table(found, {"one": like(0)}, SEATING)
    assert (table.best_realization[0], table.samples[0]) == (11, 2)
    found.closure[0, :, 0, :, -1] = np.nan
    table = fit_table(found, {"one": like(0)}, SEATING)
    assert table.samples[0] == 0
    assert list(best_fits(table, "one")) == []
