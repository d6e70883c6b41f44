"""Readings of the paper: designs, closing, who is kept, and likelihoods in a known world."""

import itertools

import numpy as np
import pandas as pd
import pytest

from jointclosure.claims.findings import LOOP
from jointclosure.config.configuration import configured, merged
from jointclosure.config.files import read_plain
from jointclosure.ensemble.cases import cases_of
from jointclosure.ensemble.points import close_points
from jointclosure.ensemble.slices import block_settings
from jointclosure.experiments import checked_design, experiment_named
from jointclosure.experiments.readings.average import average_tables
from jointclosure.experiments.readings.design import (
    AS_CONFIGURED,
    CLOSURES,
    can_be_run,
    entering,
    readings_of,
)
from jointclosure.experiments.readings.likelihood import (
    Answer,
    answer_of,
    behind,
    implied_scatter,
    probability_of_table_3,
    published_lengths,
    ranking,
)
from jointclosure.experiments.readings.points import job_name
from jointclosure.experiments.readings.pools import on_cases, transferred
from jointclosure.experiments.readings.summary import claims_judged, over_rocks, quantities
from jointclosure.statistics.drawn_studies import Design
from jointclosure.statistics.verdicts import FALLS, STANDS, UNDECIDED
from jointclosure.storage.text import read_csv
from tests.experiments.readings_world import (
    ELASTICITIES,
    PARAMETERS,
    SCATTER,
    as_paper_table,
    closures,
    question,
    table_3,
    world,
)
from tests.studied import ROOT, checked_study

TINY = read_plain(ROOT / "tests/workflow/tiny_readings.yaml")
FULL = read_plain(ROOT / "config/readings.yaml")


def tiny(*changes):
    keys = checked_study(TINY, *changes).keys
    return readings_of(keys), keys


def settings_in(design, reading, rock, first=0):
    """Settings of all cases of a rock in a reading, for the block from a realisation on."""
    return [point.settings for point in design.jobs[f"{reading}.{rock}.{first}"]]


def test_every_reading_of_the_study_has_the_settings_of_its_keys():
    full = checked_study(FULL)
    design = checked_design("readings", full)
    readings = readings_of(full.keys)
    assert len(readings.singles) > 20
    for name, reading in readings.singles.items():
        typed = configured(
            merged(full.keys, reading.keys, {"study": {"rocks": ["slate"]}}), read_csv
        )
        cases = {case.label: case for case in cases_of(typed.typed)}
        assert len(cases) == 9
        expected = [block_settings(typed.typed, cases, label, range(6, 12)) for label in cases]
        assert repr(settings_in(design, reading.run, "slate", 6)) == repr(expected), name


def test_readings_with_the_same_keys_read_the_same_closures():
    design, _ = tiny()
    assert design.reading("seated").run == AS_CONFIGURED
    assert design.reading("seated").closure == "max_closure_seated"
    pair = design.reading("hurst_05-seated")
    assert (pair.run, pair.closure) == ("hurst_05", "max_closure_seated")
    assert design.reading("hurst_05").run == "hurst_05"


def test_pairs_are_of_two_aspects_and_have_the_keys_of_both():
    full = checked_study(FULL)
    assert "hurst_05-walk" not in readings_of(full.keys).pairs
    design = experiment_named("readings").design(full)
    pair = settings_in(design, "hurst_05-flat_valleys", "slate")[0]
    assert pair.surfaces.surface.hurst == 0.5
    assert pair.choices.concave == "flat"


def one_way(settings):
    return {"title": "a reading", "set": settings}


def test_a_pair_that_contradicts_itself_is_found_out():
    ways = {"resolved": {"breakage": "resolved"}, "passed": {"target": "interpolate"}}
    aspects = {name: {name: one_way({"numerics": way})} for name, way in ways.items()}
    design, keys = tiny({"readings": {"aspects": aspects}})
    assert not can_be_run(design, keys, "resolved-passed")
    assert can_be_run(design, keys, "hurst_05-passed")


