"""Measured curves beside those of a study: the surface that fits them best."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.measured.curves import MeasuredCurve
from studies.paper.closure_tables import best_fits, fit_lines, fit_table

SEATING = 0.5e6


def study(status=(0, 0, 0)):
    """Return three surfaces with 1, 2 and 3 times one closure curve, in later cycles a tenth."""
    stress = np.linspace(0.0, 2e6, 9)
    loading = 1e-4 * np.sqrt(stress / 2e6)
    unloading = 1e-4 * (0.8 + 0.2 * stress / 2e6)
    scale = np.array([1.0, 2.0, 3.0])[:, None, None, None] * np.array([1.0, 0.1])[:, None, None]
    closure = scale * np.stack([loading, unloading])
    end = closure[..., 1, 0]
    start = np.pad(end[:, :-1], ((0, 0), (1, 0)))
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
            "max_closure": (dimensions, (maximum + 3e-5)[None]),
            "max_closure_net": (dimensions, maximum[None]),
            "max_closure_seated_net": (dimensions, (maximum - seat)[None]),
            "residual_closure": (dimensions, (end + start)[None]),
            "residual_closure_seated_net": (dimensions, np.full((1, 3, 2), 7e-6)),
        },
        coords={
            "case": ["one-base"], "rock": ("case", ["one"]), "parameter": ("case", ["base"]),
            "max_normal_stress": ("case", [2e6]), "realization": [10, 11, 12], "cycle": [1, 2],
            "branch": ["loading", "unloading"], "stress": stress,
        },
    )  # fmt: skip


def like(number, cycle=1, offset=0.0):
    """Return a modelled curve as a measured one, with an offset of closure [m]."""
    base = study().isel(case=0, realization=number).sel(cycle=cycle)
    up, down = (base.closure - base.bulk_indentation).values
    stress = np.append(base.stress, base.stress[-2::-1])
    closure = np.append(up, down[-2::-1]) + offset
    return MeasuredCurve(stress, closure, np.full(stress.size, cycle), np.arange(stress.size))


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("cycle", [1, 2])
@pytest.mark.parametrize("offset", [0.0, 3e-4])
def test_the_surface_that_was_measured_fits_best_without_misfit(number, cycle, offset):
    (row,) = fit_table(study(), {"one": like(number, cycle, offset)}, SEATING).itertuples()
    assert row.misfit_mm < 1e-12
    assert row.median_misfit_mm > 1e-3
    # 6 points are above the seating on loading, and 8 on unloading
    assert (row.best_realization, row.samples, row.points) == (10 + number, 3, 14)


def test_the_misfit_is_the_root_mean_square_of_the_differences_of_closures():
    curve = like(0)
    table = fit_table(study(), {"one": curve._replace(closure=1.3 * curve.closure)}, SEATING)
    known = np.concatenate([closure for *_, closure in curve.since_seating(1, SEATING)])
    expected = 1e3 * np.sqrt(np.mean((0.3 * known) ** 2))
    assert table.misfit_mm[0] == pytest.approx(expected)
    largest = 1e3 * 1.3 * (1e-4 - 0.5e-4)
    assert table.misfit_percent[0] == pytest.approx(100 * expected / largest)


@pytest.fixture(scope="module")
def both_cycles():
    """A measured curve whose cycles are those of two surfaces."""
    pairs = zip(like(0, 1), like(2, 2), strict=True)
    return MeasuredCurve(*(np.concatenate(pair) for pair in pairs))


def test_each_cycle_has_its_own_best_surface_beside_that_of_all(both_cycles):
    table = fit_table(study(), {"one": both_cycles}, SEATING)
    assert table.cycle.tolist() == ["1", "2", "all"]
    # the first cycle's differences are ten times those of the second
    assert table.best_realization.tolist() == [10, 12, 10]
    assert [fit[:2] for fit in best_fits(table, "one")] == [(1, 10), (2, 12)]


def test_points_in_the_file_are_told_from_those_that_are_used(both_cycles):
    table = fit_table(study(), {"one": both_cycles}, SEATING)
    assert table.measured_points.tolist() == [17, 17, 34]
    assert table.points.tolist() == [14, 14, 28]
    first, *_, last = fit_lines(table)
    assert first.startswith("one, cycle 1: 14 of 17 measured points are used")
    assert first.endswith("of 3 joints number 10 fits best (rms misfit 0 mm)")
    assert last.startswith("one, all cycles: 28 of 34 measured points")


def test_a_surface_that_failed_never_fits_best(both_cycles):
    table = fit_table(study(status=(16, 0, 0)), {"one": both_cycles}, SEATING)
    assert (table.best_realization[0], table.samples[0]) == (11, 2)


def test_a_joint_that_reached_fewer_than_two_of_the_stresses_fits_no_curve():
    cut = study()
    cut.closure[0, 0, ..., 1:] = np.nan
    (row,) = fit_table(cut, {"one": like(0)}, SEATING).itertuples()
    assert (row.best_realization, row.samples) == (11, 2)


def test_a_measured_curve_without_any_closure_has_a_misfit_and_no_percentage_of_it():
    curve = like(0)
    (row,) = fit_table(
        study(), {"one": curve._replace(closure=0.0 * curve.closure)}, SEATING
    ).itertuples()
    assert row.misfit_mm > 0.0
    assert np.isnan(row.misfit_percent)
