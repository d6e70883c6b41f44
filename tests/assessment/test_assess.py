"""Assessment of joints: its variants, their simulation, and what it refuses."""

import re

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.assessment import assess as module
from jointclosure.assessment.assess import (
    MOST_BREAKAGE_STEPS,
    assess_as_checked,
    assessed_variants,
    without_together,
)
from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.verdicts import CAN_BE_LEFT_OUT
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.walls.gridding import Scan
from tests.assessment.known_closures import closures
from tests.joints import DOLERITE, SPACING

SCENE = {"rock": DOLERITE, "spacing": SPACING, "max_normal_stress": 5e6, "cycles": 1}


@pytest.mark.parametrize(
    ("breakage", "acting"),
    [("resolved", {"tolerance"}), ("fixed_step", {"breakage_step", "later_breakage_step"})],
)
def test_coarser_numerics_change_nothing_but_steps_or_tolerance_that_act(breakage, acting):
    fine = module.RESOLVED._replace(breakage=breakage)
    rough = module.coarser(fine, 2.0)
    scaled = {name: b / a for name, a, b in zip(fine._fields, fine, rough, strict=True) if a != b}
    steps = {"displacement_step", "later_displacement_step"}
    assert scaled == dict.fromkeys(steps | acting, 2.0)


@pytest.fixture(scope="module")
def assessed(tmp_path_factory):
    """Walls, their assessment, and the file of its closures."""
    walls = jc.wall_pair(8.0, (8, 10), SPACING, seed=1, roll_off=None)
    folder = tmp_path_factory.mktemp("assessed")
    return walls, jc.assess(walls, **SCENE, folder=folder, workers=1), folder / "closures.jsonl"


def test_a_joint_is_assessed_on_its_copies(assessed):
    assert set(assessed[1].closures.copy_of_walls) == set(module.COPIES)


def test_an_assessment_goes_on_where_it_was_interrupted(assessed, tmp_path, monkeypatch):
    walls, first, file = assessed
    kept = file.read_text()
    (tmp_path / "closures.jsonl").write_text(kept[: int(0.6 * len(kept))])  # killed in a line
    closed = []
    close = module.simulate_row
    monkeypatch.setattr(module, "simulate_row", lambda *task: closed.append(task) or close(*task))
    again = jc.assess(walls, **SCENE, folder=tmp_path, workers=1)
    assert 0 < len(closed) < len(kept.splitlines())
    values = [part.closures[list(ASSESSED)].to_numpy() for part in (first, again)]
    np.testing.assert_array_equal(*values)


def test_an_assessed_joint_is_closed_as_by_the_library(assessed):
    walls, first, _ = assessed
    alone = jc.simulate(*walls, **SCENE, numerics=module.RESOLVED)
    own = first.closures.query("variant == 'tolerance 0.02' and copy_of_walls == 'as it is'")
    assert own.max_closure.iloc[0] == float(alone.max_closure[0])
    assert first.hardness.oracle_ratio[0] <= 1.0


def test_an_assessment_shows_its_variants_at_their_price(assessed):
    _, first, _ = assessed
    assert "without breakage and gouge" in str(first)
    columns = ["seconds", "limit of error, closures (%)", "limit of error, stiffness (%)"]
    columns += ["net closure 1 (%)", "gross closure 1 (%)", "net chord stiffness 1 (%)"]
    assert list(first.price.columns) == columns
    settings = ["the paper's steps", "tolerance 0.1", "tolerance 0.02", "tolerance 0.004"]
    assert list(first.price.index) == settings


def test_the_time_of_all_joints_is_forecast_from_that_of_the_first(monkeypatch):
    walls = jc.wall_pair(8.0, (8, 10), SPACING, seed=1, roll_off=None)
    conditions = Conditions(SPACING, DOLERITE, 5e6, cycles=1, numerics=RESOLVED).checked()
    monkeypatch.setattr(
        module, "simulate_row", lambda *_: {"status": 0, "timing_simulation": 100.0}
    )
    found = []
    asked = {"workers": 1, "forecast": lambda *of: found.append(of)}
    assess_as_checked([walls], conditions, **asked)
    ((count, seconds),) = found
    settings, dropped = (0.2 + 1.0 + 1.0 + 2.65), (1.0 + 0.012 + 0.7 + 1.0)
    assert count == 8 * len(module.COPIES) - 1
    # by the relative times of settings and effects, with the joint that is known taken away
    assert seconds == pytest.approx(100.0 * (len(module.COPIES) * (settings + dropped) - 1.0))


