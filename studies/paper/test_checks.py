"""Joints of a study in its curves, its checks and the tables of its flow."""

import json

import numpy as np
import pytest
import xarray as xr

from jointclosure.ensembles.quantities import names_of_case
from jointclosure.joint.history import history_of
from jointclosure.joint.interpolation import crossing
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import FAILURE, OUTSIDE_MODEL_RANGE, TARGET_JUMPED
from studies.frame.cases import block_settings, cases_of, closed_keys
from studies.frame.datasets import of_case
from studies.frame.experiments import case_point
from studies.frame.joint_tables import join_cases, since_seating
from studies.frame.settings import walls_of
from studies.frame.simulation import close_joints
from studies.frame.test_simulation import NAMES, point_of
from studies.paper import figures
from studies.paper.apertures import flow_table
from studies.paper.checks import change_without, check_results, remarked_joints
from studies.paper.closure_tables import max_closure_table
from studies.paper.report.content import outcome, scanned_walls
from studies.paper.simulated_again import simulate_again
from tests.studied import keys_of, study_of

TINY = {
    "study": {"rocks": ["slate"], "realizations": 3},
    "rocks": {"slate": {"max_normal_stress_MPa": 2, "levels": {"jrc": None}}},
    "grid": {"cells_x": 14, "cells_y": 12},
    "output": {"stress_points": 5},
}


def tiny_study(flow: bool) -> xr.Dataset:
    """Return the dataset of the first two cases of a small study."""
    study = study_of(TINY, {"flow": flow})
    first = cases_of(study)[:2]
    names = names_of_case(flow)
    points = [case_point(study, case, range(3)) for case in first]
    closed = [of_case(close_joints(point, point.walls(), names)) for point in points]
    scenes = [part.attrs["scene"] for part in closed]
    joined = join_cases(first, closed).assign_coords(scene=("case", scenes))
    return joined.assign_attrs(configuration=json.dumps(closed_keys(keys_of(TINY, {"flow": flow}))))


@pytest.fixture(scope="module")
def studies():
    return {flow: tiny_study(flow) for flow in (False, True)}


@pytest.mark.parametrize("direction", ["x", "y"])
def test_a_study_reads_its_apertures_off_the_joints_history(studies, direction):
    study = study_of(TINY)
    settings = block_settings(study, cases_of(study)[0], range(1))
    walls = next(iter(walls_of(settings)))
    closed = simulate_walls(*walls, settings.conditions._replace(flow=True))
    here = (closed.load_cycle == 1).values & (closed.branch == "loading").values
    along = closed.hydraulic_aperture.sel(direction=direction).values[here]
    at = {"case": "slate-base", "realization": 0, "direction": direction, "cycle": 1}
    stored = studies[True].hydraulic_aperture.sel(at | {"branch": "loading"})
    level = int(np.flatnonzero(np.isclose(stored.stress, 1e6))[0])
    assert float(stored[level]) == crossing(closed.normal_stress.values[here], along, 1e6)


def test_the_table_of_flow_has_means_over_joints_whose_flow_is_known(studies):
    study = studies[True].copy(deep=True)
    study["status"][0, 1] = 16
    study["hydraulic_aperture"][0, 2, 0, 0, 0, 3] = np.nan
    keys = ["case", "cycle", "branch", "direction", "stress_MPa"]
    rows = flow_table(study).set_index(keys).loc["slate-base", 1, "loading", "x"]
    assert list(rows.samples)[:4] == [2, 2, 2, 1]
    assert list(rows.unknown)[:4] == [0, 0, 0, 1]  # reached, without a known flow
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


@pytest.fixture
def with_remarks(studies):
    """Study with net closures of 1, 2 and 6 mm in the first case; the last has two remarks."""
    study = studies[False].copy(deep=True)
    study["max_closure_seated_net"][0] = np.array([[1e-3, 2e-3, 6e-3]] * 2).T
    study["status"][0] = [0, 0, OUTSIDE_MODEL_RANGE | TARGET_JUMPED]
    study["status"][1] = OUTSIDE_MODEL_RANGE
    return study


