"""Effects chosen by a pilot: what matters stays, what does not goes, and the error is known."""

import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.engine import joints as engine
from jointclosure.engine import pilot as pilot_module
from jointclosure.engine.choice import (
    BULK_SHARE,
    _screened,
    choose_among,
    choose_effects,
    choose_for_rock,
)
from jointclosure.engine.joints import close_case, rows_by_seed
from jointclosure.engine.pilot import CONFIDENCE, Closed, Pilot, _limits, closing
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import scene_name
from studies.effects.figures import choice_figure, region_figure
from studies.effects.validation import (
    random_scene,
    validate,
    validation_settings,
    validation_summary,
)
from studies.frame.config.files import read_plain
from studies.frame.ensemble.cases import block_settings, cases_of
from tests.studied import ROOT, study_of

SPACING = 0.25e-3
DOLERITE = jc.Rock(78e9, 0.2, 165e6)
ELASTIC = jc.Effects(breakage=False, gouge=False)
SETTING = {"spacing": SPACING, "rock": DOLERITE, "cycles": 1}


@pytest.fixture(autouse=True)
def no_decision_by_measured_times(monkeypatch):
    monkeypatch.setattr(pilot_module, "WORTH", -np.inf)


def joints(cells, count=4, jrc=8.0):
    return [
        jc.wall_pair(jrc, (cells, cells), SPACING, seed, roll_off=None) for seed in range(count)
    ]


def mean_closure(pairs, effects, stress):
    closed = [jc.simulate(*p, max_normal_stress=stress, effects=effects, **SETTING) for p in pairs]
    return np.mean([float(each.max_closure[0]) for each in closed])


def test_an_effect_below_the_tolerance_is_left_out_and_its_error_is_estimated():
    pairs = joints(24)
    actual = 1.0 - mean_closure(pairs, ELASTIC._replace(interaction=False), 3e6) / mean_closure(
        pairs, ELASTIC, 3e6
    )
    assert 0.01 < actual < 0.2
    for tolerance, interaction in ((0.5 * actual, True), (3.0 * actual, False)):
        choice = choose_effects(
            pairs,
            max_normal_stress=3e6,
            effects=ELASTIC,
            tolerance=tolerance,
            joints=10_000,
            **SETTING,
        )
        assert choice.effects.interaction is interaction
    assert actual <= choice.error <= tolerance


def test_joints_that_the_pilot_closed_with_the_selected_effects_are_realisations_of_the_case():
    pairs = joints(24)
    for tolerance, effects in ((1e-6, jc.Effects()), (0.5, jc.Effects(interaction=False))):
        setting = SETTING | {"cycles": 2, "max_normal_stress": 10e6}
        choice = choose_effects(pairs, tolerance=tolerance, **setting)
        assert choice.effects == effects
        for pair, closed in zip(pairs, choice.closed, strict=False):
            again = jc.simulate(*pair, effects=effects, **setting)
            assert closed.dataset.max_closure.equals(again.max_closure)


def test_a_run_with_all_effects_shows_a_lower_bound_of_the_error_of_any_elastic_joint():
    setting = SETTING | {"cycles": 2, "max_normal_stress": 3e6}
    for pair in joints(32, 2):
        full = jc.simulate(*pair, **setting).max_closure.values
        verdict = _screened(pilot_of(pair), ("breakage", "gouge"), ELASTIC, 1e-3)
        assert not verdict.left_out
        # whatever an elastic joint closes by, it does so in both cycles
        for elastic in np.linspace(full.min(), full.max(), 50):
            assert 0.0 < verdict.error <= np.abs(elastic / full - 1.0).max() + 1e-12
        without = jc.simulate(*pair, effects=ELASTIC, **setting).max_closure.values
        assert verdict.error <= np.abs(without / full - 1.0).max()


def test_interaction_is_not_tested_where_bulk_indentation_exceeds_the_tolerance():
    (pair,) = joints(32, 1)
    pilot = pilot_of(pair)
    (full,) = (closed.dataset for closed in pilot.closed[jc.Effects()])
    share = float((full.max_bulk_indentation / full.max_closure).max())
    fewer = jc.Effects(interaction=False)
    limit = share / BULK_SHARE
    assert _screened(pilot, ("interaction",), fewer, 0.99 * limit).error == pytest.approx(share)
    assert _screened(pilot, ("interaction",), fewer, 1.01 * limit) is None
    assert set(pilot.closed) == {jc.Effects()}


