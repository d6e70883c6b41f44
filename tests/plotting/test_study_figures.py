"""Figures are drawn from made-up studies; what they show is looked at by people."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.plotting import study as plotting

ROCK = {"title": "Rock", "jrc": 8, "compressive_strength_MPa": 160, "max_normal_stress_MPa": 2}


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture
def study():
    """Four surfaces; the third is the mean of the others on the first cycle, the last failed."""
    stress = np.array([0.0, 1e6, 2e6])
    curve = np.array([0.0, 1.0, 1.5])
    scale = np.array([0.8, 1.2, 1.0, 9.0])
    loading = 1e-4 * scale[:, None] * curve
    unloading = loading + 1e-5
    closure = np.stack([loading, unloading], axis=1)[None, :, None].repeat(2, axis=2)
    per_cycle = np.full((1, 4, 2), 1.5e-4)
    return xr.Dataset(
        {
            "closure": (("case", "realization", "cycle", "branch", "stress"), closure),
            "status": (("case", "realization"), np.array([[0, 0, 2, 16]], dtype=np.int16)),
            "max_closure": (("case", "realization", "cycle"), per_cycle),
            "max_closure_seated": (("case", "realization", "cycle"), per_cycle - 5e-5),
            "residual_closure": (("case", "realization", "cycle"), 0 * per_cycle),
        },
        coords={
            "case": ["one-base"], "rock": ("case", ["one"]), "parameter": ("case", ["base"]),
            "realization": range(4), "cycle": [1, 2], "branch": ["loading", "unloading"],
            "stress": stress,
        },
    )  # fmt: skip


def test_the_surface_closest_to_the_mean_is_among_those_that_succeeded(study):
    assert plotting.closest_to_mean(study, "one-base", 5e5) == 2


def test_closures_are_drawn_since_seating_for_every_success(study):
    figure = plotting.closure_figure(study, {"one": ROCK}, 5e5, 1.5)
    axes = figure.axes[0]
    assert "closure since 0.5 MPa" in axes.get_xlabel()
    assert axes.get_ylabel() == "normal stress (MPa)"
    thick = [line for line in axes.lines if line.get_linewidth() == 2.0]
    assert len(thick) == 4  # two cycles, loading and unloading
    np.testing.assert_allclose(thick[0].get_xdata()[[0, -1]], [0.0, 0.15 - 0.05])
    assert thick[0].get_ydata()[0] == 0.5


def test_intervals_without_a_root_are_crosses():
    rows = [
        {"rock": "one", "parameter": "jrc", "cycle": 1, "unit": "1", "length": np.nan,
         "length_low": 1.0, "length_high": np.inf, "length_net": 2.0, "paper_length": 1.0,
         "extrapolated": False},
    ]  # fmt: skip
    figure = plotting.interval_figure(pd.DataFrame(rows), {"one": ROCK})
    markers = [line.get_marker() for line in figure.axes[0].lines]
    assert markers.count("x") == 1
    assert markers.count("D") == markers.count("^") == 1
    assert "o" not in markers


def test_the_fit_of_eq_23_lies_on_the_maxima_of_eq_21():
    axes = plotting.equivalent_stress().axes[0]
    maxima, fit = axes.lines
    np.testing.assert_allclose(
        np.interp(maxima.get_xdata(), fit.get_xdata(), fit.get_ydata()),
        maxima.get_ydata(),
        atol=2e-4,
    )