def test_effects_that_can_each_be_left_out_are_left_out_together_too():
    """With a wide request most groups of effects can be left out."""
    walls = jc.wall_pair(8.0, (8, 10), SPACING, seed=1, roll_off=None)
    found = jc.assess(walls, **SCENE, within=0.9, workers=1)
    alone = [n for n in found.effects.index if found.verdict(n) == CAN_BE_LEFT_OUT]
    conditions = Conditions(SPACING, DOLERITE, 5e6, cycles=1, numerics=RESOLVED).checked()
    together = without_together(found, conditions)
    (name,) = together
    left_out = [effect for effect, acts in together[name].effects._asdict().items() if not acts]
    assert len(alone) > 2
    assert name in found.effects.index
    every = {word for n in alone for word in re.split(", | and ", n.removeprefix("without "))}
    assert {effect.replace("_", " ") for effect in left_out} == every


def test_a_single_group_that_can_be_left_out_needs_no_further_variant():
    found = Assessment(closures(), ["coarse", "middle", "fine"], "middle", 0.05)
    conditions = Conditions(SPACING, DOLERITE, 5e6, numerics=RESOLVED).checked()
    assert found.verdict("without gouge") == CAN_BE_LEFT_OUT
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DROPS", (("gouge",),))
        assert without_together(found, conditions) == {}


@pytest.fixture(scope="module")
def elastic():
    walls = [jc.wall_pair(8.0, (8, 8), SPACING, seed=seed) for seed in range(2)]
    return jc.assess(walls, **SCENE, effects=jc.Effects(breakage=False, gouge=False), workers=1)


def test_elastic_joints_have_one_setting(elastic):
    assert list(elastic.price.index) == ["as stated"]


def test_elastic_joints_are_assessed_without_the_effects_that_act(elastic):
    assert set(elastic.effects.index) == {
        "without interaction", "without substrate and interaction", "without soft peaks"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"walls": np.zeros((8, 8))}, "walls: must be"),
        ({"walls": [(np.zeros((8, 8)),)]}, "walls: must be"),
        ({"within": 2.0}, "within = 2.0"),
        ({"folder": "nowhere"}, "folder = 'nowhere'"),
        ({"max_normal_stress": 1e12, "unusual_values": True}, "max_normal_stress"),
    ],
)
def test_bad_input_is_refused_before_a_joint_is_closed(changes, message):
    walls = changes.pop("walls", [(np.zeros((8, 8)),) * 2])
    with pytest.raises(jc.InputError, match=message):
        jc.assess(walls, **SCENE | changes)


def test_scans_and_their_grid_spacing_may_be_unusual_where_that_is_allowed():
    scans = [Scan(height * np.eye(9), (0.1e-3, 0.1e-3)) for height in (1e-4, 2e-4)]
    with pytest.raises(jc.InputError, match=r"^the fit of the walls is ambiguous"):
        jc.assess(scans, **SCENE | {"spacing": 0.2, "unusual_values": True})


def test_only_joints_without_an_effect_are_given_up_early():
    given = Conditions(SPACING, DOLERITE, 10e6, numerics=RESOLVED)
    _, ladder, variants = assessed_variants(given)
    for name, variant in variants.items():
        most = given.numerics.most_breakage_steps if name in ladder else MOST_BREAKAGE_STEPS
        assert variant.numerics.most_breakage_steps == most < 1e7


@pytest.mark.parametrize(
    ("tolerance", "names"),
    [
        (0.02, ["tolerance 0.1", "tolerance 0.02", "tolerance 0.004"]),
        (0.05, ["tolerance 0.1", "tolerance 0.05", "tolerance 0.02", "tolerance 0.004"]),
        (0.003, ["tolerance 0.075", "tolerance 0.015", "tolerance 0.003"]),
    ],
)
def test_a_stated_tolerance_takes_its_place_among_the_settings(tolerance, names):
    """Configurations begin with the paper's first step, and `RESOLVED` with a shorter one."""
    numerics = jc.Numerics(breakage="resolved", tolerance=tolerance)
    given = Conditions(SPACING, DOLERITE, 10e6, numerics=numerics)
    stated, ladder, variants = assessed_variants(given)
    assert ladder == ["the paper's steps", *names]
    assert stated == f"tolerance {tolerance:g}"
    assert variants[stated] == given
