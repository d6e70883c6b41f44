"""Table 3 of a study in a world whose truth is known."""

import numpy as np
import pytest

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.number_texts import ABSENT, percent
from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.cases import (
    cases_of,
    ensembles_of,
    pool_of,
    wall_name,
)
from studies.frame.keys import Accuracy
from studies.frame.yaml_files import PAPER_TABLE_3
from studies.paper import closure_tables
from studies.paper.accuracy import reached_table
from studies.paper.claims import TARGET
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.predictive import (
    Predictive,
    joint_table,
    lengths_dataset,
    maximum_closures,
    predictive,
    predictive_table,
)
from studies.paper.report.page_tables import predicted
from studies.paper.responses import responses
from tests.studied import study_of
from tests.world import ELASTICITIES, world

PAPER = read_csv(PAPER_TABLE_3)
ONE = {"study": {"rocks": ["dolerite"], "pool": 40}, "statistics": {"bootstrap_resamples": 20}}
COMMON = {"study": {"draws": "common", "pool": None}}


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


def indifference_of(*changes):
    return closure_tables.indifference_table(
        world(study_of(ONE, *changes)), study_of(ONE).statistics, 1
    )


def test_independent_draws_have_the_published_test():
    independent = indifference_of()
    assert set(independent.test) == {"unpaired"}
    np.testing.assert_array_equal(independent.length, independent.unpaired_length)


def test_common_draws_have_the_paired_test():
    common = indifference_of(COMMON)
    assert set(common.test) == {"paired"}
    strong = common[common.parameter != "poisson_ratio"]
    # on the same surfaces the paired test tells the ends apart in all rows, the unpaired does not
    assert (strong.p_of_ends < 1e-6).all()
    assert (strong.unpaired_p_of_ends > 0.05).any()
    assert (strong.length < 0.3 * strong.unpaired_length.fillna(np.inf)).all()
    for row, response in zip(
        common.itertuples(), responses(world(study_of(ONE, COMMON)), TARGET), strict=True
    ):
        linear = response.interval(0.05).linear_length / PROPERTIES[row.parameter].size
        assert row.linear_length == pytest.approx(linear)


@pytest.fixture(scope="module")
def many_levels():
    """A world with seven levels of Young's modulus on common surfaces."""
    levels = {"levels": {"youngs_modulus_GPa": [70, 74, 76, 80, 82, 85]}}
    return world(study_of(ONE, {"rocks": {"dolerite": levels}}, COMMON))


def test_more_than_three_levels_have_both_tests(many_levels):
    table = closure_tables.indifference_table(many_levels, study_of(ONE).statistics, 1)
    one = table[(table.parameter == "youngs_modulus") & (table.cycle == 2)].iloc[0]
    assert np.isfinite([one.length, one.unpaired_length]).all()


def test_a_kink_is_a_lack_of_fit(many_levels):
    p = (
        closure_tables.correlation_table(many_levels)
        .set_index(["parameter", "cycle"])
        .lack_of_fit_p
    )
    assert np.isnan(p["jrc", 2])
    kinked = many_levels.copy(deep=True)
    kinked["max_closure"][(many_levels.youngs_modulus > 80e9).values] *= 1.03
    worse = closure_tables.correlation_table(kinked).set_index(["parameter", "cycle"]).lack_of_fit_p
    assert worse["youngs_modulus", 2] < 1e-6 < p["youngs_modulus", 2]


def test_elasticities_are_the_worlds_within_their_errors(pool):
    table = closure_tables.elasticity_table(pool)
    assert table.paired.all()
    truth = [ELASTICITIES[row.cycle][row.parameter] for row in table.itertuples()]
    # a parabola through three levels of a power is off by some thousandths of it
    error = np.hypot(table.elasticity_standard_error, 0.03 * np.abs(truth))
    assert (np.abs(table.elasticity - truth) < 3.5 * error).all()
    np.testing.assert_allclose(table.elasticity_net, table.elasticity, rtol=1e-9)
    assert " ± " in table.elasticity_shown[0]


def test_the_elasticity_of_the_stiffness_is_that_of_its_harmonic_mean(pool):
    stiff = pool.assign(stiffness_net=1e6 / pool.max_closure)
    table = closure_tables.elasticity_table(stiff)
    np.testing.assert_allclose(table.elasticity_stiffness, -table.elasticity, rtol=1e-9)
    error = "_standard_error"
    np.testing.assert_allclose(table[f"elasticity_stiffness{error}"], table[f"elasticity{error}"])


def test_net_closure_since_seating_has_its_own_elasticity(pool):
    since = pool.max_closure_seated_net * (pool.youngs_modulus / 78e9) ** 0.5
    shifted = closure_tables.elasticity_table(pool.assign(max_closure_seated_net=since))
    rows = shifted[shifted.parameter == "youngs_modulus"]
    np.testing.assert_allclose(rows.elasticity_seated_net, rows.elasticity + 0.5, atol=0.01)


