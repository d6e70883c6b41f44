"""Assessment of joints: differences between its variants, and the verdicts on them."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.assessment import assess as module
from jointclosure.assessment.assess import MOST_BREAKAGE_STEPS, assessed_variants
from jointclosure.assessment.assessed_results import ASSESSED, JUDGED, LIMITED, STIFFNESS
from jointclosure.assessment.assessment import Assessment, percent_of
from jointclosure.assessment.finest_error import log_error_of_finest
from jointclosure.assessment.hardness import FEATURES, HARD_CASES, nearest_hard_case
from jointclosure.assessment.verdicts import GIVEN_UP
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.joint.status import BREAKAGE_NOT_AT_REST
from jointclosure.statistics.number_texts import percent
from jointclosure.statistics.two_level import Interval
from jointclosure.storage.files import read_csv
from jointclosure.walls.gridding import Scan
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


@pytest.mark.parametrize(
    ("variant", "bias"), [("coarse", 0.1), ("middle", 0.02), ("without gouge", 0.0)]
)
def test_differences_are_those_that_were_put_in(variant, bias):
    assessment = Assessment(closures(), LADDER, "middle", 0.05)
    row = assessment.differences.set_index(["variant", "quantity"]).loc[(variant, JUDGED[0])]
    assert row.low < bias < row.high < bias + 0.03


@pytest.mark.parametrize(("effect", "verdict"), [(0.0, "can be left out"), (0.3, "needed")])
def test_verdicts_are_those_of_the_effects_that_were_put_in(effect, verdict):
    assessment = Assessment(closures(effect=effect), LADDER, "middle", 0.05)
    assert assessment.verdict("without gouge") == verdict


def test_a_needed_effect_has_the_results_that_make_it_needed():
    closed = closures()
    assert Assessment(closed, LADDER, "middle", 0.05).needed_by("without gouge") == ""
    closed.loc[closed.variant == "without gouge", "max_closure"] *= 1.3
    found = Assessment(pd.concat([closed, closed.assign(cycle=2)]), LADDER, "middle", 0.05)
    assert found.effects["needed by"]["without gouge"] == "gross closure (cycles 1, 2)"
    assert found.verdict("without gouge") == "needed"
    assert "gross closure (cycles 1, 2)" in str(found)


def test_the_verdict_on_a_joint_says_what_it_means():
    easy = Assessment(closures(scatter=1e-4), LADDER, "middle", 0.05)
    words = "is easy (net closures of its copies agree, its closure hardly jumps and its contacts"
    assert words in easy.sentences[-1]


def of_joint(within, apart=0.0, budget=None, **changes):
    """Assessment of a lone joint with two copies that are 2 x apart, by all settings."""
    closed = closures(joints=1, **{"scatter": 0.0, "middle": 0.01} | changes)
    mirrored = closed.copy_of_walls == "mirrored"
    closed.loc[mirrored, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    return Assessment(closed, LADDER, "fine", within, budget)


def least_limit(quantity, apart=0.0, change=0.01, jump=0.0):
    """Limit of the finest setting on copies that are 2 x apart, as a logarithm."""
    scatter = np.log((1.0 + apart) / (1.0 - apart)) / np.sqrt(2.0)
    return log_error_of_finest(scatter, np.log(1.0 + change), jump, quantity, 1)


def concluded(within=0.05, joints=1, budget=None, **changes):
    closed = closures(joints=joints, **{"scatter": 1e-4, "middle": 0.01} | changes)
    return str(Assessment(closed, LADDER, "fine", within, budget)).splitlines()[-1]


@pytest.mark.parametrize("joints", [1, 8])
def test_the_last_line_names_the_cheapest_setting_and_the_effects_that_are_needed(joints):
    said = concluded(within=0.1, joints=joints, effect=0.3)
    assert said.startswith("Conclusion: the cheapest setting ")
    words = "the errors of its net and gross closures are at most"
    if joints > 1:
        words = "its mean closures differ from those of fine by up to"
        assert "The error of fine itself is not known." in said
    assert f"meets the request of 10 % is middle; {words} " in said
    assert "Effects that must be kept: gouge." in said
    said = concluded(joints=joints, effect=0.0)
    assert said.endswith(" Effects that may be left out: gouge.")


def test_the_last_line_says_that_no_setting_meets_a_request():
    assert concluded(within=1e-5).startswith("Conclusion: no setting meets the request of 0.001 %.")
    unstable = concluded(oracle_ratio=2.0)
    assert unstable.startswith(
        "Conclusion: no setting meets the request of 5 %, because a joint is"
    )


def test_a_budget_buys_the_setting_with_the_least_limit():
    assert "most accurate setting that meets the budget of 2 s is middle" in concluded(budget=2.0)
    assert "most accurate setting that meets the budget of 20 s is fine" in concluded(budget=20.0)


@pytest.mark.parametrize("quantity", LIMITED)
def test_the_limit_of_the_finest_setting_is_that_of_its_copies_change_and_jump(quantity):
    found = of_joint(0.05, apart=0.02, largest_jump=0.03).limits
    limit = found.set_index(["variant", "quantity", "cycle"]).limit["fine", quantity, 1]
    assert limit == pytest.approx(np.expm1(least_limit(quantity, 0.02, jump=0.03)))


@pytest.mark.parametrize(("setting", "difference"), [("coarse", 0.1), ("middle", 0.01)])
def test_the_limit_of_a_setting_is_beyond_the_finest_by_its_farthest_copy(setting, difference):
    found = of_joint(0.05, apart=0.02).limits
    limits = found[found.quantity == JUDGED[0]].set_index("variant").limit
    farthest = np.log(1.0 + difference) + 0.5 * np.log(1.02 / 0.98)
    assert np.log1p(limits[setting]) - np.log1p(limits["fine"]) == pytest.approx(farthest)


def test_a_stated_setting_close_to_the_finest_one_does_not_judge_its_error():
    closed = closures(joints=1, scatter=0.0)
    between = closed[closed.variant == "middle"].assign(variant="stated")
    between[list(ASSESSED)] /= 1.02
    both = pd.concat([closed, between])
    usual = Assessment(closed, ["coarse", "tolerance 0.02", "fine"], "fine", 0.05)
    ladder = ["coarse", "tolerance 0.02", "stated", "fine"]
    renamed = {"middle": "tolerance 0.02"}
    usual.closures["variant"] = usual.closures.variant.replace(renamed)
    found = Assessment(both.replace({"variant": renamed}), ladder, "stated", 0.05)
    assert found.known_of_finest.equals(usual.known_of_finest)


def test_the_limit_of_closures_counts_and_that_of_stiffness_is_stated():
    closed = closures(joints=1, scatter=0.0, middle=0.001)
    closed.loc[closed.copy_of_walls == "mirrored", STIFFNESS] *= 1.2
    found = Assessment(closed, LADDER, "fine", 0.05)
    limits = found.limits[found.limits.variant == "middle"].groupby("quantity").limit.max()
    assert limits[STIFFNESS] > 0.2 > 0.05 > limits[list(JUDGED)].max()
    assert "meets the request of 5 % is middle" in found.conclusion
    words = percent(limits[STIFFNESS])
    assert f"those of its net stiffnesses at most {words} (" in found.conclusion
    assert found.price["limit of error, stiffness (%)"]["middle"] + " %" == words


def test_a_stiffness_that_is_not_known_has_no_limit():
    closed = closures(joints=1, scatter=0.0, middle=0.001)
    closed.loc[closed.copy_of_walls == "mirrored", STIFFNESS] = np.nan
    said = Assessment(closed, LADDER, "fine", 0.05).conclusion
    assert "middle; the errors of its net and gross closures are at most" in said
    assert "its net stiffnesses have no known limit" in said


def test_a_request_below_the_scatter_of_copies_is_said_to_be_impossible():
    said = of_joint(0.05, apart=0.05).sentences[1]
    limit = np.expm1(max(least_limit(name, 0.05) for name in JUDGED))
    assert said.startswith(
        "the request of 5 % cannot be met, as its copies, which should be equal, scatter more than "
        "that (the model does not determine the order of breakage): the least limit of the errors "
        f"of net and gross closures is {100 * limit:.2g} %, by fine; "
    )


def test_a_request_above_the_scatter_that_cannot_be_met_does_not_blame_it():
    said = of_joint(0.02, apart=0.01).sentences[1]
    assert said.startswith("the request of 2 % cannot be met: the least limit of the errors")
    assert "net and gross closures of its copies scatter by up to 1.4 %" in said


def test_a_scatter_of_gross_closure_alone_makes_a_request_impossible():
    closed = closures(joints=1, scatter=0.0)
    closed.loc[closed.copy_of_walls == "mirrored", "max_closure"] *= 1.1
    said = Assessment(closed, LADDER, "middle", 0.05).sentences[1]
    assert "cannot be met" in said


def test_a_joint_without_breakage_meets_the_request_by_its_only_setting():
    closed = closures(joints=1, scatter=0.0)
    closed = closed[closed.variant.isin(["fine", "without gouge"])]
    found = Assessment(closed, ["fine"], "fine", 0.05)
    assert found.limits.empty
    assert "a joint without breakage has no setting that limits its accuracy" in str(found)
    assert "setting that meets the request of 5 % is fine; its copies scatter by 0 %" in str(found)


def test_a_budget_that_buys_no_setting_says_the_least_time():
    said = of_joint(0.05, budget=0.5).sentences[1]
    assert said == "budget = 0.5 s: a joint takes at least 1 s"


def test_no_error_is_stated_if_the_finest_setting_failed():
    closed = closures(joints=1)
    closed.loc[closed.variant == "fine", list(ASSESSED)] = np.nan
    said = Assessment(closed, LADDER, "middle", 0.05).sentences[1]
    assert said == "no error can be stated, because copies failed with fine"


def test_the_observed_order_is_the_one_that_was_put_in():
    sharp = Assessment(closures(scatter=1e-4), LADDER, "middle", 0.05)
    assert "(observed order 0.85)" in sharp.sentences[0]  # ln(0.08 / 1.02 / 0.02) / ln 5


def test_changes_that_grow_have_no_observed_order():
    grown = Assessment(closures(scatter=1e-4, coarse=0.03), LADDER, "middle", 0.05)
    assert "(the change before, with coarse, was hardly larger or smaller)" in grown.sentences[0]


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


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"scatter": 1e-4}, "easy"),
        ({"scatter": 0.1}, "hard"),
        ({"scatter": 1e-4, "largest_jump": 0.06}, "hard"),
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
    assert "hard case" not in hardness.reason[0]  # `distance` has a scale only in its column
    assert hardness.unbreakable_share[0] == closed.unbreakable_share.max()  # what gave the verdict


def test_the_nearest_hard_case_of_a_hard_case_is_one_with_its_features():
    cases = read_csv(HARD_CASES).set_index("name")
    known = cases[[*FEATURES]]
    for name, features in known.iterrows():
        nearest, distance = nearest_hard_case(features)
        assert distance == 0.0
        assert nearest == name or known.loc[nearest].equals(features)
    assert nearest_hard_case(dict.fromkeys(FEATURES, np.nan))[0] == ""


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
    columns = ["seconds", "net closure 1 (%)", "net chord stiffness 1 (%)"]
    columns += ["limit of error, closures (%)", "limit of error, stiffness (%)"]
    assert list(first.price.columns) == columns


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


@pytest.mark.parametrize(("apart", "verdict"), [(0.14, "hard"), (0.15, "not stable")])
def test_a_joint_whose_copies_scatter_beyond_a_fifth_is_not_stable(apart, verdict):
    """Two copies that are 2 x apart have a standard deviation of x sqrt(2)."""
    closed = closures(scatter=0.0, joints=1)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == verdict
    assert ("not stable: more than 20 %" in hardness.reason[0]) == (verdict == "not stable")


def hardness_of_copies(apart, share):
    """Verdict on two copies that are 2 x apart: their standard deviation is x sqrt(2)."""
    closed = closures(scatter=0.0, joints=1, unbreakable_share=share)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    return Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0]


@pytest.mark.parametrize(("apart", "verdict"), [(0.017, "easy"), (0.018, "hard")])
def test_joints_are_easy_up_to_half_of_the_request(apart, verdict):
    """A deviation of 0.025 is the limit."""
    assert hardness_of_copies(apart, 0.1) == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.1, "easy"), (0.101, "hard")])
def test_joints_are_easy_up_to_a_tenth_of_force_that_cannot_break(share, verdict):
    assert hardness_of_copies(0.017, share) == verdict


@pytest.mark.parametrize(("jump", "verdict"), [(0.05, "easy"), (0.051, "hard")])
def test_joints_are_easy_up_to_a_jump_of_the_request(jump, verdict):
    closed = closures(scatter=1e-4, largest_jump=jump)
    assert Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0] == verdict


def test_an_effect_without_which_all_joints_fail_has_no_value():
    closed = closures()
    closed.loc[closed.variant == "without gouge", list(ASSESSED)] = np.nan
    shown = str(Assessment(closed, LADDER, "middle", 0.05))
    assert "no value" in shown
    assert "nan" not in shown


def test_a_scene_that_fails_without_an_effect_needs_it():
    closed = closures()
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "can be left out"
    closed.loc[closed.index[closed.variant == "without gouge"][0], "status"] = 16
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "needed: fails"
    wide = Assessment(closures(effect=0.05, scatter=0.05), LADDER, "middle", 0.05)
    assert wide.verdict("without gouge") == "not decided"


def test_an_effect_without_which_breakage_takes_too_long_is_not_tested():
    closed = closures()
    closed.loc[closed.index[closed.variant == "without gouge"][0], "status"] = BREAKAGE_NOT_AT_REST
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == GIVEN_UP


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


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((0.043787641576, 0.043787641572, 0.043787641579), "+4.4 (+4.4 to +4.4)"),
        ((0.043787, 0.0432, 0.0443), "+4.38 (+4.32 to +4.43)"),
        ((3e-7, 3e-7, 3e-7), "+3.0e-05 (+3.0e-05 to +3.0e-05)"),
    ],
)
def test_differences_of_equal_copies_have_few_digits(numbers, text):
    assert percent_of(Interval(*numbers)) == text
