"""Bands over the joints of a case."""

import itertools

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.result_tables import stress_table
from jointclosure.storage.netcdf import write_netcdf
from studies import __main__ as cli
from studies.commands.engineering import curves_with_quantiles
from studies.frame.joint_tables import changes_of_cases
from studies.frame.panels import PanelColumn, Row, panels
from tests.joints import DOLERITE, ELASTIC, SPACING


@pytest.fixture(scope="module")
def ensemble():
    pairs = [jc.wall_pair(8.0, (12, 12), SPACING, seed, roll_off=None) for seed in range(5)]
    pairs[3] = (pairs[3][0], np.full((12, 12), np.nan))  # fails
    with pytest.warns(UserWarning, match=r"1 of 5 joints .* seeds \[3\]"):
        return jc.simulate_ensemble(
            pairs, spacing=SPACING, rock=DOLERITE, max_normal_stress=2e6, seating_stress=0.2e6,
            stress_points=11, flow=True, workers=1,
        )  # fmt: skip


def test_statistics_are_those_of_the_joints_that_succeeded(ensemble):
    table = curves_with_quantiles(ensemble)
    row = table.query("cycle == 1 and branch == 'loading' and stress_MPa == 1.0")
    assert row.samples.item() == 4
    at = {"cycle": 1, "branch": "loading", "stress": 1e6}
    good = ensemble.isel(realization=[0, 1, 2, 4]).sel(at)
    net = good.closure - good.bulk_indentation
    aperture = good.mean_aperture
    expected = {"closure_gross": good.closure, "closure_net": net, "mean_aperture": aperture}
    for name, values in expected.items():
        assert row[f"{name}_mm_mean"].item() == pytest.approx(1e3 * values.values.mean())
        assert row[f"{name}_mm_q50"].item() == pytest.approx(1e3 * np.median(values.values))
    assert "hydraulic_aperture_x_mm_q95" in table


@pytest.fixture(scope="module")
def stiffnesses():
    """The band of the stiffness of two joints, that of either alone, and where it is compared.

    Single joints are read at more stresses than an ensemble stores.
    """
    rock = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 2e6, "effects": ELASTIC}
    walls = [jc.wall_pair(8.0, (16, 16), SPACING, seed, roll_off=None) for seed in range(2)]
    finely = {"numerics": jc.Numerics(curve_points=60)}
    joints = jc.simulate_ensemble(walls, stress_points=31, workers=1, **rock, **finely)
    table = curves_with_quantiles(joints)
    name = "normal_stiffness_net_MPa_per_mm"
    single = [jc.simulate(*pair, **rock, **finely) for pair in walls]
    either = [stress_table(joint, joints.stress.values)[name].to_numpy() for joint in single]
    inside = table.stress_MPa.between(0.5, 1.2).to_numpy()
    return {part: table[f"{name}_{part}"] for part in ("mean", "q50")}, either, inside


def test_the_mean_stiffness_is_that_of_the_mean_curve(stiffnesses):
    band, (one, other), inside = stiffnesses
    expected = 2.0 / (1.0 / one + 1.0 / other)
    np.testing.assert_allclose(band["mean"][inside], expected[inside], rtol=0.02)


def test_the_median_stiffness_is_that_of_single_joints(stiffnesses):
    band, (one, other), inside = stiffnesses
    np.testing.assert_allclose(band["q50"][inside], 0.5 * (one + other)[inside], rtol=0.02)


def test_stiffness_of_the_landing_is_left_out(ensemble):
    """Beyond the last joint's; that is on first loadings only."""
    name = "normal_stiffness_net_MPa_per_mm_mean"
    whole = curves_with_quantiles(ensemble.assign(landing_stress=ensemble.landing_stress * np.inf))
    without = curves_with_quantiles(ensemble)
    landing = ensemble.isel(realization=[0, 1, 2, 4]).sel(cycle=1).landing_stress.max().item()
    first = (whole.cycle == 1) & (whole.branch == "loading")
    kept = 1e6 * whole[first].stress_MPa <= landing
    assert 0 < kept.sum() < whole[first][name].notna().sum()
    np.testing.assert_array_equal(without[first][name].notna(), kept)
    pd.testing.assert_frame_equal(whole[~first], without[~first])


def test_the_command_writes_a_table_for_each_rock_as_it_is(ensemble, tmp_path, capsys):
    names = ["a-base", "a-jrc-low"]
    study = ensemble.drop_vars("error").expand_dims(case=names)
    study = study.assign_coords(parameter=("case", ["base", "jrc"]))
    write_netcdf(study, tmp_path / "study.nc")
    assert cli.main(["engineering", str(tmp_path)]) == 0
    written = pd.read_csv(tmp_path / "engineering/a-base.csv")
    expected = curves_with_quantiles(ensemble)
    assert [path.name for path in (tmp_path / "engineering").iterdir()] == ["a-base.csv"]
    for name in ("closure_net_mm_q95", "normal_stiffness_net_MPa_per_mm_mean"):
        np.testing.assert_allclose(written[name], expected[name], rtol=1e-6)
    capsys.readouterr()
    assert cli.main(["engineering", str(tmp_path), "--case", "b-base"]) != 0
    assert "--case b-base: must be one of a-base, a-jrc-low" in capsys.readouterr().err


# Panels of tables: lines, bars, ends of axes, names and levels


NAMES = {"wavelength_mm": {0.0: "mated", 1.0: "waves beyond 1 mm mate", np.inf: "independent"}}


def test_lines_have_the_values_of_their_rows_in_order_of_the_coordinate():
    """Values say where they belong: a hundred wavelengths and ten shifts and the cycle."""
    rows = itertools.product([np.inf, 0.0, 1.0, 2.0], [0, 1], [1, 2])
    made = pd.DataFrame(rows, columns=["wavelength_mm", "shift_mm", "cycle"])
    made = made[np.isfinite(made.wavelength_mm) | (made.shift_mm == 0)]
    value = 100.0 * made.wavelength_mm.clip(upper=9.0) + 10.0 * made.shift_mm + made.cycle
    free = {"wavelength_mm": np.inf}
    columns = [
        PanelColumn("wavelength_mm", "cycle", {"shift_mm": 0}, "log"),
        PanelColumn("shift_mm", "wavelength_mm", {"cycle": 1}, "symlog", level=free),
    ]
    row = Row("closure (mm)", made.assign(value=value, error=0.5), "value", "error")
    figure = panels([row], columns, NAMES, bars=2.0)
    over_wavelength, over_shift = figure.axes
    lines = [container[0] for container in over_wavelength.containers]
    assert [line.get_ydata().tolist() for line in lines] == [[1, 101, 201, 901], [2, 102, 202, 902]]
    shifted = [container[0].get_ydata().tolist() for container in over_shift.containers]
    assert shifted == [[1, 11], [101, 111], [201, 211]]
    (bars,) = over_shift.containers[1][2]
    assert np.ptp(bars.get_segments()[0][:, 1]) == 2.0


def test_what_a_case_changes_is_named_with_its_value_and_unit():
    study = xr.Dataset(
        coords={
            "case": ["slate-base", "slate-e", "slate-jrc"],
            "parameter": ("case", ["base", "youngs_modulus", "jrc"]),
            "value": ("case", [np.nan, 22.5e9, 6.0]),
        }
    )
    assert changes_of_cases(study) == {
        "slate-base": "",
        "slate-e": "Young's modulus 22.5 GPa",
        "slate-jrc": "JRC 6",
    }