ROUNDS = {
    "readings": {
        "rounds": [
            {"name": "screen", "candidates": "singles", "rocks": ["slate"]},
            {"name": "pairs", "candidates": "pairs", "rocks": ["slate"], "most": 2},
            {"name": "finalists", "candidates": "kept", "most": 2},
            {"name": "separation", "candidates": "kept"},
        ]
    }
}
for each in ROUNDS["readings"]["rounds"]:
    each |= {"realizations": 3, "margin": 2.0}


def judged(**kept):
    return pd.DataFrame({"reading": list(kept), "kept": list(kept.values())})


def test_a_round_is_entered_by_those_kept_the_best_first_and_by_their_pairs():
    design, keys = tiny(ROUNDS)
    assert entering(design, keys, 0, None) == list(design.singles)
    found = entering(design, keys, 1, judged(hurst_05=True, seated=True, walk=True))
    # two at most, of two aspects
    assert found == [AS_CONFIGURED, "hurst_05", "seated", "hurst_05-seated"]
    found = entering(design, keys, 2, judged(seated=True, walk=True))
    assert found == [AS_CONFIGURED, "seated", "walk"]


def test_nobody_enters_a_round_where_one_reading_is_left_and_nothing_new_is_asked():
    design, keys = tiny(ROUNDS)
    # all rocks for the first time: worth it
    assert entering(design, keys, 2, judged(walk=True, seated=False)) == [AS_CONFIGURED, "walk"]
    assert entering(design, keys, 3, judged(walk=True, seated=False)) == []
    assert entering(design, keys, 3, judged()) == []


def test_a_reading_that_is_clearly_behind_is_dropped_and_one_within_its_error_is_kept():
    shared = np.linspace(-3.0, 3.0, 6)  # surfaces move all readings alike
    jitter = 0.1 * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    answers = {
        "worse": Answer(-25.0, -25.0 + shared + jitter),
        "best": Answer(-20.0, -20.0 + shared),
        "near": Answer(-20.1, -20.1 + shared - jitter),
    }
    table = ranking(answers, margin=2.0)
    assert table.reading.tolist() == ["best", "near", "worse"]
    assert table.kept.tolist() == [True, True, False]
    # five behind, of which the error is far less than that of either
    assert table.behind.iloc[2] == pytest.approx(5.0)
    assert table.behind_error.iloc[2] < 0.1 * answers["worse"].standard_error


def test_the_true_reading_is_ranked_first_and_its_table_is_no_rarity():
    asked = question(table_3(seed=3, scatter=0.5))
    reference = world(60)
    readings = {name: world(60, scatter=s) for name, s in (("half", 0.5), ("double", 2.0))}
    readings[AS_CONFIGURED] = reference
    answers = {name: answer_of(asked, each, reference) for name, each in readings.items()}
    assert next(iter(ranking(answers, 2.0).reading)) == "half"
    assert behind(answers["half"], answers["double"]).value > 5.0
    half, double = (
        probability_of_table_3(asked, readings[name], reference) for name in ("half", "double")
    )
    assert half.value > 0.05 > double.value
    assert half.standard_error > np.sqrt(half.value * (1.0 - half.value) / asked.repetitions)


def test_an_average_has_the_weights_and_the_claims_of_the_readings_that_explain_the_table():
    asked = question(table_3(seed=3, scatter=0.5), repetitions=200, groups=4)
    truths = {"true": {"scatter": 0.5}, "near": {"scatter": 0.55}, "turned": {"factor": -1.0}}
    tables = average_tables(list(truths), [world(48, **of) for of in truths.values()], asked)
    of_reading = tables["readings_average"].set_index("title")
    for name in of_reading.columns[::2]:
        assert of_reading[name].sum() == pytest.approx(1.0), name
        assert of_reading.loc["turned", name] < 0.3, name
    assert of_reading.weight["turned"] < 0.01 < of_reading.weight["near"]
    tests = tables["readings_average_tests"]
    assert tests.tested.tolist() == ["all", "all", "cycle 1", "cycle 2", "slate", "limestone"]
    assert (tests.p_error > 0.0).all()
    assert (tests.p > 0.05 - 2.0 * tests.p_error).all()
    claims = tables["readings_average_claims"].set_index("number")
    assert claims.verdict["2a"] == claims.verdict["5b"] == STANDS
    assert claims.verdict["2b"] == FALLS
    assert claims.weight_true["5a"] > 0.99
    equal = [world(48, factor=factor) for factor in (1.0, -1.0)]
    undecided = average_tables(["a", "b"], equal, question(table_3(seed=3, factor=0.0)))
    of_claim = undecided["readings_average_claims"].set_index("number").loc["5a"]
    assert of_claim.verdict == UNDECIDED
    assert of_claim.share_of_reading > 0.8


