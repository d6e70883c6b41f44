"""Table 3 of a study in a world whose truth is known: its test, its distribution, its errors."""

import numpy as np
import pytest

from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.cases import cases_of, ensembles_of, pool_of, wall_name
from studies.frame.files import PAPER_TABLE_3
from studies.paper.closures import (
    correlation_table,
    elasticity_table,
    indifference_table,
)
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.planning import GOALS, Goal, plan, power_of_ends
from studies.paper.predictive import joint_table, lengths_dataset, predictive, predictive_table
from studies.paper.responses import responses
from tests.studied import study_of
from tests.world import ELASTICITIES, world

PAPER = read_csv(PAPER_TABLE_3)
ONE = {"study": {"rocks": ["dolerite"], "pool": 40}, "statistics": {"bootstrap_resamples": 20}}
COMMON = {"study": {"draws": "common", "pool": None}}
OTHERS = dict.fromkeys(("poisson_ratio", "youngs_modulus_GPa", "jrc"))
STRENGTH_ALONE = {"rocks": {"dolerite": {"levels": OTHERS}}}


@pytest.fixture(scope="module")
def pool():
    return world(pool_of(study_of(ONE)))


def test_the_pool_has_common_surfaces_that_no_study_has():
    configuration = study_of(ONE)
    pool = ensembles_of(configuration)["pool"]
    assert pool.study.realizations == 40
    own = {tuple(wall_name(configuration.study, case)) for case in cases_of(configuration)}
    shared = {tuple(wall_name(pool.study, case)) for case in cases_of(pool)}
    assert len(own) == 9  # independent draws: each case its own
    assert len(shared) == 1  # one noise for all cases of the rock
    assert not own & shared
    common = study_of(ONE, COMMON)
    assert {tuple(wall_name(common.study, case)) for case in cases_of(common)} != shared
    assert list(ensembles_of(common)) == ["cases"]


def test_independent_draws_have_the_published_test_and_common_ones_the_paired():
    statistics = study_of(ONE).statistics
    independent = indifference_table(world(study_of(ONE)), statistics, 1)
    common = indifference_table(world(study_of(ONE, COMMON)), statistics, 1)
    assert set(independent.test) == {"unpaired"}
    np.testing.assert_array_equal(independent.length, independent.unpaired_length)
    assert set(common.test) == {"paired"}
    strong = common[common.parameter != "poisson_ratio"]
    # on the same surfaces the paired test tells the ends apart in all rows, the unpaired does not
    assert (strong.p_of_ends < 1e-6).all()
    assert (strong.unpaired_p_of_ends > 0.05).any()
    assert (strong.length < 0.3 * strong.unpaired_length.fillna(np.inf)).all()


@pytest.mark.parametrize("draws", [{}, COMMON])
def test_more_than_three_levels_have_both_tests_and_a_kink_is_a_lack_of_fit(draws):
    levels = {"levels": {"youngs_modulus_GPa": [70, 74, 76, 80, 82, 85]}}
    dataset = world(study_of(ONE, {"rocks": {"dolerite": levels}}, draws))
    table = indifference_table(dataset, study_of(ONE).statistics, 1)
    one = table[(table.parameter == "youngs_modulus") & (table.cycle == 2)].iloc[0]
    assert np.isfinite([one.length, one.unpaired_length]).all()
    p = correlation_table(dataset).set_index(["parameter", "cycle"]).lack_of_fit_p
    assert 0.0 <= p["youngs_modulus", 2] <= 1.0
    assert np.isnan(p["jrc", 2])
    kinked = dataset.copy(deep=True)
    kinked["max_closure"][(dataset.youngs_modulus > 80e9).values] *= 1.03
    worse = correlation_table(kinked).set_index(["parameter", "cycle"]).lack_of_fit_p
    if draws:  # independent surfaces scatter too much to show it
        assert worse["youngs_modulus", 2] < 1e-6 < p["youngs_modulus", 2]


def test_elasticities_are_the_worlds_within_their_errors(pool):
    table = elasticity_table(pool)
    assert table.paired.all()
    truth = [ELASTICITIES[row.cycle][row.parameter] for row in table.itertuples()]
    # a parabola through three levels of a power is off by some thousandths of it
    error = np.hypot(table.elasticity_standard_error, 0.03 * np.abs(truth))
    assert (np.abs(table.elasticity - truth) < 3.5 * error).all()
    np.testing.assert_allclose(table.elasticity_net, table.elasticity, rtol=1e-9)
    assert " ± " in table.elasticity_shown[0]