def test_joints_outside_of_the_range_are_counted_by_case_with_the_means_without_them(with_remarks):
    table = remarked_joints(with_remarks).set_index(["remark", "case", "cycle"])
    first = table.loc["outside_model_range", "slate-base", 1]
    assert (first.joints, first.samples) == (1, 3)
    assert (first.net_closure_mean_mm, first.mean_without_mm) == pytest.approx((3.0, 1.5))
    assert first.change_percent == pytest.approx(-50.0)
    # without the first, second or third joint the change is 2/4 - 1, 1/3.5 - 1, or 0
    error = np.sqrt(2.0 * np.var([-0.5, -2.5 / 3.5, 0.0]))
    assert first.change_percent_standard_error == pytest.approx(100.0 * error)
    assert table.loc["target_jumped", "slate-base", 1].joints == 1
    none_left = table.loc["outside_model_range", str(with_remarks.case.values[1]), 1]
    assert (none_left.joints, np.isnan(none_left.change_percent)) == (3, True)


def test_the_error_of_a_change_without_joints_is_the_scatter_of_this_change_over_studies():
    random = np.random.default_rng(3)
    closures = random.lognormal(sigma=0.4, size=(4000, 16))
    marked = random.random(closures.shape) < 1.0 / (1.0 + np.exp(4.0 - 3.0 * closures))
    found = [
        change_without(*study)
        for study in zip(closures, marked, strict=True)
        if study[1].any() and (~study[1]).sum() > 1
    ]
    changes, errors = np.array(found).T
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(np.std(changes), rel=0.25)


def test_joints_that_failed_are_no_joints_with_a_remark(with_remarks):
    with_remarks["status"][1] = OUTSIDE_MODEL_RANGE | FAILURE
    assert set(remarked_joints(with_remarks).case) == {"slate-base"}


OUTSIDE = "simulations flagged outside_model_range"


@pytest.fixture
def checks(with_remarks):
    return check_results(with_remarks, study_of(TINY).numerics, 3).set_index("check").found


def test_checks_say_which_cases_lie_outside_of_the_range(checks):
    assert checks[OUTSIDE] == "4 of 6, in 2 cases"


def test_checks_say_what_cases_outside_of_the_range_change(checks, with_remarks):
    first = checks[f"{OUTSIDE} of slate-base"]
    assert first.startswith("1 of 3; change of the mean net closure since seating without them: ")
    assert "cycle 1: -50 ± 40 %" in first
    assert "no joint is left" in checks[f"{OUTSIDE} of {with_remarks.case.values[1]}"]
    largest = checks[f"largest change of a mean net closure since seating without {OUTSIDE}"]
    assert largest == "-50 ± 40 % (slate-base, cycle 1)"


def test_the_report_counts_joints_outside_of_the_range_among_those_used(with_remarks):
    with_remarks["status"][1] = OUTSIDE_MODEL_RANGE | FAILURE
    outside = outcome(with_remarks, {"slate": "Slate"})["remarks"]["outside_model_range"]
    assert (outside["joints"], outside["cases"]) == (1, 1)
    assert "-50 ± 40 % (± standard error; Slate, cycle 1)" in outside["change"]


def test_the_report_describes_scanned_walls(with_remarks):
    assert scanned_walls(with_remarks) == {}
    about = {"upper": {"file": "a.txt"}, "lower": {"file": "b.txt"}, "windows_side_by_side": 2}
    walls = {"slate": about | {"warnings": "upper wall: one\nlower wall: two"}}
    assert scanned_walls(with_remarks.assign_attrs(walls=json.dumps(walls))) == {
        "slate": {
            "files": ["a.txt", "b.txt"],
            "warnings": ["upper wall: one", "lower wall: two"],
            "apart": 2,
        }
    }


