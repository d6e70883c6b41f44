"""Figures are drawn from made-up studies; what they show is looked at by people."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.measured.curves import parsed_curve
from jointclosure.storage.text import read_csv
from studies.paper import closure_figures as plotting
from studies.paper import sensitivity_figures
from studies.paper.closure_figures import Measurements
from studies.paper.empirical import barton_bandis
from studies.paper.measured_fits import fit_table
from tests.studied import ROOT, study_of

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


def test_the_fit_of_eq_23_lies_on_the_maxima_of_eq_21():
    axes = plotting.equivalent_stress().axes[0]
    maxima, fit = axes.lines
    np.testing.assert_allclose(
        np.interp(maxima.get_xdata(), fit.get_xdata(), fit.get_ydata()),
        maxima.get_ydata(),
        atol=2e-4,
    )


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


def stored(name, number=4):
    """A stored table of the paper's study with so many properties."""
    table = read_csv(ROOT / f"studies/paper/results/paper/{name}.csv")
    chosen = ["jrc", "youngs_modulus", "compressive_strength", "poisson_ratio"][:number]
    return table[table.parameter.isin([*chosen, "base"])]


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_the_papers_dashes_are_marked_and_the_legend_fits(number):
    intervals = stored("table_3_indifference", number)
    figure = sensitivity_figures.interval_figure(intervals, ROCKS)
    marks = [(x.get_marker(), x.get_color()) for axes in figure.axes for x in axes.lines]
    dashes = intervals.in_paper & intervals.paper_length.isna()
    assert marks.count(("x", "C1")) == dashes.sum()
    figure.canvas.draw()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1


def test_trends_have_the_errors_of_their_means():
    closures = stored("max_closure")
    cases = sorted(set(closures.case))
    values = {name: ("case", np.linspace(1.0, 2.0, len(cases))) for name in set(closures.parameter)}
    study = xr.Dataset(values, coords={"case": cases})
    figure = sensitivity_figures.trend_figure(closures, study, ROCKS)
    bars = [line for axes in figure.axes for line in axes.collections]
    assert len(bars) == len(ROCKS) * len(figure.axes)
    heights = [s[1, 1] - s[0, 1] for bar in bars for s in bar.get_segments()]
    errors = closures.max_closure_mean_mm_standard_error
    np.testing.assert_allclose([min(heights), max(heights)], [2 * errors.min(), 2 * errors.max()])


PAPER = pd.DataFrame(
    [("dolerite", "jrc", 1, 0.9, 11.0), ("dolerite", "jrc", 2, np.nan, np.nan)],
    columns=["rock", "parameter", "cycle", "paper_length", "paper_percent"],
)


def test_the_papers_dashes_stand_in_the_column_of_dashes():
    two = {name: ROCKS[name] for name in ("dolerite", "slate")}
    percent = 20.0 * np.random.default_rng(1).lognormal(0.0, 0.3, size=(4, 400))
    percent[1, :100] = np.inf  # dolerite, cycle 2
    over = ("entry", "repetition")
    drawn = xr.Dataset(
        {"percent": (over, percent), "null_percent": (over, 3.0 * percent)},
        coords={
            "rock": ("entry", np.repeat(np.array(list(two), dtype=object), 2)),
            "parameter": ("entry", np.array(["jrc"] * 4, dtype=object)),
            "cycle": ("entry", [1, 2, 1, 2]),
        },
    )
    figure = sensitivity_figures.predictive_figure(drawn, PAPER, two, 20)
    marks = [[x for x in axes.lines if x.get_marker() == "D"] for axes in figure.axes]
    ((entry,), (dash,)) = marks
    assert float(entry.get_xdata()[0]) == 11.0
    assert float(dash.get_xdata()[0]) > 500.0
    assert [text.get_text() for text in figure.axes[1].texts] == ["25 %", "0 %"]