def test_one_reading_makes_no_average():
    tables = average_tables(["a"], [world(6)], question(table_3(seed=3)))
    assert all(table.empty for table in tables.values())


def test_elasticities_too_tell_readings_apart():
    asked = question(table_3(seed=5))
    answers = {
        name: answer_of(asked, world(60, factor=factor), world(60))
        for name, factor in (("true", 1.0), ("insensitive", 0.3))
    }
    assert behind(answers["true"], answers["insensitive"]).value > 5.0


def test_a_reading_of_one_rock_is_carried_to_the_others():
    reference = world(12)
    changed = {"slate": closures("slate", 6, scatter=0.5, factor=0.6)}
    carried = transferred(changed, reference, PARAMETERS)
    truth = world(12, scatter=0.5, factor=0.6)
    for rock in PARAMETERS:
        # their means are wrong by the noise that the other rock's surfaces have
        for of, tolerance in (("mean", 0.06), ("std", 0.1)):
            found, true = (getattr(each[rock], of)("realization") for each in (carried, truth))
            np.testing.assert_allclose(found, true, rtol=tolerance)
    # unchanged, it is the reference
    same = transferred({"slate": closures("slate", 6)}, reference, PARAMETERS)
    np.testing.assert_allclose(same["limestone"], reference["limestone"], rtol=1e-12)


def test_the_error_covers_what_other_surfaces_would_have_given():
    asked = question(table_3(seed=3), repetitions=100)
    found = [
        answer_of(asked, *(2 * [{rock: closures(rock, 24, first=i) for rock in PARAMETERS}]))
        for i in range(0, 192, 24)
    ]
    spread = np.std([each.log_likelihood for each in found], ddof=1)
    printed = np.mean([each.standard_error for each in found])
    assert 0.5 * spread < printed < 3.0 * spread


def test_table_3_implies_the_scatter_it_was_drawn_with():
    asked = question(table_3(seed=3, scatter=0.5))
    found = implied_scatter(asked, world(24), world(24), np.linspace(0.2, 1.4, 13))
    assert [each.cycle for each in found] == [1, 2]
    for each in found:
        assert each.low <= 0.5 <= each.high
        assert each.low <= each.factor <= each.high < 1.0


def test_published_lengths_are_in_si_and_a_rock_that_is_not_in_them_is_refused():
    published = table_3(seed=1)
    again = published_lengths(as_paper_table(published), PARAMETERS)
    assert again.keys() == published.keys()
    for key, length in published.items():
        assert again[key] == pytest.approx(length, nan_ok=True)
    with pytest.raises(ValueError, match=r"rocks.marl: jrc is not in the paper's Table 3"):
        published_lengths(as_paper_table(published), {"marl": {"jrc": ((1.0, 2.0, 3.0), 2.0)}})


def test_scatter_and_elasticities_are_those_of_the_world():
    table = over_rocks(pd.DataFrame(quantities(world(60), PARAMETERS)))
    for row in table.itertuples():
        true = ELASTICITIES.get(row.quantity, SCATTER)[row.cycle - 1]
        assert abs(row.value - true) < 4.0 * row.standard_error + 0.02
        assert 0.0 <= row.standard_error < 0.1


def test_claims_that_are_true_of_the_world_stand_and_others_fall():
    verdicts = claims_judged(world(60), PARAMETERS, 10, Design())
    for claim in ("1a, cycle 1", "2a", "2c", "3, cycle 2", "4", "5a", "5b", "5c"):
        assert verdicts[claim] == STANDS, claim
    assert verdicts["2b"] == FALLS  # JRC rules the world's first cycle
    assert verdicts["3, cycle 1"] == FALLS
    assert verdicts["6a"] == FALLS  # no loop on the second cycle
    # 5 % of strength change the second closure by 3 %, of which 6 % are significant
    assert verdicts["1b"] == verdicts["3c"] == FALLS
    turned = claims_judged(world(60, factor=-1.0), PARAMETERS, 10, Design())
    assert turned["5a"] == turned["5b"] == turned["5c"] == FALLS
    part = {rock: {"jrc": each["jrc"]} for rock, each in PARAMETERS.items()}
    assert set(claims_judged(world(12), part, 4, Design()).values()) == {UNDECIDED}
    # one that the paper does not vary takes no verdict away, and gives none
    more = {rock: each | {"grain_size": each["jrc"]} for rock, each in PARAMETERS.items()}
    verdicts, expected = (claims_judged(world(12), of, 4, Design()) for of in (more, PARAMETERS))
    assert verdicts == expected


