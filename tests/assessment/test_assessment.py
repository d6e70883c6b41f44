"""Results of an assessment: differences, limits of errors, and the conclusion."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.assessment.assessed_results import ASSESSED, JUDGED, LIMITED, STIFFNESS
from jointclosure.assessment.assessment import Assessment, percent_of
from jointclosure.assessment.finest_error import log_error_of_finest
from jointclosure.statistics.number_texts import percent
from jointclosure.statistics.two_level import Interval
from tests.assessment.known_closures import LADDER, closures


@pytest.mark.parametrize(
    ("variant", "bias"), [("coarse", 0.1), ("middle", 0.02), ("without gouge", 0.0)]
)
def test_differences_are_those_that_were_put_in(variant, bias):
    assessment = Assessment(closures(), LADDER, "middle", 0.05)
    row = assessment.differences.set_index(["variant", "quantity"]).loc[(variant, JUDGED[0])]
    assert row.low < bias < row.high < bias + 0.03


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
    words = "limits of the error are"
    if joints > 1:
        words = "its mean closures differ from those of fine by up to"
        assert "The error of fine itself is not known." in said
    assert f"meets the request of 10 % is middle; {words} " in said
    assert "Effects that must be kept: gouge." in said
    said = concluded(joints=joints, effect=0.0)
    assert said.endswith(" Effects that may be left out, each of these groups alone: gouge.")


def test_the_last_line_says_that_no_setting_meets_a_request():
    said = concluded(within=1e-5)
    assert said.startswith("Conclusion: no setting is shown to meet the request of 0.001 %; the ")
    said = concluded(budget=0.1)
    assert "no setting meets the budget of 0.1 s, as a joint takes at least 1 s" in said
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
    assert f"for net and gross closures, and {words} for net stiffnesses (" in found.conclusion
    assert found.price["limit of error, stiffness (%)"]["middle"] + " %" == words


def test_a_stiffness_that_is_not_known_has_no_limit():
    closed = closures(joints=1, scatter=0.0, middle=0.001)
    closed.loc[closed.copy_of_walls == "mirrored", STIFFNESS] = np.nan
    said = Assessment(closed, LADDER, "fine", 0.05).conclusion
    assert "middle; limits of the error are " in said
    assert "and none is known for net stiffnesses (" in said


def test_a_request_below_the_scatter_of_copies_says_that_they_cause_it():
    said = of_joint(0.05, apart=0.05).conclusion
    limit = percent(np.expm1(max(least_limit(name, 0.05) for name in JUDGED)))
    assert said.startswith(
        "Conclusion: no setting is shown to meet the request of 5 %; the least limit has fine: "
        f"limits of the error are {limit} for net and gross closures, and "
    )
    assert "its copies, which should be equal, scatter more than the request, because the" in said


def test_a_request_above_the_scatter_that_is_not_met_names_a_finer_tolerance():
    said = of_joint(0.02, apart=0.01).conclusion
    assert said.startswith("Conclusion: no setting is shown to meet the request of 2 %; the least")
    assert "a stated tolerance below that of the finest setting may have a smaller limit" in said
    assert "copies scatter by up to 1.4 %" in of_joint(0.02, apart=0.01).sentences[1]


def test_a_scatter_of_gross_closure_alone_makes_a_request_impossible():
    closed = closures(joints=1, scatter=0.0)
    closed.loc[closed.copy_of_walls == "mirrored", "max_closure"] *= 1.1
    said = Assessment(closed, LADDER, "middle", 0.05).conclusion
    assert "scatter more than the request" in said


def test_copies_that_agree_do_not_converge_within_a_request_that_the_limit_exceeds():
    found = of_joint(0.02, largest_jump=0.2)
    assert "+1 %: whether it converges within the request is not shown" in found.sentences[0]
    assert "it converges within the request" in of_joint(0.1).sentences[0]


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
    assert "(from coarse to middle it changes hardly more, or less)" in grown.sentences[0]


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((0.043787641576, 0.043787641572, 0.043787641579), "+4.4"),
        ((0.043787, 0.0432, 0.0443), "+4.38 (+4.32 to +4.43)"),
        ((3e-7, 3e-7, 3e-7), "0.00"),
    ],
)
def test_differences_of_equal_copies_have_no_interval(numbers, text):
    assert percent_of(Interval(*numbers)) == text


def test_the_time_of_a_joint_has_the_shortest_and_the_longest_of_its_copies():
    closed = closures(joints=1)
    closed.loc[closed.copy_of_walls == "mirrored", "seconds"] *= 3.0
    assert Assessment(closed, LADDER, "fine", 0.05).price.seconds["coarse"] == "2 (1 to 3)"


def test_tables_in_text_fit_a_screen():
    closed = pd.concat([closures(), closures().assign(cycle=2)])
    names = [f"without {name}" for name in ("breakage and gouge", "interaction", "soft peaks")]
    gouge = closed[closed.variant == "without gouge"]
    closed = pd.concat([closed, *(gouge.assign(variant=name) for name in names)])
    text = str(Assessment(closed, LADDER, "fine", 0.05))
    _, *tables, _, _ = text.split("\n\n")
    assert len(tables) > 1
    assert max(len(line) for table in tables for line in table.splitlines()) <= 120