def pilot_of(pair):
    conditions = Conditions(SPACING, DOLERITE, 3e6, 2, 0.0)
    return Pilot(closing([pair], conditions), jc.Effects(), 20)


FEWER = jc.Effects(interaction=False)


def made_up(changes, joints=180, bulk=0.0, seconds=0.5):
    """Pilot of joints whose closure changes by given values without interaction."""

    def close(number, effects):
        if number >= len(changes):
            return None
        closure = 1.0 + (changes[number] if effects == FEWER else 0.0)
        dataset = xr.Dataset(
            {
                "status": 0,
                "max_closure": ("cycle", [closure, 0.9 * closure]),
                "max_bulk_indentation": ("cycle", [bulk, bulk]),
            }
        )
        return Closed(dataset, 1.0 if effects == jc.Effects() else seconds)

    return Pilot(close, jc.Effects(), joints)


def test_pairs_are_closed_until_the_interval_is_inside_or_outside_of_the_tolerance():
    inside = made_up([0.010, 0.011, 0.010, 0.011], 10_000)
    assert inside.test(FEWER, jc.Effects(), 0.05).left_out
    assert len(inside.closed[FEWER]) == 2
    outside = made_up([0.100, 0.101, 0.100, 0.101], 10_000)
    assert not outside.test(FEWER, jc.Effects(), 0.05).left_out
    assert len(outside.closed[FEWER]) == 2
    unclear = made_up([0.0, 0.09] * 4, 10_000)
    unclear.test(FEWER, jc.Effects(), 0.05)
    assert len(unclear.closed[FEWER]) == 8


@pytest.mark.parametrize(("count", "bound"), [(20, 1.0), (180, 1.8), (540, 5.4)])
def test_the_time_that_a_test_may_lose_is_bounded_by_the_number_of_joints(count, bound):
    pilot = made_up([0.0, 0.11] * 10, count, seconds=0.45)
    verdict = pilot.test(FEWER, jc.Effects(), 0.05)
    assert not verdict.left_out
    assert bound - 0.45 < pilot.lost(jc.Effects()) <= bound


def test_a_test_may_be_limited_to_a_part_of_the_time_that_may_be_lost():
    for part, pairs in ((0.5, 2), (1.0, 4)):
        pilot = made_up([0.0, 0.11] * 10, 180, seconds=0.45)
        pilot.test(FEWER, jc.Effects(), 0.05, 1, part)
        assert len(pilot.closed[FEWER]) == pairs


def test_the_mean_decides_with_more_caution_where_less_time_is_saved():
    for tolerance, seconds, left_out in ((0.05, 0.5, True), (0.05, 0.8, False), (0.07, 0.8, True)):
        pilot = made_up([0.0, 0.06] * 10, 180, seconds=seconds)
        assert pilot.test(FEWER, jc.Effects(), tolerance).left_out is left_out


def test_one_pair_counts_twice_if_there_is_no_time_for_another():
    for change, left_out in ((0.02, True), (0.03, False)):
        pilot = made_up([change] * 4, 20, seconds=0.8)
        assert pilot.test(FEWER, jc.Effects(), 0.05).left_out is left_out
        assert len(pilot.closed[FEWER]) == 1


def test_with_few_pairs_nothing_is_left_out_that_needs_many():
    for pairs, left_out in ((9, False), (10, True)):
        pilot = made_up([0.0] * pairs, 10_000)
        assert pilot.test(FEWER, jc.Effects(), 0.05, 10).left_out is left_out


def test_what_saves_little_time_is_tested_once_and_kept(monkeypatch):
    monkeypatch.setattr(pilot_module, "WORTH", 0.1)
    pilot = made_up([0.0] * 4, 10_000, seconds=0.95)
    assert not pilot.test(FEWER, jc.Effects(), 0.05).left_out
    assert len(pilot.closed[FEWER]) == 1


