"""Effects chosen by a pilot: what matters stays, what does not goes, and the error is known."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.config.files import read_plain
from jointclosure.inputs import InputError
from jointclosure.parameters import scene_name
from jointclosure.plotting.effects import choice_figure
from jointclosure.studies.effects import choice as scene_choice
from jointclosure.studies.effects.choice import choose_effects
from jointclosure.studies.effects.design import validation_settings
from jointclosure.studies.effects.validation import (
    random_scene,
    validate,
    validation_summary,
)
from tests.studied import ROOT, study_of

SPACING = 0.25e-3
DOLERITE = jc.Rock(78e9, 0.2, 165e6)
ELASTIC = jc.Effects(breakage=False, gouge=False)
SETTING = {"spacing": SPACING, "rock": DOLERITE, "cycles": 1}


def joints(cells, count=4, jrc=8.0):
    return [jc.wall_pair(jrc, (cells, cells), SPACING, seed) for seed in range(count)]


def mean_closure(pairs, effects, stress):
    closed = [jc.simulate(*p, max_normal_stress=stress, effects=effects, **SETTING) for p in pairs]
    return np.mean([float(each.max_closure[0]) for each in closed])


def test_where_everything_matters_everything_acts_and_it_says_so():
    lines = []
    choice = choose_effects(
        joints(32), max_normal_stress=10e6, tolerance=0.02, report=lines.append, **SETTING
    )
    assert choice.effects == jc.Effects()
    assert choice.error == 0.0
    assert lines[-1] == "every effect matters: all act"
    assert any("without breakage and gouge" in reason and "kept" in reason for reason in lines)


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
    # the pieces are the whole walls here, so the estimate lacks nothing but its margin
    assert actual <= choice.error < 2.0 * actual


def test_the_bulk_indentation_of_the_whole_joint_counts_not_that_of_the_piece(monkeypatch):
    pairs = joints(48)
    whole = 1.0 - mean_closure(pairs, ELASTIC._replace(interaction=False), 5e6) / mean_closure(
        pairs, ELASTIC, 5e6
    )
    monkeypatch.setattr(scene_choice, "PILOT_CELLS", 12)
    choice = choose_effects(pairs, max_normal_stress=5e6, effects=ELASTIC, tolerance=0.9, **SETTING)
    assert not choice.effects.interaction
    monkeypatch.setattr(scene_choice._Pilot, "_bulk_missed", lambda self, count: 0.0)
    naive = choose_effects(pairs, max_normal_stress=5e6, effects=ELASTIC, tolerance=0.9, **SETTING)
    assert choice.error > naive.error
    assert choice.error >= whole


def test_effects_that_are_not_allowed_are_not_brought_in():
    choice = choose_effects(
        joints(12), max_normal_stress=5e6, effects=ELASTIC, tolerance=0.9, **SETTING
    )
    assert not choice.effects.breakage
    assert not choice.effects.gouge


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"tolerance = 1\.5"):
        choose_effects(joints(8), max_normal_stress=1e6, tolerance=1.5, **SETTING)
    with pytest.raises(InputError, match="1 pairs"):
        choose_effects(joints(8, 1), max_normal_stress=1e6, **SETTING)


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


def test_a_choice_is_held_against_the_full_model(settings):
    table = validate(settings, 1)
    assert table.tolerance.tolist() == [0.05, 0.9]
    everything = table.chosen == scene_name(jc.Effects())
    assert (table.actual_percent[everything] == 0.0).all()
    assert (table.holds == (table.actual_percent <= 100.0 * table.tolerance)).all()
    figure = choice_figure(table)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert texts == ["tolerance 5 %", "tolerance 90 %"]


def test_the_summary_counts_what_held_and_what_was_saved():
    table = pd.DataFrame(
        {
            "tolerance": [0.1, 0.1, 0.1],
            "chosen": [scene_name(jc.Effects()), "substrate", "substrate"],
            "holds": [True, True, False],
            "actual_percent": [0.0, 4.0, 12.0],
            "full_s": [10.0, 10.0, 20.0],
            "chosen_s": [10.0, 1.0, 2.0],
            "pilot_s": [1.0, 1.0, 1.0],
        }
    )
    row = validation_summary(table).iloc[0]
    assert (row.scenes, row.changed) == (3, 2)
    assert row.held_percent == pytest.approx(200.0 / 3.0)
    assert row.held_of_changed_percent == pytest.approx(50.0)
    assert row.saved_percent == pytest.approx(100.0 * (1.0 - 16.0 / 40.0))
    assert row.saved_where_changed_percent == pytest.approx(100.0 * (1.0 - 5.0 / 30.0))
    assert row.largest_error_percent == 12.0
