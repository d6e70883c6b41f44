"""Realisations of a study that fit measured curves best."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.measured.curves import MeasuredCurve
from studies.paper.closures import best_fits, fit_table

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