def test_limits_hold_at_all_looks_together_as_often_as_stated():
    random = np.random.default_rng(1)
    changes = random.normal(0.3, 1.0, (1000, 10, 1))
    wrong = np.zeros(2)
    for row in changes:
        limits = [_limits(row[:count]) for count in range(2, 11)]
        wrong += any(least > 0.3 for least, _ in limits), any(most < 0.3 for _, most in limits)
    # each of the two decisions: an effect stays, or goes
    assert (wrong / 1000.0 <= 1.0 - CONFIDENCE).all()


def test_soft_peaks_are_tested_only_where_walls_are_crushed():
    for bulk, tested in ((0.1, False), (0.5, True)):
        choice = choose_among(made_up([0.2] * 20, bulk=bulk), 0.05)
        (reason,) = (reason for reason in choice.reasons if "soft_peaks" in reason)
        assert ("is not tested" not in reason) is tested
        assert choice.effects.soft_peaks is not tested


def test_the_cases_of_a_rock_share_the_decision_of_the_largest_stress_over_strength():
    study = study_of(
        {"study": {"rocks": ["slate"], "realizations": 4, "pool": None}},
        {"grid": {"cells_x": 16, "cells_y": 16}, "effects": {"auto": 0.02}},
    )
    cases = {case.label: case for case in cases_of(study)}
    settings = {
        label: block_settings(study, cases, label, range(4)) for label, case in cases.items()
    }
    assert len(settings) > 5
    pilot = choose_for_rock(settings)
    choice, examined = json.loads(pilot.attrs["chosen"]), pilot.attrs["case"]
    assert jc.Effects(**choice["effects"]) == jc.Effects()
    ratios = {
        label: one.case.max_normal_stress / one.case.intact.compressive_strength
        for label, one in settings.items()
    }
    assert ratios[examined] == max(ratios.values())
    lenient = {label: one._replace(effects_chosen_to=0.99) for label, one in settings.items()}
    choice = json.loads(choose_for_rock(lenient).attrs["chosen"])
    assert jc.Effects(**choice["effects"]) != jc.Effects()
    assert choice["error"] == choice["cases"][examined]["error"]


@pytest.mark.parametrize("tolerance", [1e-6, 0.9])
def test_joints_of_a_pilot_are_taken_bit_by_bit_and_not_closed_again(monkeypatch, tolerance):
    study = study_of(
        {"study": {"rocks": ["slate"], "realizations": 4, "pool": None}},
        {"grid": {"cells_x": 16, "cells_y": 16}, "effects": {"auto": tolerance}},
    )
    case = cases_of(study)[0]
    settings = block_settings(study, {case.label: case}, case.label, range(4))
    before = choose_for_rock({case.label: settings})
    choice = json.loads(before.attrs["chosen"])
    effects = jc.Effects(**choice["effects"])
    assert (effects == jc.Effects()) is (tolerance < 0.5)
    used = settings.with_effects(effects)
    plain = close_case(used)
    closed = []
    close = engine.close_joint
    monkeypatch.setattr(engine, "close_joint", lambda *given: closed.append(1) or close(*given))
    taken = close_case(used, known=rows_by_seed(before))
    assert len(closed) == 4 - before.sizes["realization"]
    assert len(closed) < 4
    assert taken.drop_vars("timing_simulation").identical(plain.drop_vars("timing_simulation"))


def test_effects_that_are_not_allowed_are_not_brought_in():
    choice = choose_effects(
        joints(12), max_normal_stress=5e6, effects=ELASTIC, tolerance=0.9, **SETTING
    )
    assert not choice.effects.breakage
    assert not choice.effects.gouge


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"tolerance = 1\.5"):
        choose_effects(joints(8), max_normal_stress=1e6, tolerance=1.5, **SETTING)
    with pytest.raises(InputError, match="0 pairs"):
        choose_effects([], max_normal_stress=1e6, **SETTING)
    with pytest.raises(InputError, match=r"walls: has an array of shape \(8,\), must be walls"):
        choose_effects(joints(8)[0], max_normal_stress=1e6, **SETTING)
    with pytest.raises(InputError, match="tolerance = 'auto': must be a number"):
        choose_effects(joints(8), max_normal_stress=1e6, tolerance="auto", **SETTING)
    with pytest.raises(InputError, match="effects = 'auto': must be an Effects"):
        choose_effects(joints(8), max_normal_stress=1e6, effects="auto", **SETTING)


