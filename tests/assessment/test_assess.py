"""Assessments: plans by two levels cover the truth; variants, tables and what is kept."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.assessment import assess as module
from jointclosure.assessment.assess import ASSESSED, FEATURES, HARD_CASES, JUDGED, Assessment
from jointclosure.statistics.two_level import best_plan, t_interval, two_level_mean
from jointclosure.storage.files import read_csv
from tests.joints import DOLERITE, SPACING

LADDER = ["coarse", "middle", "fine"]
SCENE = {"rock": DOLERITE, "spacing": SPACING, "max_normal_stress": 5e6, "cycles": 1}


def closures(effect=0.0, coarse=0.1, middle=0.02, scatter=0.01, joints=10, **changes):
    """Closures of three settings and of a scene without an effect, with known differences."""
    random = np.random.default_rng(3)
    rows = []
    settings = {"coarse": coarse, "middle": middle, "fine": 0.0, "without gouge": middle + effect}
    for joint in range(joints):
        own = random.normal(1e-4, 2e-5)
        for copy in ("as it is", "mirrored"):
            for variant, bias in settings.items():
                if copy == "mirrored" and joints > 1 and variant != "middle":
                    continue
                value = own * (1.0 + bias + scatter * random.normal())
                row = {"variant": variant, "joint": joint, "copy_of_walls": copy, "cycle": 1}
                row |= {"status": 0, "seconds": 1.0 + 9.0 * (variant == "fine"), "error": ""}
                row |= {"oracle_ratio": 0.5} | dict.fromkeys(FEATURES[:-1], 0.0)
                rows.append(row | dict.fromkeys(ASSESSED, value))
    return pd.DataFrame(rows).assign(**changes)


def test_two_level_means_cover_the_truth_as_often_as_they_say():
    random = np.random.default_rng(1)
    truth, covered, runs = 2.0, 0, 2000
    for _ in range(runs):
        cheap = random.normal(truth + 0.5, 1.0, 30)
        # the difference goes with the closure in part
        differences = random.normal(-0.5, 0.3, 8) + 0.3 * (cheap[:8] - truth - 0.5)
        mean = two_level_mean(cheap, differences)
        covered += mean.low <= truth <= mean.high
    assert covered / runs == pytest.approx(0.95, abs=0.015)


def test_a_plan_reaches_its_half_width_and_a_budget_is_kept():
    deviations, seconds = (0.2, 0.05), (1.0, 11.0)
    plan = best_plan(deviations, seconds, 0.05)
    random = np.random.default_rng(2)
    samples = (random.normal(0.0, d, (4000, n)) for d, n in zip(deviations, plan[:2], strict=True))
    means = sum(sample.mean(axis=1) for sample in samples)
    assert np.quantile(np.abs(means), 0.95) == pytest.approx(plan.half_width, rel=0.12)
    cheaper = best_plan(deviations, seconds, 1.0, 0.7 * plan.seconds)
    assert plan.half_width <= 0.05 < cheaper.half_width
    assert best_plan(deviations, seconds, 1.0, 50.0) is None
    for more in (0.9, 0.7):  # no cheaper mix of both levels
        fewer = best_plan(deviations, seconds, 0.05, more * plan.seconds)
        assert fewer.half_width > 0.05


def test_differences_verdicts_and_limits_are_those_that_were_put_in():
    assessment = Assessment(closures(), LADDER, "middle", 0.05)
    table = assessment.differences.set_index(["variant", "quantity"])
    for variant, bias in (("coarse", 0.1), ("middle", 0.02), ("without gouge", 0.0)):
        row = table.loc[(variant, JUDGED[0])]
        assert row.low < bias < row.high < bias + 0.03
    assert assessment.verdict("without gouge") == "can be left out"
    other = Assessment(closures(effect=0.3), LADDER, "middle", 0.05)
    assert other.verdict("without gouge") == "needed"
    sharp = Assessment(closures(scatter=1e-4), LADDER, "middle", 0.05)
    assert "(observed order 0.85)" in sharp.sentences[0]  # ln(0.08 / 1.02 / 0.02) / ln 5


def test_coarser_numerics_have_larger_steps_and_tolerance_and_no_other_change():
    fine, rough = module.RESOLVED, module.coarser(module.RESOLVED, 2.0)
    scaled = {name: b / a for name, a, b in zip(fine._fields, fine, rough, strict=True) if a != b}
    steps = {name for name in fine._fields if name.endswith("_step")}
    assert scaled == dict.fromkeys(steps | {"tolerance"}, 2.0)


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"scatter": 1e-4}, "easy"),
        ({"scatter": 0.1}, "hard"),
        ({"scatter": 1e-4, "joints": 1, "unbreakable_share": [*[0.0] * 5, 0.2, 0.0, 0.0]}, "hard"),
        ({"scatter": 1e-4, "oracle_ratio": 1.5}, "not stable"),
        ({"scatter": 1e-4, "status": 16}, "not stable"),
        ({"scatter": 1e-4, "error": "refused", "status": np.nan}, "not stable"),
    ],
)
def test_hardness_has_its_defined_verdict(changes, verdict):
    closed = closures(**changes)
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == verdict
    assert hardness.unbreakable_share[0] == closed.unbreakable_share.max()  # what gave the verdict


def test_the_nearest_hard_case_of_a_hard_case_is_one_with_its_features():
    cases = read_csv(HARD_CASES).set_index("name")
    known = cases[[*FEATURES]]
    for name, features in known.iterrows():
        nearest, hard, distance = module.nearest_hard_case(features)
        assert distance == 0.0
        assert hard == cases.hard[nearest]
        assert nearest == name or known.loc[nearest].equals(features)
    assert module.nearest_hard_case(dict.fromkeys(FEATURES, np.nan))[0] == ""


def test_a_joint_is_assessed_on_its_copies_and_goes_on_where_it_was_interrupted(
    tmp_path, monkeypatch
):
    walls = jc.wall_pair(8.0, (8, 10), SPACING, seed=1, roll_off=None)
    first = jc.assess(walls, **SCENE, folder=tmp_path, workers=1)
    kept = (tmp_path / "closures.jsonl").read_text()
    with (tmp_path / "closures.jsonl").open("w") as file:
        file.write(kept[: int(0.6 * len(kept))])  # killed in a line
    closed = []
    close = module.close_joint
    monkeypatch.setattr(module, "close_joint", lambda *task: closed.append(task) or close(*task))
    again = jc.assess(walls, **SCENE, folder=tmp_path, workers=1)
    assert 0 < len(closed) < len(kept.splitlines())
    values = [part.closures[list(ASSESSED)].to_numpy() for part in (first, again)]
    np.testing.assert_array_equal(*values)
    assert set(first.closures.copy_of_walls) == set(module.COPIES)
    alone = jc.simulate(*walls, **SCENE, numerics=module.RESOLVED)
    own = first.closures.query("variant == 'tolerance 0.02' and copy_of_walls == 'as it is'")
    assert own.max_closure.iloc[0] == float(alone.max_closure[0])
    assert first.hardness.oracle_ratio[0] <= 1.0
    assert "without breakage and gouge" in str(first)
    columns = ["seconds", "net closure 1 (%)", "net stiffness 1 (%)"]
    assert list(first.price.columns) == columns


def test_elastic_joints_have_one_setting_and_the_effects_that_act():
    walls = [jc.wall_pair(8.0, (8, 8), SPACING, seed=seed) for seed in range(2)]
    elastic = jc.Effects(breakage=False, gouge=False)
    assessment = jc.assess(walls, **SCENE, effects=elastic, workers=1)
    assert list(assessment.price.index) == ["as stated"]
    assert set(assessment.effects.index) == {
        "without interaction", "without substrate and interaction", "without soft peaks"
    }  # fmt: skip
    assert t_interval(np.ones(3)).within(1.0)


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


@pytest.mark.parametrize(("apart", "verdict"), [(0.14, "hard"), (0.15, "not stable")])
def test_a_joint_whose_copies_scatter_beyond_a_fifth_is_not_stable(apart, verdict):
    """Two copies that are 2 x apart have a standard deviation of x sqrt(2)."""
    closed = closures(scatter=0.0, joints=1)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == verdict
    assert ("not stable: more than 20 %" in hardness.reason[0]) == (verdict == "not stable")


@pytest.mark.parametrize(
    ("apart", "share", "verdict"),
    [(0.017, 0.1, "easy"), (0.018, 0.1, "hard"), (0.017, 0.101, "hard")],
)
def test_joints_are_easy_up_to_half_of_the_request_and_a_tenth_of_force_that_cannot_break(
    apart, share, verdict
):
    """Two copies that are 2 x apart have a standard deviation of x sqrt(2): 0.025 is the limit."""
    closed = closures(scatter=0.0, joints=1, unbreakable_share=share)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    assert Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0] == verdict


def test_a_scene_that_fails_without_an_effect_needs_it():
    closed = closures()
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "can be left out"
    closed.loc[closed.index[closed.variant == "without gouge"][0], "status"] = 16
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "needed: fails"
    wide = Assessment(closures(effect=0.05, scatter=0.05), LADDER, "middle", 0.05)
    assert wide.verdict("without gouge") == "not decided"
