"""What accuracy costs: settings from a design, and errors, orders and sources from known data."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.engine.points import close_points, one_joint
from studies.accuracy.cost import (
    Resampling,
    _sampling,
    cost_table,
    order_table,
    runs_of,
    source_table,
)
from studies.accuracy.design import Setting, design_of
from studies.accuracy.study import EXPERIMENT
from studies.frame.config.files import read_plain
from tests.studied import ROOT, checked_study

TINY = read_plain(ROOT / "tests/workflow/tiny_accuracy.yaml")
LEVELS = [60e9, 66e9, 72e9]


def design(*changes):
    """Settings and runs of a design, by scene, knob and value, and by name."""
    settings, runs = design_of(checked_study(*changes).keys)
    return {(s.scene, s.knob, s.value): s for s in settings}, runs


def test_knobs_scale_set_and_bring_settings_and_equal_ones_share_a_run():
    found, runs = design(TINY)

    def level(*place):
        return runs[found[place].run].levels[0]

    half = level("full", "steps", 0.5).numerics
    assert half.displacement_step == 6.25e-6
    assert half.later_displacement_step == 6.25e-6  # not scaled by this design
    assert level("full", "resolved", 0.05).numerics.breakage == "resolved"
    assert level("full", "surface_rule", "hurst 0.6").surfaces.surface.hurst == 0.6
    assert not level("elastic", "base", "").case.effects.breakage
    assert ("elastic", "steps", 1) not in found
    assert found["full", "steps", 1].run == found["full", "base", ""].run
    assert len(runs) == len(found) - 1
    assert found["full", "surface_rule", "hurst 0.6"].other_joints


def test_a_rocks_own_effects_are_those_that_the_accuracy_study_closes():
    own = {"rocks": {"slate": {"effects": {"interaction": False}}}}
    closed = []
    for changes in ((TINY,), (TINY, own)):
        name = design(*changes)[0]["elastic", "base", ""].run
        points = EXPERIMENT.design(checked_study(*changes)).jobs[name]
        closed.append(close_points(map(one_joint, points), EXPERIMENT.quantities))
    together, alone = closed
    # contacts that do not push each other down have no bulk indentation
    assert np.all(together.max_closure_net < together.max_closure)
    assert np.all(alone.max_closure_net == alone.max_closure)


def test_every_setting_of_the_accuracy_study_can_be_run():
    _, runs = design_of(checked_study(read_plain(ROOT / "studies/accuracy/accuracy.yaml")).keys)
    assert len(runs) > 100


def test_a_run_closes_the_same_surfaces_at_all_levels():
    design = EXPERIMENT.design(checked_study(TINY))
    name, points = next(iter(design.jobs.items()))
    run = runs_of(close_points(points, EXPERIMENT.quantities), design.parameters["bases"])[name]
    assert dict(run.sizes) == {"level": 3, "realization": 3, "cycle": 2}
    assert run.level.values.tolist() == LEVELS
    assert run.attrs["base"] == 66e9
    # elastic: a stiffer rock closes less, on every surface
    assert np.all(np.diff(run.max_closure.values, axis=0) < 0.0)
    assert np.all(run.seconds > 0.0)
    assert np.all(run.max_closure_net < run.max_closure)  # contacts push each other down


def fake_setting(knob, value, scene="full"):
    return Setting(scene, "slate", knob, value, f"{scene}-{knob}-{value}", knob == "surface_rule")


def fake_run(error, seconds, n=12, noise=0.0):
    """Closures whose mean is off by a share, on the same random surfaces."""
    rng = np.random.default_rng(1)
    surfaces = 1.0 + 0.2 * rng.standard_normal(n)
    surfaces = surfaces + noise * np.random.default_rng(int(1e6 * error)).standard_normal(n)
    levels = np.array([1.1, 1.0, 0.9])[:, None]
    closures = 1e-3 * (1.0 + error) * levels * surfaces
    net = 1e-3 * (0.5 + error) * levels * surfaces
    shape = (3, n)
    return xr.Dataset(
        {
            "max_closure": (("level", "realization", "cycle"), closures[..., None]),
            "max_closure_net": (("level", "realization", "cycle"), net[..., None]),
            "status": (("level", "realization"), np.zeros(shape, np.int16)),
            "seconds": (("level", "realization"), np.full(shape, seconds)),
            "fft_pair": (("level", "realization", "cycle"), np.full((*shape, 1), 2e-4)),
        },
        coords={"level": LEVELS, "cycle": [1]},
        attrs={"base": 66e9},
    )


DRAWN = (200, 0.95)


def turned(noise=0.0):
    """A knob of second order, and the runs of its settings."""
    values = [0.5, 1.0, 2.0, 4.0]
    settings = [fake_setting("base", ""), *(fake_setting("steps", value) for value in values)]
    settings.append(fake_setting("resolved", 0.005))
    settings.append(fake_setting("surface_rule", "hurst 0.6"))
    runs = {
        fake_setting("steps", value).run: fake_run(0.01 * value**2, 1.0 / value, noise=noise)
        for value in values
    }
    runs[fake_setting("base", "").run] = fake_run(0.01, 1.0, noise=noise)
    runs[fake_setting("resolved", 0.005).run] = fake_run(0.0, 3.0)
    runs[fake_setting("surface_rule", "hurst 0.6").run] = fake_run(0.4, 1.0)
    return settings, runs


def costs_of(settings, runs):
    """Errors held against the exact result."""
    finest = {"full": {"knob": "resolved", "value": 0.005}}
    return cost_table(settings, runs, finest, Resampling(np.random.default_rng(3), *DRAWN), 0.05)


def weighed(noise=0.0):
    return costs_of(*turned(noise))


def sources_of(settings, runs, realizations=20):
    drawn = Resampling(np.random.default_rng(4), *DRAWN)
    table = source_table(costs_of(settings, runs), runs, "full", realizations, drawn)
    return table.set_index("source")


def test_errors_times_and_order_are_those_put_in():
    costs = weighed()
    steps = costs[costs.knob == "steps"]
    np.testing.assert_allclose(steps.mean_error_percent, [0.25, 1.0, 4.0, 16.0], rtol=1e-9)
    np.testing.assert_allclose(steps.deviation_error_percent, [0.25, 1.0, 4.0, 16.0], rtol=1e-9)
    np.testing.assert_allclose(steps.net_error_percent, [0.5, 2.0, 8.0, 32.0], rtol=1e-9)
    np.testing.assert_allclose(steps.interval_error_percent, 0.0, atol=1e-6)
    np.testing.assert_allclose(steps.relative_time, [2.0, 1.0, 0.5, 0.25])
    assert np.all(steps.mean_low <= steps.mean_error_percent + 1e-9)
    orders = order_table(costs).set_index("knob")
    assert orders.loc["steps", "order"] == pytest.approx(2.0, abs=1e-6)
    assert "surface_rule" not in orders.index
    assert "fewer than three" in orders.loc["resolved", "remark"]
    rule = costs[costs.knob == "surface_rule"].iloc[0]
    # other joints: held against the base setting, and with the scatter of both
    assert rule.mean_error_percent == pytest.approx(100 * (1.4 / 1.01 - 1.0))
    assert rule.mean_high - rule.mean_low > 5.0


def test_the_error_over_all_levels_is_that_of_the_mean_of_all():
    settings, runs = turned()
    base, finest = (runs[fake_setting(*place).run] for place in (("base", ""), ("resolved", 0.005)))
    base.max_closure[0] *= 1.2
    row = costs_of(settings, runs).iloc[0]
    assert row.mean_error_percent == pytest.approx(1.0)
    expected = 100.0 * (float(base.max_closure.mean() / finest.max_closure.mean()) - 1.0)
    assert row.levels_error_percent == pytest.approx(expected)
    assert row.levels_low <= row.levels_error_percent <= row.levels_high


def test_noise_makes_an_order_unclear_and_is_said():
    orders = order_table(weighed(noise=0.5)).set_index("knob")
    assert np.isnan(orders.loc["steps", "order"])
    assert orders.loc["steps", "remark"]


def test_failed_realisations_are_left_out_and_counted():
    settings = [fake_setting("base", ""), fake_setting("resolved", 0.005)]
    runs = {s.run: fake_run(0.1 * (s.knob == "base"), 1.0) for s in settings}
    runs[settings[0].run].status[1, 4] = 16
    runs[settings[0].run].max_closure[:, 4] = np.nan
    runs[settings[0].run].max_closure_net[:, 4] = np.nan
    finest = {"full": {"knob": "resolved", "value": 0.005}}
    costs = cost_table(settings, runs, finest, Resampling(np.random.default_rng(3), 50, 0.95), 0.05)
    base = costs[costs.knob == "base"].iloc[0]
    assert (base.samples, base.failed) == (11, 1)
    assert base.mean_error_percent == pytest.approx(10.0)


def test_sources_of_the_configured_setting():
    sources = sources_of(*turned())
    assert sources.loc["steps", "error_percent"] == pytest.approx(1.0)
    assert sources.loc["surface rule (hurst 0.6)", "error_percent"] > 30.0
    base = weighed().iloc[0]
    expected = 100.0 * base.deviation_mm / base.mean_mm / np.sqrt(20)
    assert sources.loc["sampling", "error_percent"] == pytest.approx(expected)
    assert "tolerances" not in sources.index


def test_what_tolerances_move_is_told_by_the_same_surfaces():
    settings, runs = turned()
    settings.append(fake_setting("paper_tolerances", "tight"))
    # all surfaces are off by the same share: no scatter from surface to surface is left in it
    runs[settings[-1].run] = fake_run(0.008, 9.0)
    found = sources_of(settings, runs).loc["tolerances", ["error_percent", "low", "high"]]
    np.testing.assert_allclose(found.astype(float), 100.0 * (1.01 / 1.008 - 1.0), rtol=1e-6)
    runs[settings[-1].run] = fake_run(0.008, 9.0, noise=0.05)
    noisy = sources_of(settings, runs).loc["tolerances"]
    assert noisy.low < noisy.error_percent < noisy.high
    assert noisy.high - noisy.low > 0.5


def test_the_interval_of_a_sampling_error_covers_as_often_as_it_says():
    random, covered = np.random.default_rng(5), 0
    for _ in range(2000):
        closures = 1.0 + 0.1 * random.standard_normal(8)
        row = pd.Series(
            {"deviation_mm": closures.std(ddof=1), "mean_mm": closures.mean(), "samples": 8}
        )
        error, low, high = _sampling(row, 20, 0.95)
        assert low < error < high
        covered += low < 100.0 * 0.1 / np.sqrt(20) < high
    assert covered / 2000 == pytest.approx(0.95, abs=0.02)
