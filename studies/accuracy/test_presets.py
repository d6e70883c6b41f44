"""Numerics by a word, or by the accuracy wanted: taken from what was measured, or refused."""

import json

import pandas as pd
import pytest

from jointclosure.inputs import InputError
from jointclosure.parameters import Numerics
from jointclosure.storage.text import read_csv
from studies.accuracy.cost import setting_table
from studies.accuracy.design import design_of
from studies.frame.config.configuration import configured
from studies.frame.config.files import MEASURED, read_plain
from studies.frame.config.presets import SCENES, chosen_numerics, numerics_in_full
from tests.studied import DEFAULT, ROOT, checked_study, keys_of, study_of

SCENE = SCENES[20.0]


def row(preset, error, pairs, **numerics):
    return {
        "scene": SCENE,
        "preset": preset,
        "knob": "some",
        "value": 1.0,
        "error_percent": error,
        "bound_percent": 2.0 * error,
        "relative_time": 1e-3 * pairs,
        "pairs": pairs,
        "seconds": 1.0,
        "numerics": json.dumps(numerics),
    }


TABLE = pd.DataFrame(
    [
        row("paper", 20.0, 1000.0),
        row("", 1.9, 1500.0, breakage="resolved", tolerance=0.05),
        row("accurate", 1.0, 1200.0, breakage="resolved", tolerance=0.02),
        row("converged", 0.3, 9000.0, breakage="resolved", tolerance=0.005),
    ]
)


def chosen(table=TABLE, radius=20.0, effects=None, **numerics):
    choices = {"largest_radius_mm": radius}
    keys = keys_of({"numerics": numerics, "choices": choices}, effects or {})
    return chosen_numerics(keys, DEFAULT["numerics"], lambda: table)


def test_a_preset_stands_for_its_numerics_and_is_kept_in_the_configuration():
    found = chosen(preset="converged")
    assert found.numerics == DEFAULT["numerics"] | {
        "preset": "converged",
        "breakage": "resolved",
        "tolerance": 0.005,
    }
    assert "0.3 % (95 % confidence: up to 0.6 %)" in found.remark
    assert "preset" not in numerics_in_full({"numerics": found.numerics})


@pytest.mark.parametrize(
    ("accuracy", "tolerance"), [(0.02, 0.02), (0.019, 0.005), (0.006, 0.005), (0.5, None)]
)
def test_the_cheapest_setting_whose_bound_is_within_an_accuracy_is_taken(accuracy, tolerance):
    found = chosen(accuracy=accuracy).numerics
    assert found["breakage"] == ("resolved" if tolerance else "fixed_step")
    assert tolerance is None or found["tolerance"] == tolerance


def test_where_nothing_breaks_there_is_nothing_to_choose():
    elastic = {"effects": {"breakage": False, "gouge": False}}
    found = chosen(accuracy=0.02, radius=None, effects=elastic)
    assert numerics_in_full({"numerics": found.numerics}) == DEFAULT["numerics"]
    assert "1e-10" in found.remark


def test_words_are_settled_in_an_order_that_lets_them_stand_together():
    both = keys_of({"numerics": {"accuracy": 0.02}, "choices": {"largest_radius_mm": 20.0}})
    found = configured(both | {"effects": "auto"}, lambda path: TABLE)
    assert found.typed.effects_chosen_to == 0.02
    chosen = Numerics(breakage="resolved", tolerance=0.02, curve_points=60, idle_interaction=0.02)
    assert found.typed.numerics == chosen
    assert "1 %" in found.remark


def test_it_is_the_rocks_own_effects_that_break_or_not():
    elastic, breaking = ({"breakage": on, "gouge": on} for on in (False, True))
    own = {name: {"effects": elastic} for name in DEFAULT["study"]["rocks"]}
    assert "1e-10" in chosen(accuracy=0.02, radius=None, effects={"rocks": own}).remark
    own = {"effects": elastic, "rocks": {"slate": {"effects": breaking}}}
    with pytest.raises(InputError, match="does not converge"):
        chosen(accuracy=0.02, radius=None, effects=own)
    assert "1 %" in chosen(accuracy=0.02, effects=own).remark