def test_a_joint_without_stiffness_is_left_out_of_its_elasticity_alone(pool):
    stiffness = (1e6 / pool.max_closure).where(pool.realization != 3)
    table = closure_tables.elasticity_table(pool.assign(stiffness_net=stiffness))
    assert set(table.samples_stiffness) == {39}
    assert set(table.samples) == {40}
    assert np.isfinite(table.elasticity_stiffness_standard_error).all()


def test_a_dataset_without_stiffness_has_no_elasticity_of_it(pool):
    table = closure_tables.elasticity_table(pool)
    assert table.elasticity_stiffness.isna().all()
    assert set(table.elasticity_stiffness_shown) == {ABSENT}


def test_the_predictive_table_has_the_papers_entries_with_their_probabilities(pool):
    found = predictive(pool, Design(), 400, 1, pools=20)
    table = predictive_table(found, PAPER).set_index(["parameter", "cycle"])
    assert len(table) == 8
    strong = table.loc["youngs_modulus", 2]
    weak = table.loc["poisson_ratio", 1]
    assert strong.low_95 < strong.low_90 < strong["median"] < strong.high_90 < strong.high_95
    assert strong["median"] == pytest.approx(3.7, rel=0.3)  # GPa
    assert strong.null_p < 0.01 < strong.p
    assert weak.null_p > 0.1
    assert 0.02 < weak.share_without_root < 0.3
    errors = table[["median_error", "median_pool_error", "p_error", "null_p_error"]]
    assert (errors > 0.0).all(axis=None)
    joint = joint_table(found, PAPER).set_index("entries")
    assert joint.number[["all", "cycle 1 without JRC"]].tolist() == [8, 3]
    assert joint.null_p["all"] < 0.01 < joint.p["all"]
    # the pool's surfaces make more of an error than 400 repetitions
    p = joint.p["cycle 2"]
    assert joint.p_error["cycle 2"] > 1.5 * np.sqrt(p * (1.0 - p) / 400)
    once = joint_table(predictive(pool, Design(), 400, 1, pools=0), PAPER).set_index("entries")
    np.testing.assert_allclose(once.p, joint.p)
    np.testing.assert_allclose(once.p_error, np.sqrt(once.p * (1.0 - once.p) / 400))
    assert dict(lengths_dataset(found).sizes) == {"entry": 8, "repetition": 400}


def test_lengths_of_zero_have_their_shares(pool):
    """They come from studies of two surfaces of a pool of three, often the same one twice."""
    few = pool.isel(realization=slice(3))
    found = predictive(few, Design(2), 200, 1, pools=0)
    table = predictive_table(found, PAPER).set_index(["parameter", "cycle"])
    for key, entry in {key[1:]: key for key in found.bases}.items():
        assert table.share_zero[key] == np.mean(found.model[0][entry] == 0.0)
        assert table.null_share_zero[key] == np.mean(found.null[0][entry] == 0.0)
    assert (table.share_zero > 0.1).all()
    assert (table.share_zero + table.share_without_root < 1.0).all()
    assert joint_table(found, PAPER).p.isna().all()
    shown = predicted(table.reset_index())
    assert shown.zero[0] == percent(table.share_zero.iloc[0])
    assert set(predicted(table.reset_index().drop(columns="share_zero")).zero) == {"–"}


def test_a_study_that_varies_nothing_has_empty_tables(tmp_path):
    none = dict.fromkeys(("poisson_ratio", "youngs_modulus_GPa", "compressive_strength_MPa", "jrc"))
    study = world(study_of(ONE, {"rocks": {"dolerite": {"levels": none}}}))
    found = predictive(study, Design(), 100, 1)
    write_csv(predictive_table(found, PAPER), tmp_path / "entries.csv")
    write_netcdf(lengths_dataset(found), tmp_path / "lengths.nc")
    assert read_csv(tmp_path / "entries.csv").empty
    assert read_netcdf(tmp_path / "lengths.nc").sizes["entry"] == 0
    assert joint_table(found, PAPER).empty
    assert closure_tables.elasticity_table(study).empty
    table, _ = judge_claims(Evidence(study, study, Design(), 100, 1), PAPER)
    assert table.number.tolist() == ["6a", "6b"]
    assert set(table.verdict) == {"stands"}


ENTRY = ("dolerite", "youngs_modulus", 1)


def made_up(*sets, twice=(), same=()):
    """Repetitions of one entry: lengths [Pa] of the pool and of resampled pools."""
    given, more, again = ([{ENTRY: lengths} for lengths in x] for x in (sets, twice, same))
    return Predictive(given, given, {ENTRY: 78e9}, {"dolerite": 40}, more, again)


def entry_of(*sets):
    return predictive_table(made_up(*sets), PAPER).iloc[0]


