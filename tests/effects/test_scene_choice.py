"""Effects chosen by a pilot: what matters stays, what does not goes, and the error is known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.config.files import read_plain
from jointclosure.effects import choice as scene_choice
from jointclosure.effects import validation
from jointclosure.effects.choice import (
    choose_effects,
    choose_for_case,
    choose_for_rock,
)
from jointclosure.effects.validation import (
    random_scene,
    validate,
    validation_settings,
    validation_summary,
)
from jointclosure.ensemble import closing
from jointclosure.ensemble.cases import cases_of
from jointclosure.ensemble.closing import close_surfaces, closed_before
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.surfaces import surfaces_of
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import scene_name
from jointclosure.plotting.effects import choice_figure
from tests.studied import ROOT, study_of

SPACING = 0.25e-3
DOLERITE = jc.Rock(78e9, 0.2, 165e6)
ELASTIC = jc.Effects(breakage=False, gouge=False)
SETTING = {"spacing": SPACING, "rock": DOLERITE, "cycles": 1}


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
            pairs, max_normal_stress=3e6, effects=ELASTIC, tolerance=tolerance, **SETTING
        )
        assert choice.effects.interaction is interaction
    assert actual <= choice.error < 2.0 * actual


def test_where_all_effects_act_the_pilot_has_closed_nothing_but_a_realisation_of_the_case():
    pairs = joints(32)
    choice = choose_effects(pairs, max_normal_stress=10e6, **SETTING | {"cycles": 2})
    assert choice.effects == jc.Effects()
    assert choice.trial_seconds == 0.0
    (closed,) = choice.closed
    again = jc.simulate(*pairs[0], max_normal_stress=10e6, **SETTING | {"cycles": 2})
    assert closed.dataset.max_closure.equals(again.max_closure)


def test_what_a_run_with_all_effects_shows_of_breakage_is_true_of_any_elastic_joint():
    told = SETTING | {"cycles": 2, "max_normal_stress": 3e6}
    for pair in joints(32, 2):
        full = jc.simulate(*pair, **told).max_closure.values
        shown = pilot(pair).shown(("breakage", "gouge"))
        # whatever an elastic joint closes by, it does so in both cycles
        for elastic in np.linspace(full.min(), full.max(), 50):
            assert 0.0 < shown <= np.abs(elastic / full - 1.0).max() + 1e-12
        without = jc.simulate(*pair, effects=ELASTIC, **told).max_closure.values
        assert shown <= np.abs(without / full - 1.0).max()


def test_where_the_cycles_differ_or_bulk_indentation_is_large_interaction_is_not_tried_without(
    monkeypatch,
):
    (pair,) = joints(32, 1)
    closed = pilot(pair)
    shown = closed.shown(("interaction",))
    full = closed.closed[0].dataset
    closures, bulk = full.max_closure.values, full.max_bulk_indentation.values
    differ = np.ptp(closures) / closures.sum()
    assert shown == pytest.approx(max((bulk / closures).max(), differ / 16.0))
    told = SETTING | {"cycles": 2, "max_normal_stress": 3e6, "tolerance": 1.9 * shown}
    assert choose_effects([pair], **told).trial_seconds == 0.0
    monkeypatch.setattr(scene_choice, "MARGIN", 1.0)
    assert choose_effects([pair], **told).trial_seconds > 0.0


def pilot(pair):
    conditions = Conditions(
        SPACING, DOLERITE, 3e6, 2, 0.0, jc.Effects(), jc.Choices(), jc.Numerics()
    )
    return scene_choice._Pilot([pair], conditions)


def test_the_cases_of_a_rock_share_a_decision_and_are_not_asked_after_a_proof():
    study = study_of(
        {"study": {"rocks": ["slate"], "realizations": 4, "pool": None}},
        {"grid": {"cells_x": 16, "cells_y": 16}, "effects": {"auto": 0.02}},
    )
    cases = {case.label: case for case in cases_of(study)}
    settings = {
        label: closure_settings(study, case, surface_settings(study, case, range(4)))
        for label, case in cases.items()
    }
    assert len(settings) > 5
    shared = choose_for_rock(settings)
    assert shared.effects == jc.Effects()
    assert list(shared.cases) == ["slate-base"]
    # where something may go, every case is asked
    lenient = {label: told._replace(effects_chosen_to=0.99) for label, told in settings.items()}
    everyone = choose_for_rock(lenient)
    assert everyone.effects != jc.Effects()
    assert set(everyone.cases) == set(settings)
    assert everyone.error == max(choice.error for choice in everyone.cases.values())


def test_what_a_pilot_closed_is_taken_bit_by_bit_and_not_closed_again(monkeypatch):
    study = study_of(
        {"study": {"rocks": ["slate"], "realizations": 3, "pool": None}},
        {"grid": {"cells_x": 16, "cells_y": 16}, "effects": {"auto": 0.02}},
    )
    case = cases_of(study)[0]
    settings = closure_settings(study, case, surface_settings(study, case, range(3)))
    pairs = xr.concat(surfaces_of(settings.surfaces), "realization")
    plain = xr.concat(close_surfaces(pairs, settings), "realization")
    choice = choose_for_case(settings)
    before = closed_before(surfaces_of(settings.surfaces), choice.closed, settings)
    closed = []
    close = closing.close_pair
    monkeypatch.setattr(closing, "close_pair", lambda *told: closed.append(1) or close(*told))
    taken = xr.concat(close_surfaces(pairs, settings, before=before), "realization")
    assert len(closed) == 2
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
    effects = read_plain(ROOT / "config/effects.yaml")
    return validation_settings(study_of(effects, {"ablation": {"validation": small}}))


def test_random_scenes_keep_to_their_ranges_and_do_not_depend_on_how_many_there_are(settings):
    scenes = [random_scene(settings, number) for number in range(50)]
    assert scenes == [random_scene(settings, number) for number in range(50)]
    assert len(set(scenes)) == 50
    for scene in scenes:
        assert 10e9 <= scene.rock.youngs_modulus <= 100e9
        assert scene.max_normal_stress <= scene.rock.compressive_strength
        assert 10 <= scene.cells <= 14


def test_a_choice_is_held_against_the_full_model(settings, monkeypatch):
    close, told = validation.close_walls, []
    monkeypatch.setattr(
        validation, "close_walls", lambda *given: told.append(given[2]) or close(*given)
    )
    table = validate(settings, 1)
    # each pair in full and as selected to each tolerance, all of it twice
    told = told[2:]  # those that load kernels
    assert [each.numerics.idle_interaction for each in told] == [0.0, 0.05, 0.9] * 4
    assert [each.effects for each in told[::3]] == [jc.Effects()] * 4
    assert table.tolerance.tolist() == [0.05, 0.9]
    assert (table.actual_percent > 0.0).any()
    assert (table.holds == (table.actual_percent <= 100.0 * table.tolerance)).all()
    left = (table.chosen_s + table.pilot_s) / table.full_s
    np.testing.assert_allclose(table.saved_percent, 100.0 * (1.0 - left))
    assert len(choice_figure(table).axes) >= len(table)


def test_the_summary_counts_what_held_and_what_was_saved():
    table = pd.DataFrame(
        {
            "tolerance": [0.1, 0.1, 0.1, 0.1],
            "chosen": [scene_name(jc.Effects())] * 2 + ["substrate"] * 2,
            "holds": [True, True, True, False],
            "actual_percent": [0.0, 0.0, 4.0, 12.0],
            "full_s": [10.0, 10.0, 10.0, 20.0],
            "chosen_s": [10.0, 11.0, 1.0, 2.0],
            "pilot_s": [1.0, 0.0, 1.0, 3.0],
            "saved_percent": [-10.0, -10.0, 80.0, 75.0],
        }
    )
    row = validation_summary(table).iloc[0]
    assert (row.scenes, row.changed) == (4, 2)
    assert row.held_percent == pytest.approx(75.0)
    assert row.held_of_changed_percent == pytest.approx(50.0)
    assert row.saved_percent == pytest.approx(100.0 * (1.0 - 29.0 / 50.0))
    assert row.saved_where_changed_percent == pytest.approx(100.0 * (1.0 - 7.0 / 30.0))
    assert row.saved_where_unchanged_percent == pytest.approx(-10.0)
    assert row.least_saved_percent == -10.0
    assert row.largest_pilot_percent == pytest.approx(10.0)
    assert row.timing_scatter_percent == pytest.approx(100.0 * 0.1 / 2.0**0.5)
    assert row.largest_error_percent == 12.0
