"""What each effect adds: scenes on the same joints, and contributions from known data."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.parameters import Effects, scene_name
from jointclosure.plotting.effects import effect_figure
from jointclosure.studies.effects.ablation import (
    CONTRIBUTIONS,
    FULL,
    SCENES,
    close_scene,
    effect_table,
)
from jointclosure.studies.effects.design import conditions_of
from tests.studied import study_of

TINY = {
    "study": {"name": "tiny_effects", "rocks": ["slate"], "realizations": 2},
    "grid": {"cells_x": 10, "cells_y": 10},
    "ablation": {"jrc": [4, 10], "stress_MPa": [0.5, 2]},
}


def test_there_are_eighteen_scenes_and_every_contribution_is_between_two_of_them():
    assert len(SCENES) == 18
    assert scene_name(Effects(False, False, False, False, False)) == "hertz_only"
    for _, with_it, without_it in CONTRIBUTIONS:
        assert {scene_name(with_it), scene_name(without_it)} <= set(SCENES)


def test_a_scene_closes_the_same_surfaces_at_every_condition():
    study = study_of(TINY)
    conditions, design = conditions_of(study, "slate"), study.ablation
    elastic = close_scene(conditions, design, FULL._replace(breakage=False, gouge=False))
    assert dict(elastic.sizes) == {"jrc": 2, "stress": 2, "realization": 2, "cycle": 2}
    assert np.all(elastic.max_closure.diff("stress") > 0.0)
    # without breakage loading and unloading are one curve
    np.testing.assert_allclose(elastic.hysteresis, 0.0, atol=1e-12)
    full = close_scene(conditions, design, FULL)
    # what breaks is not given back; single tiny joints have a handful of points only
    first = full.hysteresis.sel(cycle=1)
    assert float(first.mean()) > 0.2
    assert np.all(first < 1.0)


def fake(factor, seconds, failed=False):
    rng = np.random.default_rng(4)
    closures = factor * (1.0 + 0.1 * rng.standard_normal((1, 1, 6, 2)))
    shape = ("jrc", "stress", "realization")
    status = np.zeros((1, 1, 6), np.int16)
    status[0, 0, 2] = 128 if failed else 0
    return xr.Dataset(
        dict.fromkeys(("max_closure", "residual_closure"), ((*shape, "cycle"), closures))
        | {
            "hysteresis": ((*shape, "cycle"), np.full((1, 1, 6, 2), 0.5 * factor)),
            "status": (shape, status),
            "timing_simulation": (shape, np.full((1, 1, 6), seconds)),
            "timing_pair": (shape, np.full((1, 1, 6), 1e-4)),
        },
        coords={"jrc": [8.0], "stress": [1e7], "cycle": [1, 2]},
    )


@pytest.fixture
def table():
    runs = {("slate", name): fake(1.0, 1.0) for name in SCENES}
    runs["slate", scene_name(FULL._replace(gouge=False))] = fake(1.25, 0.5, failed=True)
    return effect_table(runs)


def test_contributions_and_costs_are_those_put_in(table):
    gouge = table[(table.effect == "gouge") & (table.cycle == 1)].iloc[0]
    assert (gouge.samples, gouge.failed_without) == (5, 1)
    assert gouge.time_ratio == pytest.approx(2.0)
    assert gouge.max_closure_added_percent == pytest.approx(-25.0)
    # in proportion on every surface: the paired differences scatter a quarter of the closures
    assert 0.0 < gouge.max_closure_standard_error < 2.0
    assert gouge.hysteresis_added_percent == pytest.approx(-12.5)
    others = table[table.effect != "gouge"]
    assert np.all(others.max_closure_added_percent == 0.0)
    assert others.time_ratio.to_numpy() == pytest.approx(1.0)


def test_the_figure_has_a_panel_for_each_effect_and_cycle(table):
    figure = effect_figure(table)
    panels = [axes for axes in figure.axes if axes.get_xscale() == "log"]
    assert len(panels) >= 10


def test_the_key_of_the_figure_says_what_the_sizes_of_its_marks_are(table):
    figure = effect_figure(table)
    entries = [text.get_text() for text in figure.legends[0].get_texts()]
    sizes = [handle.get_markersize() for handle in figure.legends[0].legend_handles[:-2]]
    assert entries[:-2] == [f"JRC {jrc:g}" for jrc in sorted(table.jrc.unique())]
    drawn = {
        round(float(size), 6)
        for axes in figure.axes
        for marks in axes.collections
        for size in getattr(marks, "get_sizes", list)()
    }
    assert {round(size**2, 6) for size in sizes} == drawn