def test_the_estimate_counts_each_surface_once_and_each_pair_anew():
    study = checked_study(TINY, ROUNDS, {"readings": {"reference_realizations": 6}})
    timed = experiment_named("readings").design(study).timed()
    assert {name: sum(each.joints for each in parts) for name, parts in timed.items()} == {
        "as configured": 9 * 6 * 2,
        "screen": 2 * 9 * 3,  # seated reads what is closed anyway
        "pairs": 1 * 9 * 3,
        "finalists": 2 * 9 * 3,  # dolerite; slate was closed before
        "separation": 0,
    }
    runs = [[point.coordinates["run"] for point in each.points] for each in timed["screen"]]
    assert runs == [["hurst_05"], ["walk"]]


def test_jobs_of_a_round_are_those_of_its_entrants_and_of_the_configured_reading():
    study = checked_study(TINY, ROUNDS, {"readings": {"reference_realizations": 6}})
    rounds = experiment_named("readings").design(study).rounds
    reference = {job_name(AS_CONFIGURED, *of) for of in itertools.product(
        ("slate", "dolerite"), (range(3), range(3, 6)))}  # fmt: skip
    # one of the entrants reads the closures of the configured reading
    assert set(rounds.jobs(0, ["walk", "seated"])) == reference | {"walk.slate.0"}
    assert set(rounds.jobs(2, ["walk"])) == reference | {"walk.slate.0", "walk.dolerite.0"}
    assert rounds.jobs(2, []) == []


def test_kernels_are_those_of_readings_and_of_pairs_that_can_be_run():
    ways = {"resolved": {"breakage": "resolved"}, "passed": {"target": "interpolate"}}
    aspects = {name: {name: one_way({"numerics": way})} for name, way in ways.items()}
    aspects["peaks"] = {"current": one_way({"choices": {"peaks": "current"}})}
    design = experiment_named("readings").design(
        checked_study(TINY, {"readings": {"aspects": aspects}})
    )
    found = {(peaks, breakage) for _, peaks, _, breakage in design.kernels()}
    assert found == set(itertools.product(("pristine", "current"), ("fixed_step", "resolved")))


def test_points_are_all_cases_of_a_rock_and_a_failed_surface_leaves_all_cases():
    elastic = {"effects": {"breakage": False, "gouge": False}}
    study = checked_study(TINY, {"grid": {"cells_x": 8, "cells_y": 8}}, elastic)
    jobs = experiment_named("readings").design(study).jobs
    assert len(jobs["walk.slate.3"]) == 9
    other, block = (
        close_points(jobs[f"walk.slate.{first}"], (*CLOSURES.values(), LOOP)) for first in (0, 3)
    )
    closed = on_cases(block, "closure")
    assert dict(closed.sizes) == {"case": 9, "realization": 3, "cycle": 2}
    assert closed.realization.values.tolist() == [3, 4, 5]
    assert set(closed.parameter.values) == {"base", *PARAMETERS["slate"]}
    stiffer = closed[(closed.value == 72e9).values]
    assert np.all(stiffer.values < closed[0].values)
    assert np.all(block.closure_net < block.closure)
    assert np.all(closed.loop == 0.0)  # nothing breaks
    other.loc[(other.value == 72e9) & (other.realization == 1), "closure"] = np.nan
    both = pd.concat([other, block], ignore_index=True)
    kept = on_cases(both, "closure")
    assert kept.realization.values.tolist() == [0, 2, 3, 4, 5]
    np.testing.assert_array_equal(kept.values[:, 2:], closed.values)