@pytest.mark.parametrize("seating", [None, 5e5])
def test_the_surface_closest_to_the_mean_is_drawn_by_its_stored_steps(studies, seating):
    study = studies[False]
    configuration = study_of(TINY)
    figure = figures.closure_figure(study, configuration.rocks, seating, 1.5)
    chosen = figures.closest_to_mean(study, "slate-base", seating)
    history = simulate_again(study, "slate-base", chosen)
    gross = study.closure - study.residual_closure.shift(cycle=1, fill_value=0.0)
    stored = gross if seating is None else since_seating(study)
    for cycle, axes in enumerate(figure.axes, start=1):
        bold = [line.get_xydata() for line in axes.lines if line.get_linewidth() == 2.0]
        for line, branch in zip(bold, ("loading", "unloading"), strict=True):
            if seating is None:
                assert len(line) == history_of(history).branch(cycle, branch).steps.size
            at = {"case": "slate-base", "realization": chosen, "cycle": cycle, "branch": branch}
            curve = stored.sel(at)
            curve = curve[(curve.stress >= (seating or 0.0)).values]
            for stress, closure in zip(curve.stress.values, curve.values, strict=True):
                # a loading that ends a little below its maximum is read at its end
                at_stress = min(1e-6 * stress * (1.0 - 1e-9), line[:, 1].max())
                read = crossing(line[:, 1], line[:, 0], at_stress)
                np.testing.assert_allclose(read, 1e3 * closure, rtol=1e-6, atol=1e-9)


@pytest.fixture(scope="module")
def with_a_failure():
    """Joints of which one has flat walls without substrate: a contact that nothing can carry."""
    changes = {"effects": {"substrate": False, "interaction": False}}
    point = point_of("slate-base", range(4), changes)
    pairs = list(point.walls())
    for wall in pairs[2]:
        wall[:] = 0.0
    lines = []
    repeat = "python -m studies repeat r slate-base"
    closed = close_joints(point, pairs, NAMES, report=lines.append, repeat=repeat)
    return point.settings.case, closed, lines


def test_a_realisation_that_fails_is_named(with_a_failure):
    _, closed, lines = with_a_failure
    assert closed.status.values.tolist() == [0, 0, 64, 0]
    assert "failed; to repeat it: python -m studies repeat r slate-base 2" in lines[2]
    assert not any("failed" in line for line in lines[:2] + lines[3:])


def test_a_realisation_that_fails_has_no_readings(with_a_failure):
    _, closed, _ = with_a_failure
    for name, values in closed.isel(joint=2).data_vars.items():
        counted = name == "timing_simulation" or values.dtype.kind == "i"
        assert np.isfinite(values).all() if counted else np.isnan(values).all()


def test_a_realisation_that_fails_is_in_no_mean(with_a_failure):
    case, closed, _ = with_a_failure
    table = max_closure_table(join_cases([case], [of_case(closed)]))
    good = closed.max_closure.values[[0, 1, 3]]
    assert table.samples.tolist() == [3, 3]
    np.testing.assert_allclose(table.max_closure_mean_mm, 1e3 * good.mean(axis=0), rtol=1e-14)


RESIDUAL, VOLUME = "largest_residual", "volume_error"


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        (RESIDUAL, 1e-4, 1.1e-4),  # of a force tolerance of 1e-4
        (VOLUME, 0.9e-12, 1.1e-12),
        ("largest_flow_imbalance", 0.9e-6, 1.1e-6),
        ("least_force", 0.0, -1e-12),
        ("max_closure", 1e-12, 0.0),
        ("max_closure", 1e-12, np.nan),
    ],
)
def test_one_joint_beyond_a_limit_fails_one_check_unless_the_joint_failed(studies, name, good, bad):
    numerics = study_of(TINY).numerics
    failed = {}
    for value in (good, bad):
        study = studies[True].copy(deep=True)
        cycle = {"cycle": 0} if "cycle" in study[name].dims else {}
        study[name][{"case": 1, "realization": 2} | cycle] = value
        checks = check_results(study, numerics, 3)
        failed[value] = checks[~checks.passed].check.tolist()
        study["status"][1, 2] = 16
        checks = check_results(study, numerics, 3)
        count = ["simulations in a status of success"]
        assert checks[~checks.passed].check.tolist() == count
    assert failed[good] == []
    assert len(failed[bad]) == 1


def test_the_axis_of_closures_since_seating_has_the_range_of_the_joints_not_of_the_law(studies):
    rocks = study_of(TINY).rocks
    figure = figures.closure_figure(studies[False], rocks, 5e5, 1.5, history=lambda *_: None)
    for axes in figure.axes:
        law = next(line for line in axes.lines if line.get_color() == "0.2")
        joints = [line.get_xdata() for line in axes.lines if line is not law]
        reach = max(np.nanmax(x) for x in joints)
        assert axes.get_xlim()[1] < 1.1 * reach
    assert law.get_xdata().max() > axes.get_xlim()[1]