def test_the_predictive_table_has_the_papers_entries_with_their_probabilities(pool):
    found = predictive(pool, Design(), 400, 1)
    table = predictive_table(found, PAPER).set_index(["parameter", "cycle"])
    assert len(table) == 8
    strong, weak = table.loc["youngs_modulus", 2], table.loc["poisson_ratio", 1]
    assert strong.low_95 < strong.low_90 < strong["median"] < strong.high_90 < strong.high_95
    assert strong["median"] == pytest.approx(3.7, rel=0.3)  # GPa
    assert strong.null_p < 0.01 < strong.p
    assert weak.null_p > 0.1
    assert 0.02 < weak.share_without_root < 0.3
    errors = table[["median_error", "median_pool_error", "p_error", "null_p_error"]]
    assert (errors > 0.0).all(axis=None)
    joint = joint_table(found, PAPER).set_index("entries")
    assert (joint.number["all"], joint.number["cycle 1 without JRC"]) == (8, 3)
    assert joint.null_p["all"] < 0.01 < joint.p["all"]
    # the pool's surfaces make more of an error than 400 repetitions
    p = joint.p["cycle 2"]
    assert joint.p_error["cycle 2"] > 1.5 * np.sqrt(p * (1.0 - p) / 400)
    once = joint_table(predictive(pool, Design(), 400, 1, pools=0), PAPER).set_index("entries")
    np.testing.assert_allclose(once.p, joint.p)
    np.testing.assert_allclose(once.p_error, np.sqrt(once.p * (1.0 - once.p) / 400))
    assert dict(lengths_dataset(found).sizes) == {"entry": 8, "repetition": 400}


@pytest.mark.parametrize("paired", [False, True])
def test_a_plan_of_power_is_met_by_studies_of_its_size(paired):
    # one planned from a large pool, then done many times
    wish, parameter, cycle = Goal("power", 0.8), "compressive_strength", 1
    stated = {"irregular": 0.1} if paired else {}
    draws = COMMON if paired else {}
    pool = world(pool_of(study_of(ONE, STRENGTH_ALONE, {"study": {"pool": 200}})), **stated)
    table = plan(pool, wish, paired=paired).set_index(["parameter", "cycle"])
    n = int(table.surfaces[parameter, cycle])
    significant = []
    for number in range(40):
        size = {"study": {"name": f"done_{number}", "realizations": n}}
        study = world(study_of(ONE, STRENGTH_ALONE, size, draws), **stated)
        row = indifference_table(study, study_of(ONE).statistics, 1)
        row = row[(row.parameter == parameter) & (row.cycle == cycle)].iloc[0]
        significant.append(row.p_of_ends < 0.05)
    assert abs(np.mean(significant) - 0.8) < 0.17
    assert table.core_minutes[parameter, cycle] == pytest.approx(3 * n * 1.5 / 60.0)


def test_a_plan_says_how_far_its_number_is_known(pool):
    """About two thirds of other pools plan a number within the range that is told."""
    wish, parameter = Goal("standard-error", 0.01), "jrc"
    table = plan(pool, wish).set_index(["parameter", "cycle"])
    assert (table.low_68 <= table.surfaces * 1.05).all()
    assert (table.high_68 >= table.surfaces * 0.95).all()
    # n goes as the variance of 40 normal samples, which is known to sqrt(2/39)
    width = (table.high_68 - table.low_68) / table.surfaces / 2.0
    assert abs(width[parameter, 1] - np.sqrt(2.0 / 39.0)) < 0.1


def test_a_study_that_varies_nothing_has_empty_tables(tmp_path):
    none = dict.fromkeys(("poisson_ratio", "youngs_modulus_GPa", "compressive_strength_MPa", "jrc"))
    study = world(study_of(ONE, {"rocks": {"dolerite": {"levels": none}}}))
    found = predictive(study, Design(), 100, 1)
    write_csv(predictive_table(found, PAPER), tmp_path / "entries.csv")
    write_netcdf(lengths_dataset(found), tmp_path / "lengths.nc")
    assert read_csv(tmp_path / "entries.csv").empty
    assert read_netcdf(tmp_path / "lengths.nc").sizes["entry"] == 0
    assert joint_table(found, PAPER).empty
    assert elasticity_table(study).empty
    assert plan(study, Goal("power", 0.8)).empty
    table, _ = judge_claims(Evidence(study, study, Design(), 100, 1), PAPER)
    assert table.number.tolist() == ["6a", "6b"]
    assert set(table.verdict) == {"stands"}


def test_more_surfaces_are_needed_for_more(pool):
    amounts = {"length": (4, 8), "width": (0.2, 0.4), "standard-error": (0.01, 0.02),
               "elasticity-error": (0.02, 0.04), "power": (0.95, 0.5)}  # fmt: skip
    assert set(amounts) == set(GOALS)
    few = pool.isel(case=np.isin(pool.parameter, ["base", "jrc"]))
    for kind, (more, less) in amounts.items():
        strict, loose = (plan(few, Goal(kind, amount)).surfaces for amount in (more, less))
        assert (strict >= loose).all()
        assert (strict > loose).any()
    errors = plan(few, Goal("standard-error", 0.01)).surfaces
    np.testing.assert_allclose(errors / plan(few, Goal("standard-error", 0.02)).surfaces, 4, 0.1)
    response = next(responses(pool, "max_closure"))
    assert power_of_ends(response._replace(samples=response.samples * 0 + 1), 10, 0.05) == 1.0
