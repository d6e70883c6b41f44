"""Bands over the joints of a case."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.storage.netcdf import write_netcdf
from studies import __main__ as cli
from studies.frame.tables import band_table
from tests.joints import DOLERITE, SPACING


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
    table = band_table(ensemble)
    good = ensemble.isel(realization=[0, 1, 2, 4])
    row = table[(table.cycle == 1) & (table.branch == "loading") & (table.stress_MPa == 1.0)]
    closure = 1e3 * good.closure.sel(cycle=1, branch="loading", stress=1e6).values
    assert row.samples.item() == 4
    bulk = 1e3 * good.bulk_indentation.sel(cycle=1, branch="loading", stress=1e6).values
    next_one = good.sel(cycle=1, branch="loading", stress=1.2e6)
    landing = good.landing_stress.sel(cycle=1).values
    next_closure, next_bulk = (1e3 * next_one[name] for name in ("closure", "bulk_indentation"))
    for kind, values, after in (
        ("gross", closure, next_closure), ("net", closure - bulk, next_closure - next_bulk)
    ):  # fmt: skip
        assert row[f"closure_{kind}_mm_mean"].item() == pytest.approx(values.mean())
        assert row[f"closure_{kind}_mm_q50"].item() == pytest.approx(np.median(values))
        low = row[f"normal_stiffness_{kind}_MPa_per_mm_q05"].item()
        chords = np.where(landing >= 1.2e6, 0.2 / (after - values), np.nan)
        assert low == pytest.approx(np.nanquantile(chords, 0.05), rel=1e-6)
    aperture = 1e3 * good.mean_aperture.sel(cycle=1, branch="loading", stress=1e6).values
    assert row.mean_aperture_mm_mean.item() == pytest.approx(aperture.mean())
    assert "hydraulic_aperture_x_mm_q95" in table


def test_stiffness_of_the_landing_is_left_out(ensemble):
    """Of the joints that land below a chord's end; that is on first loadings only."""
    name = "normal_stiffness_net_MPa_per_mm_mean"
    whole = band_table(ensemble.assign(landing_stress=ensemble.landing_stress * np.inf))
    without = band_table(ensemble)
    landing = ensemble.isel(realization=[0, 1, 2, 4]).sel(cycle=1).landing_stress.values
    first = (whole.cycle == 1) & (whole.branch == "loading")
    ends = 1e6 * whole[first].stress_MPa.shift(-1).values
    kept = (ends[:, None] <= landing).any(axis=1)
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
    expected = band_table(ensemble)
    assert [path.name for path in (tmp_path / "engineering").iterdir()] == ["a-base.csv"]
    np.testing.assert_allclose(written.closure_net_mm_q95, expected.closure_net_mm_q95, rtol=1e-6)
    name = "normal_stiffness_net_MPa_per_mm_mean"
    np.testing.assert_allclose(written[name], expected[name], rtol=1e-6)
    capsys.readouterr()
    assert cli.main(["engineering", str(tmp_path), "--case", "b-base"]) != 0
    assert "--case b-base: must be one of a-base, a-jrc-low" in capsys.readouterr().err
