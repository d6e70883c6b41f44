"""Adjusted tables in a world in which covariates tell a known share of the scatter."""

import numpy as np
import pytest

from jointclosure.claims.findings import TARGET
from jointclosure.ensemble.cases import pool_of
from jointclosure.ensemble.covariates import Covariates
from jointclosure.sensitivity.closures import elasticity_table, max_closure_table
from jointclosure.sensitivity.intervals import indifference_table
from jointclosure.sensitivity.responses import (
    responses,
)
from jointclosure.sensitivity.variance_reduction import variance_reduction
from jointclosure.statistics.control_variates import Known
from jointclosure.statistics.randomness import generator
from tests.sensitivity.world import SCATTER, world
from tests.studied import study_of

ONE = {"study": {"rocks": ["dolerite"], "pool": 200}, "statistics": {"bootstrap_resamples": 40}}
# the log of the first cycle's closure is 0.6 s2 + 0.8 s0 of three normal numbers of a surface
MIXED = np.array([[0.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.6, 1.0, 1.0]])
EXACT = Known(np.zeros(3), MIXED.T @ MIXED, np.inf)


def stated(study, known=EXACT):
    """What makes the closures of that world: all of the first cycle's, 36 % of the second's."""
    draws = [[generator(int(s, 16)).normal(size=3) for s in row] for row in study.seed.values]
    return Covariates(np.array(draws) @ MIXED, known)


@pytest.fixture(scope="module")
def pool():
    return world(pool_of(study_of(ONE)))


@pytest.fixture(scope="module")
def study():
    return world(study_of(ONE))


@pytest.fixture(scope="module")
def table(pool):
    known = EXACT._replace(surfaces=4000)
    return variance_reduction(pool, stated(pool, known), 20, 0.05, 1, repetitions=600)


def test_means_are_worth_what_covariates_tell_of_them(table):
    means = table[(table.response == "mean") & (table.draws == "independent")].set_index("cycle")
    assert means.worth[1] > 20.0
    # one over what is not told, less what fitting one slope to 20 costs
    assert means.worth[2] == pytest.approx(20 / 21.1 / 0.64, rel=0.15)
    np.testing.assert_allclose(means.plain_simulations, 20 * means.worth)


def test_coverages_are_those_of_95_percent_intervals(table):
    rows = table[table.response.isin(["mean", "difference", "slope"])]
    assert rows.adjusted_coverage.between(0.91, 0.985).all()
    assert rows.adjusted_coverage.mean() == pytest.approx(0.95, abs=0.015)
    assert table[table.response == "interval"].adjusted_coverage.isna().all()


def test_differences_of_independent_draws_gain_and_those_of_common_draws_pay_for_fitting(table):
    rows = table[(table.response == "difference") & (table.parameter == "youngs_modulus")]
    worth = rows.set_index(["draws", "cycle"]).worth
    assert worth["independent", 1] > 15.0
    assert worth["independent", 2] > 1.25
    assert worth["common", 2] > 0.85


def test_intervals_and_deviations_gain_on_the_first_cycle_and_lose_nothing_on_the_second(table):
    of_cycle = table.set_index(["response", "cycle"]).sort_index()
    assert (of_cycle.loc[("interval", 1)].worth > 1.1).all()
    assert of_cycle.loc[("interval", 1)].worth.median() > 3.0
    assert of_cycle.loc[("standard deviation", 1)].worth.item() > 2.0
    assert (of_cycle.loc[("interval", 2)].worth > 0.95).all()
    assert of_cycle.loc[("standard deviation", 2)].worth.item() == 1.0


def test_what_is_not_known_of_the_covariates_means_is_in_their_worth(pool, table):
    few = stated(pool, EXACT._replace(surfaces=40))
    worse = variance_reduction(pool, few, 20, 0.05, 1, repetitions=600)
    first = (table.response == "mean") & (table.cycle == 1)
    assert worse[first].worth.item() < 0.2 * table[first].worth.item()
    assert worse[first].adjusted_coverage.item() > 0.91


def test_tables_have_adjusted_numbers_beside_the_plain_ones(study, pool):
    closures = max_closure_table(study, stated(study))
    name = "max_closure_adjusted_mean_mm"
    first = closures[closures.cycle == 1]
    plain_error = first.max_closure_mean_mm_standard_error
    assert (first[f"{name}_standard_error"] < 0.4 * plain_error).all()
    base = closures[(closures.parameter == "base") & (closures.cycle == 1)].iloc[0]
    # of closures whose logarithm is normal
    truth = np.exp(0.5 * SCATTER[1] ** 2)
    assert base[name] == pytest.approx(truth, abs=3 * base[f"{name}_standard_error"])
    elasticities = elasticity_table(pool, stated(pool))
    assert np.isfinite(elasticities.elasticity_adjusted_standard_error).all()
    intervals = indifference_table(study, study_of(ONE).statistics, 1, stated(study))
    jrc = intervals[(intervals.parameter == "jrc") & (intervals.cycle == 1)].iloc[0]
    assert jrc.adjusted_standard_error < jrc.standard_error
    assert jrc.adjusted_low < jrc.adjusted_length < jrc.adjusted_high


def test_without_covariates_plain_numbers_are_the_same_and_adjusted_ones_are_not_there(study):
    statistics = study_of(ONE).statistics
    for make in (
        max_closure_table,
        lambda *given: indifference_table(given[0], statistics, 1, *given[1:]),
    ):
        plain, adjusted = make(study), make(study, stated(study))
        own = [name for name in plain if "adjusted" not in name]
        assert plain[own].equals(adjusted[own])
        assert plain.drop(columns=own).isna().all(axis=None)
    assert variance_reduction(study, None, 20, 0.05, 1).empty


def test_few_or_unknown_surfaces_are_not_adjusted(study):
    few = study.isel(realization=slice(0, 14))
    covariates = stated(study)
    part = covariates._replace(values=covariates.values[:, :14])
    adjusted = {r.cycle: r.covariates is not None for r in responses(few, TARGET, part)}
    assert adjusted == {1: False, 2: True}
    covariates.values[0, 3] = np.nan  # of the base case, which all responses have
    assert all(each.covariates is None for each in responses(study, TARGET, covariates))
