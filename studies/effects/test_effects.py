"""What each effect adds: scenes on the same joints, and contributions from known data."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.engine.points import close_points, gridded
from jointclosure.parameters import Effects, scene_name
from studies.effects.study import CONTRIBUTIONS, EXPERIMENT, FULL, SCENES, effect_table
from tests.studied import checked_study

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
    jobs = EXPERIMENT.design(checked_study(TINY)).jobs

    def closed(effects):
        joints = close_points(jobs[f"slate.{scene_name(effects)}"], EXPERIMENT.quantities)
        return gridded(joints, ("jrc", "stress", "realization"), EXPERIMENT.quantities)

    elastic = closed(FULL._replace(breakage=False, gouge=False))
    assert dict(elastic.sizes) == {"jrc": 2, "stress": 2, "realization": 2, "cycle": 2}
    assert np.all(elastic.max_closure.diff("stress") > 0.0)
    # without breakage loading and unloading are one curve
    np.testing.assert_allclose(elastic.hysteresis, 0.0, atol=1e-12)
    full = closed(FULL)
    # what breaks is not given back; single tiny joints have a handful of points only
    first = full.hysteresis.sel(cycle=1)
    assert float(first.mean()) > 0.2
    assert np.all(first < 1.0)


def fake(scene, factor, seconds, failed=False):
    """Joints of a scene whose closures are a factor of the same surfaces'."""
    closures = factor * (1.0 + 0.1 * np.random.default_rng(4).standard_normal((6, 2)))
    rows = (
        {
            "rock": "slate",
            "scene": scene,
            "jrc": 8.0,
            "stress": 1e7,
            "realization": realization,
            "cycle": [1, 2],
            "status": 128 if failed and realization == 2 else 0,
            "seconds": seconds,
            "max_closure": closures[realization],
            "residual_closure": closures[realization],
            "hysteresis": 0.5 * factor,
            "fft_pair": 1e-4,
        }
        for realization in range(6)
    )
    return pd.concat(map(pd.DataFrame, rows))


@pytest.fixture
def table():
    changed = scene_name(FULL._replace(gouge=False))
    joints = [fake(name, 1.0, 1.0) for name in SCENES if name != changed]
    return effect_table(pd.concat([*joints, fake(changed, 1.25, 0.5, failed=True)]))


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