def test_without_resampled_pools_errors_are_those_of_the_repetitions_alone():
    lengths = 1e9 * np.random.default_rng(1).lognormal(1.0, 0.5, 400)
    lengths[:40] = np.inf
    row = entry_of(lengths)
    assert row.share_error == pytest.approx(np.sqrt(0.1 * 0.9 / 400))
    assert row.p_error == pytest.approx(2.0 * np.sqrt(0.5 * row.p * (1.0 - 0.5 * row.p) / 400))
    assert row.null_p_error == pytest.approx(np.sqrt(row.null_p * (1.0 - row.null_p) / 400))
    assert np.isnan(row.median_pool_error)


@pytest.fixture
def lengths():
    return 1e9 * np.random.default_rng(1).lognormal(1.0, 0.5, 400)


def test_the_error_of_a_median_by_the_pool_is_the_deviation_over_pools(lengths):
    row = entry_of(lengths, *(factor * lengths for factor in (0.8, 1.0, 1.2)))
    assert row.median_pool_error == pytest.approx(0.2 * row["median"])


def test_a_median_by_the_pool_has_no_error_if_one_pool_lacks_a_root(lengths):
    endless = np.where(np.arange(400) < 300, np.inf, lengths)
    assert np.isnan(entry_of(lengths, lengths, endless).median_pool_error)
    assert entry_of(endless).median_error == np.inf


def test_a_closure_without_scatter_has_no_test_of_its_entries():
    lengths = 1e9 * np.random.default_rng(1).lognormal(1.0, 0.5, 400)
    lengths[7] = 0.0
    joint = joint_table(made_up(lengths, same=[lengths[:200], lengths[:200]] * 2), PAPER)
    assert joint[["log_likelihood", "p", "p_error"]].isna().all(axis=None)


def test_the_error_of_p_by_the_repetitions_is_the_deviation_over_sets_of_as_many():
    random = np.random.default_rng(1)
    first, *others = 1e9 * random.lognormal(1.0, 0.5, (3, 400))
    parts = [half for other in others for half in np.split(other, 2)]
    p = [joint_table(made_up(lengths), PAPER).p[0] for lengths in (first, *others)]
    table = joint_table(made_up(first, same=parts), PAPER)
    assert table.p[0] == p[0]
    assert table.p_error[0] == pytest.approx(np.std(p, ddof=1))


def test_a_rock_whose_poisson_ratio_is_zero_has_lengths_and_no_percentages():
    none = dict.fromkeys(("youngs_modulus_GPa", "compressive_strength_MPa", "jrc"))
    cork = {"poisson_ratio": 0.0, "levels": none | {"poisson_ratio": [0.1, 0.2]}}
    configuration = study_of(ONE, {"rocks": {"dolerite": cork}})
    flat = {cycle: {} for cycle in (1, 2)}  # closures by no power of 0
    closed = world(configuration, flat)
    table = closure_tables.indifference_table(closed, configuration.statistics, 1)
    assert np.isfinite(table.unpaired_length).any()
    assert table[["percent", "percent_net", "unpaired_percent"]].isna().all(axis=None)
    found = predictive(world(pool_of(configuration), flat), Design(), 200, 1, pools=2)
    entries = predictive_table(found, PAPER)
    assert np.isfinite(entries["median"]).all()
    assert entries.median_percent.isna().all()
    assert np.isnan(lengths_dataset(found).percent).all()
    finest = closed.isel(realization=slice(9))
    accuracy = reached_table(closed, finest, Accuracy(within=0.5, of="interval"), 0.05)
    assert accuracy.value.isna().all()
    assert closure_tables.elasticity_table(closed).elasticity.isna().all()


def test_a_rock_of_which_one_joint_closed_or_all_by_nothing_has_a_mean_and_no_scatter():
    closed = world(study_of(ONE))
    lone = closed.copy(deep=True)
    lone.status[:, 1:] = 16
    table = closure_tables.max_closure_table(lone)
    assert (table.samples == 1).all()
    name = "max_closure_mean_mm"
    np.testing.assert_allclose(table[name][:2], 1e3 * closed.max_closure.values[0, 0])
    assert table[[f"{name}_standard_error", "variation"]].isna().all(axis=None)
    assert closure_tables.correlation_table(lone).empty
    assert (
        closure_tables.indifference_table(lone, study_of(ONE).statistics, 1).status
        == "too few successful realisations"
    ).all()
    assert maximum_closures(lone) == []
    lone.status[:, 1] = 0
    assert len(maximum_closures(lone)) == 1
    common = world(study_of(ONE, COMMON)).isel(realization=slice(1))
    change = closure_tables.max_closure_table(common)[["max_closure_change_mm_standard_error"]]
    assert change.isna().all(axis=None)
    none = closure_tables.max_closure_table(closed.assign(max_closure=0.0 * closed.max_closure))
    assert (none[name] == 0.0).all()
    assert none.variation.isna().all()
