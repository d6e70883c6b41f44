"""Mated, natural and non-mated walls: what is closed, and the shift that unmates."""

import matplotlib
import numpy as np
import pytest
import xarray as xr

from jointclosure.config.files import ConfigurationError
from jointclosure.inputs import InputError
from jointclosure.plotting.mismatch import mismatch_figure
from jointclosure.studies.mismatch.closing import close_mismatched, labels_of, settings_of
from jointclosure.studies.mismatch.table import independence_table, mismatch_table
from tests.studied import study_of

TINY = {
    "study": {"name": "tiny_mismatch", "rocks": ["slate"], "realizations": 3, "draws": "common"},
    "grid": {"cells_x": 24, "cells_y": 24},
    "rocks": {"slate": {"max_normal_stress_MPa": 5}},
    "surface": {"roll_off_mm": None},
    "mismatch": {"wavelength_mm": [3, 1], "shift_in_cells": [0, 8], "tolerance": 0.1},
}


@pytest.fixture(scope="module")
def run():
    study = study_of(TINY)
    closed = [
        close_mismatched(settings_of(study, "slate", wavelength))
        for wavelength in labels_of(study).values()
    ]
    return xr.concat(closed, "wavelength", join="outer")


def test_wavelengths_are_closed_in_order_with_independent_walls_last(run):
    assert list(labels_of(study_of(TINY))) == ["1000um", "3000um", "independent"]
    assert run.wavelength.values.tolist() == [1e-3, 3e-3, np.inf]
    assert run["shift"].values.tolist() == [0.0, 2e-3]
    # independent walls have no shift of their own
    assert run.status.isel(wavelength=-1, shift=1).isnull().all()


def test_walls_close_more_the_longer_the_mismatch_and_shifted_ones_more_than_unshifted(run):
    first = run.sel(cycle=1).mean("realization")
    still = first.closure_seated_net.sel(shift=0.0).values
    assert still.tolist() == sorted(still)
    assert still[-1] > 1.5 * still[0]
    moved = first.closure_seated_net.sel(wavelength=1e-3).values
    assert moved[1] > 1.2 * moved[0]


def test_what_is_read_is_what_engineers_are_told(run):
    table = mismatch_table({"slate": run})
    own = run.sel(wavelength=1e-3, shift=0.0, cycle=2)
    row = table[(table.wavelength_mm == 1.0) & (table.shift_mm == 0.0) & (table.cycle == 2)]
    assert row.samples.item() == 3
    closures = 1e3 * own.closure_seated_net.values
    assert row.closure_net_since_seating_mm.item() == pytest.approx(closures.mean())
    error = closures.std(ddof=1) / np.sqrt(3)
    assert row.closure_net_since_seating_mm_error.item() == pytest.approx(error)
    # that of the mean curve: compliances add
    stiffness = 1e-9 / float((1.0 / own.stiffness_net).mean())
    assert row.normal_stiffness_net_MPa_per_mm.item() == pytest.approx(stiffness)
    stays = float(own.residual_seated_net.mean() / own.closure_seated_net.mean())
    assert row.residual_share_net.item() == pytest.approx(stays)
    assert len(table) == 2 * (2 * 2 + 1)
    figure = mismatch_figure(table)
    assert isinstance(figure, matplotlib.figure.Figure)
    assert len(figure.axes) == 8


def made_up(closures, scatter, surfaces=40):
    """A run whose mean closures over shifts are given, [0] of independent walls [m]."""
    rng = np.random.default_rng(2)
    free, *shifted = closures
    drawn = 1e-4 * (1.0 + scatter * rng.standard_normal((2, len(shifted), surfaces, 1)))
    drawn[0] *= np.array(shifted)[:, None, None]
    drawn[1, 0] *= free
    drawn[1, 1:] = np.nan
    over = ("wavelength", "shift", "realization", "cycle")
    return xr.Dataset(
        {"closure_seated_net": (over, drawn), "aperture_at_seating": (over, 0.0 * drawn + 5e-4)},
        coords={
            "wavelength": [1e-3, np.inf],
            "shift": 1e-3 * np.arange(len(shifted)),
            "cycle": [1],
        },
    )


def test_the_shift_that_unmates_is_between_those_about_the_criterion():
    run = made_up([1.0, 0.5, 0.8, 1.0], 1e-9)
    (row,) = independence_table({"slate": run}, 0.1, 1).itertuples()
    assert row.shift_mm == pytest.approx(1.5)
    assert row.low == pytest.approx(row.high)
    # in mean apertures of independent walls, 0.5 mm
    assert row.apertures == pytest.approx(3.0)
    never = made_up([1.0, 0.5, 0.6, 0.7], 1e-9)
    assert independence_table({"slate": never}, 0.1, 1).shift_mm.item() == np.inf


def test_the_interval_of_that_shift_covers_it():
    held = []
    for factor in np.linspace(0.97, 1.03, 9):
        run = made_up([1.0, 0.5, 0.8 * factor, 1.1], 0.15)
        (row,) = independence_table({"slate": run}, 0.1, 1).itertuples()
        true = 1.0 + (0.9 - 0.8 * factor) / (1.1 - 0.8 * factor)
        held.append(row.low <= true <= row.high)
        assert row.low < row.shift_mm < row.high
    assert np.mean(held) >= 0.75


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mismatch": {"shift_in_cells": [1]}}, "mismatch.shift_in_cells = [1]: must have 0 among"),
        ({"mismatch": {"wavelength_mm": [-1]}}, "mismatch.wavelength_mm = -1: must be at least"),
        ({"surface": {"correlation": 0.5}}, "mismatch: the study sets surface.mismatch_wavelength"),
        ({"study": {"name": "mismatch"}, "mismatch": None}, "belongs to another target"),
    ],
)  # fmt: skip
def test_a_design_that_cannot_be_is_refused(change, said):
    with pytest.raises(ConfigurationError) as error:
        study_of(TINY, change)
    assert said in str(error.value)


def test_a_study_without_a_design_has_no_wavelengths():
    with pytest.raises(InputError, match="mismatch = null"):
        labels_of(study_of())