@pytest.mark.parametrize(
    ("stated", "printed"),
    [
        ({"preset": "best"}, "numerics.preset = 'best': must be one of paper, accurate, converged"),
        ({"preset": "paper", "accuracy": 0.1}, "only one of them"),
        ({"accuracy": 0.001}, "must be at least 0.006"),
        ({"accuracy": 0.1, "radius": 10.0}, "largest_radius_mm = 10.0: must be one of null, 20"),
        ({"preset": "accurate", "tolerance": 0.07}, "numerics.tolerance = 0.07: must be left out"),
    ],
)
def test_what_cannot_be_chosen_is_refused(stated, printed):
    with pytest.raises(InputError) as error:
        chosen(**stated)
    assert printed in str(error.value)


def test_the_committed_table_has_every_preset_of_the_study_and_they_can_be_run():
    study = read_plain(ROOT / "studies/accuracy/accuracy.yaml")
    settings, runs = design_of(checked_study(study).keys)
    turned = {(each.scene, each.knob, each.value): runs[each.run] for each in settings}
    bounded = {"choices": {"largest_radius_mm": 20.0}}
    for name, point in study["accuracy"]["presets"].items():
        like = turned[SCENE, point["knob"], point["value"]].levels[0]
        assert study_of(bounded, {"numerics": {"preset": name}}).numerics == like.numerics
    paper = chosen(read_csv(MEASURED), preset="paper").numerics
    assert paper == DEFAULT["numerics"] | {"preset": "paper"}


def test_settings_are_judged_by_their_worst_rock_and_cycle_and_the_finest_by_another_integrator():
    study = {
        "study": {"rocks": ["dolerite", "slate"]},
        "accuracy": {
            "parameter": "youngs_modulus",
            "resamples": 10,
            "confidence": 0.9,
            "scenes": {
                SCENE: {
                    "finest": {"knob": "steps", "value": 0.5},
                    "cross": {"knob": "resolved", "value": 0.01},
                }
            },
            "presets": {"paper": {"knob": "base", "value": ""}},
            "knobs": {
                "steps": {
                    "scenes": [SCENE],
                    "scale": ["numerics.breakage_step_um"],
                    "values": [0.5],
                },
                "resolved": {
                    "scenes": [SCENE],
                    "set": {"numerics": {"breakage": "resolved"}},
                    "key": "numerics.tolerance",
                    "values": [0.01],
                },
                "spacing": {
                    "scenes": [SCENE],
                    "values": [{"value": "fine", "set": {"grid": {"spacing_mm": 0.125}}}],
                },
            },
        },
    }
    keys = checked_study(study).keys
    settings, _ = design_of(keys)
    errors = {"base": -8.0, "steps": 0.0, "resolved": 1.5, "spacing": 99.0}
    costs = pd.DataFrame(
        {
            "scene": SCENE,
            "rock": each.rock,
            "cycle": 1,
            "knob": each.knob,
            "value": each.value,
            "mean_error_percent": errors[each.knob] * (1.0 if each.rock == "slate" else 0.5),
            "mean_low": errors[each.knob] - 1.0,
            "mean_high": errors[each.knob] + 1.0,
            "relative_time": 2.0,
            "pairs": 10.0 if each.rock == "slate" else 20.0,
            "seconds": 1.0,
        }
        for each in settings
    )
    design = keys["accuracy"]
    table = setting_table(costs, settings, design["scenes"], design["presets"]).set_index("knob")
    assert table.index.tolist() == ["base", "steps", "resolved"]
    assert table.loc["base", "preset"] == "paper"
    # -8 and -4 %, each +-1 %: errors of two rocks do not cancel
    assert table.loc["base", "error_percent"] == 8.0
    assert table.loc["base", "bound_percent"] == 9.0
    # the finest is what all are held against; its bound is that of the other integrator
    assert table.loc["steps", "error_percent"] == 0.0
    assert table.loc["steps", "bound_percent"] == 2.5
    assert table.loc["steps", "pairs"] == 15.0
    assert json.loads(table.loc["steps", "numerics"]) == {"breakage_step_um": 2.5}
    assert json.loads(table.loc["base", "numerics"]) == {}
