"""Flow in the results of a study: its curves, its table and its checks."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.curves import crossing
from studies.frame.closing import Ensemble, close_block
from studies.frame.settings import walls_of
from studies.frame.tables import join_cases
from studies.paper.checks import check_results, flow_table
from tests.studied import study_of

TINY = {
    "study": {"rocks": ["slate"], "realizations": 3},
    "rocks": {"slate": {"max_normal_stress_MPa": 2, "levels": {"jrc": None}}},
    "grid": {"cells_x": 14, "cells_y": 12},
    "output": {"stress_points": 5},
}


def tiny_study(flow: bool) -> xr.Dataset:
    """A study of the first two cases, put together."""
    ensemble = Ensemble(study_of(TINY, {"flow": flow}))
    first = list(ensemble.cases.values())[:2]
    closed = [close_block(ensemble.settings(case.label, range(3))) for case in first]
    return join_cases(first, closed).assign_coords(scene=("case", ["all"] * 2))


@pytest.fixture(scope="module")
def studies():
    return {flow: tiny_study(flow) for flow in (False, True)}


@pytest.mark.parametrize("direction", ["x", "y"])
def test_a_study_reads_its_apertures_off_the_joints_history(studies, direction):
    settings = Ensemble(study_of(TINY)).settings("slate-base", range(1))
    walls = next(iter(walls_of(settings)))
    closed = jc.simulate(*walls, **settings.conditions._asdict() | {"flow": True})
    here = (closed.load_cycle == 1).values & (closed.branch == "loading").values
    along = closed.hydraulic_aperture.sel(direction=direction).values[here]
    at = {"case": "slate-base", "realization": 0, "direction": direction, "cycle": 1}
    stored = studies[True].hydraulic_aperture.sel(at | {"branch": "loading"})
    level = int(np.flatnonzero(np.isclose(stored.stress, 1e6))[0])
    assert float(stored[level]) == crossing(closed.normal_stress.values[here], along, 1e6)


def test_the_table_has_means_over_those_that_succeeded_and_reach_the_stress(studies):
    study = studies[True].copy(deep=True)
    study["status"][0, 1] = 16
    study["hydraulic_aperture"][0, 2, 0, 0, 0, 3] = np.nan
    keys = ["case", "cycle", "branch", "direction", "stress_MPa"]
    rows = flow_table(study).set_index(keys).loc["slate-base", 1, "loading", "x"]
    assert list(rows.samples)[:4] == [2, 2, 2, 1]
    both = study.sel(case="slate-base", cycle=1, branch="loading", direction="x")
    at = both.isel(stress=2, realization=[0, 2])
    mean = 1e3 * float(at.hydraulic_aperture.mean())
    assert rows.hydraulic_aperture_mean_mm.iloc[2] == pytest.approx(mean)
    ratio = (at.hydraulic_aperture / at.mean_aperture).values
    assert rows.ratio_mean.iloc[2] == pytest.approx(ratio.mean())
    assert rows.ratio_standard_deviation.iloc[2] == pytest.approx(ratio.std(ddof=1))
    assert np.isnan(rows.ratio_standard_deviation.iloc[3])


@pytest.mark.parametrize(("worst", "balanced"), [(1e-12, True), (1e-3, False)])
def test_the_checks_of_a_study_hold_the_mass_balance(studies, worst, balanced):
    numerics = study_of(TINY).numerics
    study = studies[True].copy(deep=True)
    study["largest_flow_imbalance"][0, 0] = worst
    checks = check_results(study, numerics, 3).set_index("check")
    row = checks.loc["largest sum of the cells' mass balances in a flow, relative"]
    assert row.passed == balanced
    assert not any("flow" in check for check in check_results(studies[False], numerics, 3).check)
