"""Figures are drawn from made-up studies; what they show is looked at by people."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

from jointclosure.joint.barton_bandis import barton_bandis
from jointclosure.measured.curves import parsed_curve
from studies.paper import figures as plotting
from studies.paper.closures import fit_table
from studies.paper.figures import Measurements, interval_figure
from tests.studied import study_of

ROCKS = study_of().rocks
ROCK = ROCKS["slate"]._replace(max_normal_stress=2e6)


@pytest.fixture
def study():
    """Four surfaces; the third is the mean of the others on the first cycle, the last failed."""
    stress = np.array([0.0, 1e6, 2e6])
    curve = np.array([0.0, 1.0, 1.5])
    scale = np.array([0.8, 1.2, 1.0, 9.0])
    loading = 1e-4 * scale[:, None] * curve
    unloading = loading + 1e-5
    net = np.stack([loading, unloading], axis=1)[None, :, None].repeat(2, axis=2)
    bulk = np.broadcast_to(2e-5 * stress / 2e6, net.shape)
    over = ("case", "realization", "cycle")
    per_cycle = np.full((1, 4, 2), 1.5e-4)
    return xr.Dataset(
        {
            "closure": ((*over, "branch", "stress"), net + bulk),
            "bulk_indentation": ((*over, "branch", "stress"), bulk),
            "status": (over[:2], np.array([[0, 0, 2, 16]], dtype=np.int16)),
            "max_closure_net": (over, per_cycle),
            "max_closure_seated_net": (over, per_cycle - 5e-5),
            "residual_closure": (over, 0 * per_cycle),
            "residual_closure_seated_net": (over, np.full((1, 4, 2), 7e-6)),
        },
        coords={
            "case": ["one-base"], "rock": ("case", ["one"]), "parameter": ("case", ["base"]),
            "realization": range(4), "cycle": [1, 2], "branch": ["loading", "unloading"],
            "stress": stress,
        },
    )  # fmt: skip


def test_the_surface_closest_to_the_mean_is_among_those_that_succeeded(study):
    assert plotting.closest_to_mean(study, "one-base", 5e5) == 2


@pytest.mark.parametrize(
    ("seating", "first", "last", "left"),
    # the paper's figure is gross: 0.02 mm of bulk indentation at the maximum
    [(5e5, (0.0, 0.5), 0.15 - 0.05, 7e-3), (None, (0.0, 0.0), 0.15 + 0.02, 0.0)],
)
def test_closures_are_drawn_since_seating_or_since_first_touch(study, seating, first, last, left):
    figure = plotting.closure_figure(study, {"one": ROCK}, seating, 1.5)
    for axes in figure.axes:  # the second cycle has a panel of its own
        loading, unloading = [line for line in axes.lines if line.get_linewidth() == 2.0]
        assert (loading.get_xdata()[0], loading.get_ydata()[0]) == first
        np.testing.assert_allclose(loading.get_xdata()[-1], last)
        # unloading ends at seating, with the residual closure
        np.testing.assert_allclose(unloading.get_xdata()[0], left)
        assert unloading.get_ydata()[0] == first[1]


MEASURED = "stress_MPa,closure_mm,cycle\n0,0,1\n0.5,0.2,1\n1,0.25,1\n2,0.29,1\n1,0.28,1\n"


def test_a_measured_curve_is_drawn_from_its_seating_with_what_fits_it_best(study):
    curves = {"one": parsed_curve(MEASURED, "lab.csv")}
    fits = fit_table(study, curves, 5e5)
    figure = plotting.closure_figure(study, {"one": ROCK}, 5e5, 1.5, Measurements(curves, fits))
    axes = figure.axes[0]
    (measured,) = [line for line in axes.lines if line.get_color() == "k"]
    np.testing.assert_allclose(measured.get_xdata(), [0.0, 0.05, 0.09, 0.08], atol=1e-12)
    np.testing.assert_allclose(measured.get_ydata(), [0.5, 1.0, 2.0, 1.0])
    best = [line for line in axes.lines if line.get_marker() == "o"]
    assert len(best) == 2  # loading and unloading of the one cycle that was measured
    (row,) = fits.itertuples()
    assert f"cycle 1 {row.misfit_mm:.2g} mm ({row.misfit_percent:.2g} %)" in axes.get_title()


@pytest.mark.parametrize("seating", [None, 5e5])
@pytest.mark.parametrize("jrc", [8, 4, 16, 0])
def test_the_barton_bandis_law_is_drawn_where_it_holds_from_where_closures_start(
    study, seating, jrc
):
    """It counts from zero stress; since seating its closure there is subtracted."""
    figure = plotting.closure_figure(study, {"one": ROCK._replace(jrc=float(jrc))}, seating, 1.5)
    first = seating or 0.0
    for cycle, axes in enumerate(figure.axes, start=1):
        drawn = [line for line in axes.lines if line.get_color() == "0.2"]
        assert len(drawn) == (jrc == 8)
        for line in drawn:
            assert (line.get_xdata()[0], line.get_ydata()[0]) == (0.0, 1e-6 * first)
            law = barton_bandis(jrc, ROCK.intact.compressive_strength, 1.5, cycle)
            reached = 1e3 * (law.closure(2e6) - law.closure(first))
            np.testing.assert_allclose(line.get_xdata()[-1], reached)
            assert line.get_xdata().size > 100  # it is a curve between the stresses of the study


@pytest.mark.parametrize("varied", [1, 2, 3, 4])
def test_the_legend_of_intervals_lies_within_the_figure(varied):
    names = ("jrc", "poisson_ratio", "youngs_modulus", "compressive_strength")[:varied]
    rows = [(rock, name, cycle) for rock in ROCKS for name in names for cycle in (1, 2)]
    table = pd.DataFrame(rows, columns=["rock", "parameter", "cycle"]).assign(
        unit="", test="paired", extrapolated=False, length=1.0, length_low=0.5, length_high=9.0,
        length_net=1.1, paper_length=1.2, in_paper=True,
    )  # fmt: skip
    figure = interval_figure(table, ROCKS)
    FigureCanvasAgg(figure).draw()
    (legend,), panel = figure.legends, figure.axes[0].get_window_extent()
    place = legend.get_window_extent()
    assert 0.0 <= place.x0 < place.x1 <= figure.bbox.x1
    assert 0.0 <= place.y0 < place.y1 <= panel.y0
    assert panel.height > 0.3 * panel.width
