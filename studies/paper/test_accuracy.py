"""The accuracy that a study reaches, and the surfaces and differences that it needs for one."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.assessment.numerical_settings import FINEST
from jointclosure.inputs import InputError
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.two_level import t_interval
from studies.frame.cases import (
    block_settings,
    blocks_of,
    cases_of,
    closed_keys,
    ensembles_of,
)
from studies.frame.keys import Accuracy
from studies.paper.accuracy import (
    START,
    Counts,
    _log_length,
    describe_reached,
    next_counts,
    reached_table,
    start_counts,
)
from studies.paper.claims import TARGET
from studies.paper.responses import responses
from tests.studied import study_of
from tests.world import ELASTICITIES, world


def slate(surfaces, seed=1, draws="independent", elasticity=-1.0):
    """Return a study of one rock with three levels of E, whose elasticity is known."""
    study = {"rocks": ["slate"], "realizations": surfaces, "root_seed": seed, "draws": draws}
    levels = dict.fromkeys(("poisson_ratio", "compressive_strength_MPa", "jrc"))
    known = ELASTICITIES[2] | {"youngs_modulus": elasticity}
    whole = study_of({"study": study, "rocks": {"slate": {"levels": levels}}})
    closed = world(whole, dict.fromkeys((1, 2), known))
    net = 0.8 * closed.max_closure
    return closed.assign(stiffness_net=1e6 / closed.max_closure, max_closure_seated_net=net)


def refined(study, differences, bias=-0.08, scatter=0.05, seed=1):
    """Return the first surfaces of a study as by finer numerics: with a bias and scatter."""
    closed = study.isel(realization=slice(differences))
    noise = np.random.default_rng(seed).standard_normal(closed.max_closure.shape)
    factor = xr.DataArray(1.0 + bias + scatter * noise, dims=closed.max_closure.dims)
    finer = {name: factor * closed[name] for name in ("max_closure", "max_closure_seated_net")}
    return closed.assign(**finer, stiffness_net=closed.stiffness_net / factor)


def reached_closures(study, finest, within):
    """Return the rows of gross closures of `reached_table`; those of net closures are alike."""
    table = reached_table(study, finest, Accuracy(within=within), 0.05)
    gross, net = (part for _, part in table.groupby("quantity"))
    assert len(gross) == len(net)
    np.testing.assert_allclose(0.8 * gross.study_value, net.study_value, rtol=0.1)
    return gross.reset_index(drop=True)


@pytest.fixture(scope="module")
def forty():
    """A study of 40 surfaces, of which 12 are closed by finer numerics too."""
    study = slate(40)
    return study, refined(study, 12)


def test_a_mean_is_that_of_surfaces_corrected_by_differences_to_finer_ones(forty):
    study, finest = forty
    table = reached_closures(study, finest, 0.1)
    assert (table[["surfaces", "differences"]] == [40, 12]).all(axis=None)
    coarse, finer = (1e3 * part.max_closure.values[0, :, 0] for part in (study, finest))
    row = table.iloc[0]
    assert row.value == pytest.approx(coarse.mean() + (finer - coarse[:12]).mean())
    assert row.study_value == pytest.approx(coarse.mean())
    assert row.low < row.value < row.high
    assert row.half_width_percent == pytest.approx(50.0 * (row.high - row.low) / row.value)
    assert (table.met == (table.half_width_percent <= 10.0)).all()


def test_a_mean_is_that_of_surfaces_alone_without_any_difference(forty):
    """But for degrees of freedom."""
    study, _ = forty
    same = reached_closures(study, study.isel(realization=slice(38)), 0.1)
    alone = t_interval(1e3 * study.max_closure.values[0, :, 0])
    assert same.value[0] == pytest.approx(alone.value)
    assert same.high[0] == pytest.approx(alone.high, rel=0.01)


@pytest.fixture(scope="module")
def with_failed_joints():
    """A study of 20 surfaces and its finer joints, of both of which some failed."""
    study = slate(20)
    finest = refined(study, 9).copy(deep=True)
    study.status[0, [1, 15]] = 16
    finest.status[0, 4] = 16
    finest.max_closure[2, 6, 0] = np.nan
    return study, finest


def test_failed_joints_of_either_level_are_left_out(with_failed_joints):
    table = reached_closures(*with_failed_joints, 0.99)
    assert table[["surfaces", "differences"]].iloc[0].tolist() == [18, 7]
    assert table.differences.tolist() == [7, 7, 9, 9, 8, 9]


def test_few_differences_never_suffice(with_failed_joints):
    study, finest = with_failed_joints
    table = reached_closures(study, finest, 0.99)
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


def rows(needed, differences=8):
    return pd.DataFrame({
        "rock": "slate", "parameter": "base", "level": "base", "cycle": 1, "surfaces": 10,
        "quantity": "max_closure", "differences": 8, "surfaces_needed": needed,
        "differences_needed": differences, "met": [need <= 10 for need in needed],
        "half_width_percent": 9.0, "least_percent": 4.0,
        "surface_core_minutes": 1.0, "difference_core_minutes": 4.0,
    })  # fmt: skip


def test_both_counts_grow_by_blocks_until_all_is_met_or_nothing_is_left():
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


def test_a_request_that_the_largest_number_of_realisations_cannot_meet_is_impossible():
    tight = Accuracy(within=1e-6, budget_core_minutes=45.0)
    words = describe_reached(rows([5, 4.8e11], 30), tight)
    assert words.endswith(
        "this is impossible with 200 realisations, the largest number (most): it needs about "
        "4.8e+11, and 200 can give about 4 %"
    )
    words = describe_reached(rows([5, 150], 30), tight)
    assert words.endswith("the budget of 45 minutes of processor time does not suffice for more")


PRICE = pd.DataFrame(
    {"ensemble": ["cases", "finest"], "rock": "slate", "cases": 9, "seconds": [2.0, 20.0]}
)


@pytest.mark.parametrize(("minutes", "counts"), [(28.0, START), (20.0, (5, 4)), (7.0, (2, 2))])
def test_a_budget_sets_the_start(minutes, counts):
    assert start_counts(PRICE, Accuracy(within=0.05, budget_core_minutes=minutes)) == counts


def test_a_budget_must_suffice_for_two_surfaces():
    words = "must be at least 6.6, for 2 surfaces of all 9 cases; a joint takes up to 2 s"
    with pytest.raises(InputError, match=re.escape(words)):
        start_counts(PRICE, Accuracy(within=0.05, budget_core_minutes=6.5))


@pytest.fixture(scope="module")
def stiffness_and_closure(forty):
    """Mean stiffnesses that were reached, and mean closures."""
    study, finest = forty
    stiffness = reached_table(study, finest, Accuracy(within=0.1, of="stiffness"), 0.05)
    return stiffness, reached_closures(study, finest, 0.1)


def test_a_mean_stiffness_is_harmonic(stiffness_and_closure):
    stiffness, closure = stiffness_and_closure
    np.testing.assert_allclose(stiffness.value * closure.value, 1.0)  # in MPa/mm and mm
    np.testing.assert_allclose(stiffness.half_width_percent, closure.half_width_percent)


def test_the_interval_of_a_mean_stiffness_is_in_order(stiffness_and_closure):
    table, _ = stiffness_and_closure
    assert ((table.low < table.value) & (table.value < table.high)).all()


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