@pytest.fixture(scope="module")
def settings():
    small = {"scenes": 3, "realizations": 2, "tolerances": [0.05, 0.9], "cells": [10, 14]}
    effects = read_plain(ROOT / "studies/effects/effects.yaml")
    return validation_settings(study_of(effects, {"ablation": {"validation": small}}))


def test_random_scenes_keep_to_their_ranges_and_do_not_depend_on_how_many_there_are(settings):
    scenes = [random_scene(settings, number) for number in range(50)]
    assert scenes == [random_scene(settings, number) for number in range(50)]
    assert len(set(scenes)) == 50
    for scene in scenes:
        assert 10e9 <= scene.rock.youngs_modulus <= 100e9
        assert scene.max_normal_stress <= scene.rock.compressive_strength
        assert 10 <= scene.cells <= 14


def test_a_choice_is_compared_with_the_full_model_and_with_the_best_scene(settings):
    table = validate(settings, 1)
    assert table.tolerance.tolist() == [0.05] * 3 + [0.9] * 3
    assert table.joints.tolist() == [20, 180, 540] * 2
    assert (table.actual_percent > 0.0).any()
    assert (table.holds == (table.actual_percent <= 100.0 * table.tolerance)).all()
    spent = table.chosen_s + table.pilot_s
    assert table.regret.to_numpy() == pytest.approx((spent / table.best_s).to_numpy())
    assert (table.best_s <= table.full_s).all()
    # elastic joints close otherwise, and without interaction at 90 % some scene is faster
    assert (table.without_breakage_percent > 1.0).all()
    assert (table.best_s < table.full_s)[table.tolerance == 0.9].all()
    figure = choice_figure(table)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert texts == ["tolerance 5 %", "tolerance 90 %"]
    panels = [axes for axes in region_figure(table).axes if axes.get_title()]
    assert len(panels) == 4
    for axes in panels:
        points = sum(len(marks.get_offsets()) for marks in axes.collections)
        failed = sum(len(line.get_xdata()) for line in axes.lines)
        assert points + failed == 1  # one condition


def test_the_summary_counts_the_scenes_within_the_tolerance_and_the_time_saved():
    table = pd.DataFrame(
        {
            "tolerance": [0.1] * 4,
            "joints": [20] * 4,
            "chosen": [scene_name(jc.Effects())] * 2 + ["substrate"] * 2,
            "holds": [True, True, True, False],
            "actual_percent": [0.0, 0.0, 4.0, 12.0],
            "full_s": [10.0, 10.0, 10.0, 20.0],
            "chosen_s": [10.0, 11.0, 1.0, 2.0],
            "pilot_s": [1.0, 0.0, 1.0, 3.0],
            "best_s": [10.0, 10.0, 1.0, 20.0],
            "saved_percent": [-10.0, -10.0, 80.0, 75.0],
            "best_saved_percent": [0.0, 0.0, 90.0, 0.0],
            "regret": [1.1, 1.1, 2.0, 0.25],
            "effectivity": [np.nan, np.nan, 2.0, 0.5],
        }
    )
    row = validation_summary(table).iloc[0]
    assert (row.scenes, row.changed) == (4, 2)
    assert row.held_percent == pytest.approx(75.0)
    assert row.held_of_changed_percent == pytest.approx(50.0)
    # the last scene, beyond the tolerance, saves nothing and loses its pilot
    assert row.saved_percent == pytest.approx(100.0 * (-1.0 - 1.0 + 8.0 - 3.0) / 50.0)
    assert row.best_saved_percent == pytest.approx(100.0 * 9.0 / 50.0)
    assert row.share_of_best_percent == pytest.approx(100.0 * 3.0 / 9.0)
    assert row.mean_share_of_best_percent == pytest.approx(100.0 * (-10 - 10 + 80 - 15) / 90.0)
    assert row.least_saved_percent == pytest.approx(-15.0)
    assert row.largest_lost_percent == pytest.approx(10.0)
    assert row.largest_error_percent == 12.0
    assert row.median_regret == pytest.approx(1.1)
    assert row.effectivity_good_percent == pytest.approx(50.0)
    assert row.effectivity_below_percent == pytest.approx(50.0)
