"""Table 3 of a study in a world whose truth is known: its test, its distribution, its errors."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.assessment.assess import FINEST
from jointclosure.inputs import InputError
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.repetitions import Design
from jointclosure.statistics.two_level import t_interval
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.cases import (
    block_settings,
    blocks_of,
    cases_of,
    closed_keys,
    ensembles_of,
    pool_of,
    wall_name,
)
from studies.frame.keys import Accuracy
from studies.frame.yaml_files import PAPER_TABLE_3
from studies.paper import closures
from studies.paper.accuracy import (
    START,
    Counts,
    _log_length,
    next_counts,
    reached_table,
    start_counts,
)
from studies.paper.claims import TARGET
from studies.paper.closures import best_fits, fit_table
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.predictive import (
    Predictive,
    joint_table,
    lengths_dataset,
    maximum_closures,
    predictive,
    predictive_table,
)
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


def test_independent_draws_have_the_published_test_and_common_ones_the_paired():
    statistics = study_of(ONE).statistics
    independent = closures.indifference_table(world(study_of(ONE)), statistics, 1)
    common = closures.indifference_table(world(study_of(ONE, COMMON)), statistics, 1)
    assert set(independent.test) == {"unpaired"}
    np.testing.assert_array_equal(independent.length, independent.unpaired_length)
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


def test_more_than_three_levels_have_both_tests_and_a_kink_is_a_lack_of_fit():
    levels = {"levels": {"youngs_modulus_GPa": [70, 74, 76, 80, 82, 85]}}
    dataset = world(study_of(ONE, {"rocks": {"dolerite": levels}}, COMMON))
    table = closures.indifference_table(dataset, study_of(ONE).statistics, 1)
    one = table[(table.parameter == "youngs_modulus") & (table.cycle == 2)].iloc[0]
    assert np.isfinite([one.length, one.unpaired_length]).all()
    p = closures.correlation_table(dataset).set_index(["parameter", "cycle"]).lack_of_fit_p
    assert np.isnan(p["jrc", 2])
    kinked = dataset.copy(deep=True)
    kinked["max_closure"][(dataset.youngs_modulus > 80e9).values] *= 1.03
    worse = closures.correlation_table(kinked).set_index(["parameter", "cycle"]).lack_of_fit_p
    assert worse["youngs_modulus", 2] < 1e-6 < p["youngs_modulus", 2]


def test_elasticities_are_the_worlds_within_their_errors(pool):
    table = closures.elasticity_table(pool)
    assert table.paired.all()
    truth = [ELASTICITIES[row.cycle][row.parameter] for row in table.itertuples()]
    # a parabola through three levels of a power is off by some thousandths of it
    error = np.hypot(table.elasticity_standard_error, 0.03 * np.abs(truth))
    assert (np.abs(table.elasticity - truth) < 3.5 * error).all()
    np.testing.assert_allclose(table.elasticity_net, table.elasticity, rtol=1e-9)
    assert " ± " in table.elasticity_shown[0]


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


def test_the_error_of_a_median_by_the_pool_is_the_deviation_over_pools_and_none_if_one_has_none():
    lengths = 1e9 * np.random.default_rng(1).lognormal(1.0, 0.5, 400)
    row = entry_of(lengths, *(factor * lengths for factor in (0.8, 1.0, 1.2)))
    assert row.median_pool_error == pytest.approx(0.2 * row["median"])
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


def test_a_study_that_varies_nothing_has_empty_tables(tmp_path):
    none = dict.fromkeys(("poisson_ratio", "youngs_modulus_GPa", "compressive_strength_MPa", "jrc"))
    study = world(study_of(ONE, {"rocks": {"dolerite": {"levels": none}}}))
    found = predictive(study, Design(), 100, 1)
    write_csv(predictive_table(found, PAPER), tmp_path / "entries.csv")
    write_netcdf(lengths_dataset(found), tmp_path / "lengths.nc")
    assert read_csv(tmp_path / "entries.csv").empty
    assert read_netcdf(tmp_path / "lengths.nc").sizes["entry"] == 0
    assert joint_table(found, PAPER).empty
    assert closures.elasticity_table(study).empty
    table, _ = judge_claims(Evidence(study, study, Design(), 100, 1), PAPER)
    assert table.number.tolist() == ["6a", "6b"]
    assert set(table.verdict) == {"stands"}


def test_a_rock_whose_poisson_ratio_is_zero_has_lengths_and_no_percentages():
    none = dict.fromkeys(("youngs_modulus_GPa", "compressive_strength_MPa", "jrc"))
    cork = {"poisson_ratio": 0.0, "levels": none | {"poisson_ratio": [0.1, 0.2]}}
    configuration = study_of(ONE, {"rocks": {"dolerite": cork}})
    flat = {cycle: {} for cycle in (1, 2)}  # closures by no power of 0
    closed = world(configuration, flat)
    table = closures.indifference_table(closed, configuration.statistics, 1)
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
    assert closures.elasticity_table(closed).elasticity.isna().all()


def test_a_rock_of_which_one_joint_closed_or_all_by_nothing_has_a_mean_and_no_scatter():
    closed = world(study_of(ONE))
    lone = closed.copy(deep=True)
    lone.status[:, 1:] = 16
    table = closures.max_closure_table(lone)
    assert (table.samples == 1).all()
    name = "max_closure_mean_mm"
    np.testing.assert_allclose(table[name][:2], 1e3 * closed.max_closure.values[0, 0])
    assert table[[f"{name}_standard_error", "variation"]].isna().all(axis=None)
    assert closures.correlation_table(lone).empty
    assert (
        closures.indifference_table(lone, study_of(ONE).statistics, 1).status
        == "too few successful realisations"
    ).all()
    assert maximum_closures(lone) == []
    lone.status[:, 1] = 0
    assert len(maximum_closures(lone)) == 1
    common = world(study_of(ONE, COMMON)).isel(realization=slice(1))
    change = closures.max_closure_table(common)[["max_closure_change_mm_standard_error"]]
    assert change.isna().all(axis=None)
    none = closures.max_closure_table(closed.assign(max_closure=0.0 * closed.max_closure))
    assert (none[name] == 0.0).all()
    assert none.variation.isna().all()


# Realisations of a study that fit measured curves best


SEATING = 0.5e6


def study(status=(0, 0, 0)):
    """Three surfaces whose closures are 1, 2 and 3 times one curve, later cycles a tenth of it."""
    stress = np.linspace(0.0, 2e6, 9)
    loading = 1e-4 * np.sqrt(stress / 2e6)
    unloading = 1e-4 * (0.8 + 0.2 * stress / 2e6)
    scale = np.array([1.0, 2.0, 3.0])[:, None, None, None] * np.array([1.0, 0.1])[:, None, None]
    closure = scale * np.stack([loading, unloading])
    end = closure[..., 1, 0]
    start = np.pad(end[:, :-1], ((0, 0), (1, 0)))
    closure = closure + start[..., None, None]
    maximum = closure[..., 0, -1] - start
    seat = scale[..., 0, 0] * 1e-4 * 0.5
    bulk = np.broadcast_to(3e-5 * stress / 2e6, closure.shape)
    dimensions = ("case", "realization", "cycle")
    return xr.Dataset(
        {
            "closure": ((*dimensions, "branch", "stress"), (closure + bulk)[None]),
            "bulk_indentation": ((*dimensions, "branch", "stress"), bulk[None]),
            "status": (dimensions[:2], np.array([status], dtype=np.int16)),
            "max_closure": (dimensions, (maximum + 3e-5)[None]),
            "max_closure_net": (dimensions, maximum[None]),
            "max_closure_seated_net": (dimensions, (maximum - seat)[None]),
            "residual_closure": (dimensions, (end + start)[None]),
            "residual_closure_seated_net": (dimensions, np.full((1, 3, 2), 7e-6)),
        },
        coords={
            "case": ["one-base"], "rock": ("case", ["one"]), "parameter": ("case", ["base"]),
            "max_normal_stress": ("case", [2e6]), "realization": [10, 11, 12], "cycle": [1, 2],
            "branch": ["loading", "unloading"], "stress": stress,
        },
    )  # fmt: skip


def like(number, cycle=1, offset=0.0):
    """A measured curve that is a modelled one, from another zero."""
    base = study().isel(case=0, realization=number).sel(cycle=cycle)
    up, down = (base.closure - base.bulk_indentation).values
    stress = np.append(base.stress, base.stress[-2::-1])
    closure = np.append(up, down[-2::-1]) + offset
    return MeasuredCurve(stress, closure, np.full(stress.size, cycle), np.arange(stress.size))


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("cycle", [1, 2])
@pytest.mark.parametrize("offset", [0.0, 3e-4])
def test_the_surface_that_was_measured_fits_best_and_without_misfit(number, cycle, offset):
    (row,) = fit_table(study(), {"one": like(number, cycle, offset)}, SEATING).itertuples()
    assert row.misfit_mm < 1e-12
    assert row.median_misfit_mm > 1e-3
    # 6 points are above the seating on loading, and 8 on unloading
    assert (row.best_realization, row.samples, row.points) == (10 + number, 3, 14)


def test_the_misfit_is_the_root_mean_square_of_the_differences_of_closures():
    curve = like(0)
    table = fit_table(study(), {"one": curve._replace(closure=1.3 * curve.closure)}, SEATING)
    known = np.concatenate([closure for *_, closure in curve.since_seating(1, SEATING)])
    expected = 1e3 * np.sqrt(np.mean((0.3 * known) ** 2))
    assert table.misfit_mm[0] == pytest.approx(expected)
    largest = 1e3 * 1.3 * (1e-4 - 0.5e-4)
    assert table.misfit_percent[0] == pytest.approx(100 * expected / largest)


def test_each_cycle_has_its_own_best_and_all_together_one_and_none_that_failed():
    one = like(0, 1)
    two = like(2, 2)
    both = MeasuredCurve(*(np.concatenate(pair) for pair in zip(one, two, strict=True)))
    table = fit_table(study(), {"one": both}, SEATING)
    assert table.cycle.tolist() == ["1", "2", "all"]
    # the first cycle's differences are ten times those of the second
    assert table.best_realization.tolist() == [10, 12, 10]
    assert [fit[:2] for fit in best_fits(table, "one")] == [(1, 10), (2, 12)]
    table = fit_table(study(status=(16, 0, 0)), {"one": both}, SEATING)
    assert (table.best_realization[0], table.samples[0]) == (11, 2)


def test_a_joint_that_reached_fewer_than_two_of_the_stresses_fits_no_curve():
    cut = study()
    cut.closure[0, 0, ..., 1:] = np.nan
    (row,) = fit_table(cut, {"one": like(0)}, SEATING).itertuples()
    assert (row.best_realization, row.samples) == (11, 2)


def test_a_measured_curve_without_any_closure_has_a_misfit_and_no_percentage_of_it():
    curve = like(0)
    (row,) = fit_table(
        study(), {"one": curve._replace(closure=0.0 * curve.closure)}, SEATING
    ).itertuples()
    assert row.misfit_mm > 0.0
    assert np.isnan(row.misfit_percent)


# Accuracy of a study by two levels: results, their intervals, and what `make study` does next


def slate(surfaces, seed=1, draws="independent", elasticity=-1.0):
    """A rock with three levels of E whose truth is known."""
    study = {"rocks": ["slate"], "realizations": surfaces, "root_seed": seed, "draws": draws}
    levels = dict.fromkeys(("poisson_ratio", "compressive_strength_MPa", "jrc"))
    known = ELASTICITIES[2] | {"youngs_modulus": elasticity}
    whole = study_of({"study": study, "rocks": {"slate": {"levels": levels}}})
    closed = world(whole, dict.fromkeys((1, 2), known))
    net = 0.8 * closed.max_closure
    return closed.assign(stiffness_net=1e6 / closed.max_closure, max_closure_seated_net=net)


def refined(study, differences, bias=-0.08, scatter=0.05, seed=1):
    """The first surfaces of a study by finer numerics."""
    closed = study.isel(realization=slice(differences))
    noise = np.random.default_rng(seed).standard_normal(closed.max_closure.shape)
    factor = xr.DataArray(1.0 + bias + scatter * noise, dims=closed.max_closure.dims)
    finer = {name: factor * closed[name] for name in ("max_closure", "max_closure_seated_net")}
    return closed.assign(**finer, stiffness_net=closed.stiffness_net / factor)


def reached_closures(study, finest, within):
    """Rows of gross closures; those of net closures, which are judged too, differ by a factor."""
    table = reached_table(study, finest, Accuracy(within=within), 0.05)
    gross, net = (part for _, part in table.groupby("quantity"))
    assert len(gross) == len(net)
    np.testing.assert_allclose(0.8 * gross.study_value, net.study_value, rtol=0.1)
    return gross.reset_index(drop=True)


def test_a_mean_is_that_of_all_surfaces_and_of_the_differences_to_the_finest_numerics():
    study = slate(40)
    finest = refined(study, 12)
    table = reached_closures(study, finest, 0.1)
    assert (table[["surfaces", "differences"]] == [40, 12]).all(axis=None)
    coarse, finer = (1e3 * part.max_closure.values[0, :, 0] for part in (study, finest))
    row = table.iloc[0]
    assert row.value == pytest.approx(coarse.mean() + (finer - coarse[:12]).mean())
    assert row.study_value == pytest.approx(coarse.mean())
    assert row.low < row.value < row.high
    assert row.half_width_percent == pytest.approx(50.0 * (row.high - row.low) / row.value)
    assert (table.met == (table.half_width_percent <= 10.0)).all()
    # without any difference it is the interval of the surfaces, but for degrees of freedom
    same = reached_closures(study, study.isel(realization=slice(38)), 0.1)
    alone = t_interval(coarse)
    assert same.value[0] == pytest.approx(alone.value)
    assert same.high[0] == pytest.approx(alone.high, rel=0.01)


def test_failed_joints_of_either_level_are_left_out_and_few_differences_never_suffice():
    study = slate(20)
    finest = refined(study, 9).copy(deep=True)
    study.status[0, [1, 15]] = 16
    finest.status[0, 4] = 16
    finest.max_closure[2, 6, 0] = np.nan
    table = reached_closures(study, finest, 0.99)
    assert table[["surfaces", "differences"]].iloc[0].tolist() == [18, 7]
    assert table.differences.tolist() == [7, 7, 9, 9, 8, 9]
    assert table.met.tolist() == [False] * 2 + [True] * 4
    none = finest.assign(status=finest.status + 16)
    table = reached_table(study, none, Accuracy(within=0.99), 0.05)
    assert not table.met.any()
    assert np.isinf(table.surfaces_needed).all()


@pytest.mark.parametrize("draws", ["independent", "common"])
def test_indifference_intervals_cover_those_of_the_finest_numerics(draws):
    whole = refined(slate(2000, 1, draws, -1.1), 2000)
    known = ((r, r.interval(0.05, 100)) for r in responses(whole, TARGET))
    truth = {r.cycle: 100.0 * interval.length / r.base for r, interval in known}
    wish = Accuracy(within=0.5, of="interval")
    covered = []
    for seed in range(4 if draws == "common" else 8):
        finest = refined(slate(100, 50 + seed, draws, -1.1), 20, seed=seed)
        table = reached_table(slate(100, 50 + seed, draws), finest, wish, 0.05)
        covered += [row.low <= truth[row.cycle] <= row.high for row in table.itertuples()]
    assert sum(covered) >= 0.85 * len(covered)
    # the same closures at both levels have the length of Table 3
    study = slate(30, 3, draws)
    row = reached_table(study, study.isel(realization=slice(9)), wish, 0.05).iloc[0]
    response = next(responses(study, TARGET))
    assert row.value == pytest.approx(100.0 * response.interval(0.05).length / response.base)
    assert row.value == pytest.approx(row.study_value)


def test_an_interval_by_two_differences_or_without_a_root_is_not_known():
    wish = Accuracy(within=0.5, of="interval")
    study = slate(20, 6, elasticity=0.0)
    without = [np.isnan(r.interval(0.05).length) for r in responses(study, TARGET)]
    assert without == [True, False]
    table = reached_table(study, study.isel(realization=slice(9)), wish, 0.05)
    assert np.isinf(table.half_width_percent).tolist() == without
    table = reached_table(slate(20), refined(slate(20), 2), wish, 0.05)
    assert table.value.isna().all()
    assert np.isinf(table.half_width_percent).all()


@pytest.mark.parametrize("closures", ["scatter", "all but one alike"])
def test_the_contribution_of_a_surface_to_a_length_is_its_change_where_the_surface_is_left_out(
    closures,
):
    response = next(responses(slate(6), TARGET))
    samples = response.samples.copy()
    if closures != "scatter":
        samples[0, 1:] = 0.5 * samples[0, 0]  # which have no deviation without the first
    response = response._replace(samples=samples)
    whole, found = _log_length(response, 0.05, 6)
    for level, i in np.ndindex(samples.shape):
        left = np.delete(samples[level], i)
        means, deviations = response.means, response.deviations
        means[level], deviations[level] = left.mean(), left.std(ddof=1)
        about = (6, 0.05, response.base)
        length = indifference_interval(response.levels, means, deviations, *about).length
        assert found[level, i] == pytest.approx(5 / 6 * (whole - np.log(length)), rel=1e-6)


def rows(needed, differences=8):
    return pd.DataFrame({
        "rock": "slate", "parameter": "base", "level": "base", "cycle": 1, "surfaces": 10,
        "quantity": "max_closure", "differences": 8, "surfaces_needed": needed,
        "differences_needed": differences, "met": [need <= 10 for need in needed],
        "half_width_percent": 9.0, "least_percent": 4.0,
        "surface_core_minutes": 1.0, "difference_core_minutes": 4.0,
    })  # fmt: skip


def test_both_counts_grow_by_blocks_until_all_is_met_the_most_are_closed_or_the_budget_is_spent():
    wish = Accuracy(within=0.05)
    assert next_counts(rows([5, 9]), wish, START) is None
    assert next_counts(rows([5, 13]), wish, START) == (20, 8)
    assert next_counts(rows([13], 13), wish, START) == (20, 16)
    assert next_counts(rows([500], 500), wish, START) == (20, 16)  # no more than twice
    assert next_counts(rows([np.inf], np.inf), wish, Counts(150, 80)) == (200, 160)
    assert next_counts(rows([12], 8), wish, Counts(20, 8)) == (30, 12)  # more than was expected
    assert next_counts(rows([np.inf], np.inf), wish, Counts(200, 200)) is None
    small = Accuracy(within=0.05, budget_core_minutes=45.0)
    assert next_counts(rows([500], 500), small, START) is None
    larger = Accuracy(within=0.05, budget_core_minutes=69.0 + 4.0 * 4)
    assert next_counts(rows([500], 8), larger, START) == (20, 8)


def test_a_budget_sets_the_start_and_must_suffice_for_two_surfaces():
    price = {"ensemble": ["cases", "finest"], "rock": "slate", "cases": 9, "seconds": [2.0, 20.0]}
    wish = Accuracy(within=0.05)
    for minutes, counts in ((28.0, START), (20.0, (5, 4)), (7.0, (2, 2))):
        budget = wish._replace(budget_core_minutes=minutes)
        assert start_counts(pd.DataFrame(price), budget) == counts
    words = "must be at least 6.6, for 2 surfaces of all 9 cases; a joint takes up to 2 s"
    with pytest.raises(InputError, match=re.escape(words)):
        start_counts(pd.DataFrame(price), wish._replace(budget_core_minutes=6.5))


def test_a_mean_stiffness_is_harmonic_and_its_interval_in_order():
    study = slate(40)
    finest = refined(study, 12)
    table = reached_table(study, finest, Accuracy(within=0.1, of="stiffness"), 0.05)
    mean = reached_closures(study, finest, 0.1)
    assert ((table.low < table.value) & (table.value < table.high)).all()
    np.testing.assert_allclose(table.half_width_percent, mean.half_width_percent)
    np.testing.assert_allclose(table.value * mean.value, 1.0)  # in MPa/mm and mm


def test_the_finest_joints_are_the_first_of_each_case_with_all_effects():
    study = {"rocks": ["slate"], "realizations": 25, "pool": None, "accuracy": {"within": 0.1}}
    whole = study_of({"study": study, "effects": {"auto": 0.05}, "flow": True})
    ensembles = ensembles_of(whole)
    assert list(ensembles) == ["cases", "finest"]
    blocks = [blocks_of(part, part.study.realizations) for part in ensembles.values()]
    assert [[len(block) for block in part] for part in blocks] == [[10, 10, 5], [4, 4]]
    one, other = (
        block_settings(part, case, range(2))
        for part in ensembles.values()
        for case in cases_of(part)
        if case.label == "slate-jrc-low"
    )
    assert other._replace(case=one.case, effects_chosen_to=one.effects_chosen_to) == one
    assert other.conditions.numerics == FINEST != one.conditions.numerics
    assert [part.effects.auto for part in ensembles.values()] == [0.05, None]
    plain = study_of({"study": study | {"accuracy": None}})
    assert closed_keys(whole.stated)["study"].keys() == plain.stated["study"].keys() - {"accuracy"}
    assert len(blocks_of(plain)) == 1
