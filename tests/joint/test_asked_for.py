"""Flow where users ask for it: studies, commands, engineers' tables, figures."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.cli.exports import geos_aperture_table
from jointclosure.engine.aggregation import CURVES, join_cases
from jointclosure.engine.joints import close_case
from jointclosure.engine.quantities import OF_FLOW
from jointclosure.engine.walls import walls_of
from jointclosure.joint.curves import curve_table, cycle_table
from jointclosure.joint.history import crossing
from jointclosure.plotting.joint import engineering_figure
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.ensemble.cases import block_settings, cases_of
from studies.frame.ensemble.tables import check_results, flow_table
from tests.joints import DOLERITE, SPACING
from tests.studied import study_of

TINY = {
    "study": {"rocks": ["slate"], "realizations": 3},
    "rocks": {"slate": {"max_normal_stress_MPa": 2, "levels": {"jrc": None}}},
    "grid": {"cells_x": 14, "cells_y": 12},
    "output": {"stress_points": 5},
}


def tiny_study(flow: bool) -> xr.Dataset:
    """A study of the first two cases, put together."""
    configuration = study_of(TINY, {"flow": flow})
    cases = {case.label: case for case in cases_of(configuration)}
    first = list(cases)[:2]
    closed = []
    for label in first:
        settings = block_settings(configuration, cases, label, range(3))
        closed.append(close_case(settings))
    study = join_cases([cases[label] for label in first], closed)
    return study.assign_coords(scene=("case", ["all"] * 2))


@pytest.fixture(scope="module")
def studies():
    return {flow: tiny_study(flow) for flow in (False, True)}


def test_a_study_has_its_apertures_over_stress_with_units_and_all_else_unchanged(studies):
    without, study = studies[False], studies[True]
    added = set(study.data_vars) - set(without.data_vars)
    assert added == set(OF_FLOW)
    assert study.hydraulic_aperture.dims == (
        "case", "realization", "direction", "cycle", "branch", "stress",
    )  # fmt: skip
    for name in added:
        assert study[name].attrs["units"]
        assert study[name].attrs["long_name"]
    same = study.drop_vars([*added, "direction", "timing_simulation"])
    xr.testing.assert_identical(same, without.drop_vars("timing_simulation"))
    assert set(OF_FLOW) - set(CURVES) == {"largest_flow_imbalance"}


def test_a_study_reads_its_apertures_off_the_joints_history(studies):
    settings = block_settings(
        study_of(TINY), {c.label: c for c in cases_of(study_of(TINY))}, "slate-base", range(3)
    )
    walls = next(iter(walls_of(settings.surfaces)))
    closed = jc.simulate(*walls, **settings.conditions()._asdict() | {"flow": True})
    here = (closed.cycle == 1).values & (closed.branch == "loading").values
    stress, level = closed.normal_stress.values[here], 1e6
    for direction in ("x", "y"):
        along = closed.hydraulic_aperture.sel(direction=direction).values[here]
        stored = studies[True].hydraulic_aperture.sel(
            case="slate-base", realization=0, direction=direction, cycle=1, branch="loading"
        )
        at = int(np.flatnonzero(np.isclose(stored.stress, level))[0])
        assert float(stored[at]) == crossing(stress, along, level)


def test_the_table_has_means_over_those_that_succeeded_and_reach_the_stress(studies):
    study = studies[True].copy(deep=True)
    study["status"][0, 1] = 16
    study["hydraulic_aperture"][0, 2, 0, 0, 0, 3] = np.nan
    table = flow_table(study).set_index(
        ["case", "cycle", "branch", "direction", "stress_MPa"]
    )  # fmt: skip
    both = study.sel(case="slate-base", cycle=1, branch="loading", direction="x")
    own = table.loc["slate-base", 1, "loading", "x"]
    assert list(own.samples)[:4] == [2, 2, 2, 1]
    at = both.isel(stress=2, realization=[0, 2])
    assert own.hydraulic_aperture_mean_mm.iloc[2] == pytest.approx(
        1e3 * float(at.hydraulic_aperture.mean())
    )
    ratio = (at.hydraulic_aperture / at.mean_aperture).values
    assert own.ratio_mean.iloc[2] == pytest.approx(ratio.mean())
    assert own.ratio_standard_deviation.iloc[2] == pytest.approx(ratio.std(ddof=1))
    assert np.isnan(own.ratio_standard_deviation.iloc[3])


def test_a_blocked_joint_counts_with_nothing(studies):
    study = studies[True].copy(deep=True)
    study["hydraulic_aperture"][:, 0, 1] = 0.0
    table = flow_table(study)
    assert set(table[table.direction == "y"].blocked) == {1}
    assert set(table[table.direction == "x"].blocked) == {0}


def test_the_checks_of_a_study_hold_the_mass_balance(studies):
    numerics = study_of(TINY).numerics
    for balanced, worst in ((True, 1e-12), (False, 1e-3)):
        study = studies[True].copy(deep=True)
        study["largest_flow_imbalance"][0, 0] = worst
        checks = check_results(study, numerics, 3).set_index("check")
        row = checks.loc["largest sum of the cells' mass balances in a flow, relative"]
        assert row.passed == balanced
    assert not any("flow" in check for check in check_results(studies[False], numerics, 3).check)


@pytest.fixture(scope="module")
def closed():
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=3)
    load = {"max_normal_stress": 5e6, "seating_stress": 0.5e6}
    return jc.simulate(*walls, spacing=SPACING, rock=DOLERITE, flow=True, **load)


def test_engineers_tables_have_hydraulic_apertures_only_where_asked_for(closed):
    without = closed.drop_vars(["hydraulic_aperture", "flow_status", "flow_imbalance", "direction"])
    columns = {
        "hydraulic_aperture_x_mm", "hydraulic_aperture_y_mm",
        "hydraulic_ratio_x", "hydraulic_ratio_y",
    }  # fmt: skip
    curves = curve_table(closed)
    assert set(curves) - set(curve_table(without)) == columns
    pd.testing.assert_frame_equal(curves.drop(columns=list(columns)), curve_table(without))
    last = curves.iloc[-1]
    assert last.hydraulic_aperture_y_mm == 1e3 * float(closed.hydraulic_aperture[-1, 1])
    assert last.hydraulic_ratio_y == pytest.approx(
        float(closed.hydraulic_aperture[-1, 1] / closed.mean_aperture[-1])
    )
    at_max = curves[(curves.cycle == 2) & (curves.branch == "loading")].iloc[-1]
    cycles = cycle_table(closed)
    assert cycles.hydraulic_aperture_x_at_max_mm.iloc[1] == at_max.hydraulic_aperture_x_mm
    assert "hydraulic_aperture_x_at_max_mm" not in cycle_table(without)
    assert len(engineering_figure(closed, "")._suptitle.figure.axes) == 4
    assert len(engineering_figure(without, "").axes) == 3


def test_geos_is_given_the_hydraulic_aperture_where_there_is_one(closed):
    gap, aperture = geos_aperture_table(closed)
    here = (closed.cycle == 2).values & (closed.branch == "loading").values
    x, y = closed.hydraulic_aperture.values[here].T
    assert aperture[0] == pytest.approx(np.sqrt(x[-1] * y[-1]), rel=1e-9)
    plain = closed.drop_vars(["hydraulic_aperture", "direction"])
    assert geos_aperture_table(plain)[1][0] == pytest.approx(
        float(closed.mean_aperture.values[here][-1]), rel=1e-9
    )
    assert set(np.delete(geos_aperture_table(plain)[0], -2)) <= set(gap)  # but for its end slope


def test_the_command_says_and_writes_hydraulic_apertures(tmp_path, capsys):
    words = ["simulate", "--rock", "slate", "--cells", "14x12", "--stress", "2", "--flow"]
    folder = tmp_path / "tables"
    file = tmp_path / "joint.nc"
    assert cli.main([*words, "--output", str(file), "--tables", str(folder)]) == 0
    out = capsys.readouterr().out
    stored = read_netcdf(file)
    largest = stored.hydraulic_aperture.values[stored.normal_stress.values.argmax()]
    assert re.search(rf"cycle \d +\S+ +{1e3 * largest[0]:.5f} +{1e3 * largest[1]:.5f}", out)
    tables = (folder / "joint_stiffness.dat").read_text()
    found = dict(re.findall(r"^table '(aperture-[\w-]+)' add (.*)$", tables, re.M))
    assert len(found) == 4
    pairs = np.array(re.findall(r"\(([^,]+),([^)]+)\)", found["aperture-cycle-1-loading"]), float)
    geometric = np.sqrt(stored.hydraulic_aperture.prod("direction").values)
    np.testing.assert_allclose(pairs[:, 1], geometric[: len(pairs)], rtol=1e-6)
    assert (np.diff(pairs[:, 0]) >= 0.0).all()
    assert cli.main(words[:-1]) == 0
    assert "hydraulic" not in capsys.readouterr().out
