"""Published lengths among those of repeated studies."""

from typing import NamedTuple

import numpy as np
import pytest
import scipy.stats

from jointclosure.statistics.indifference import indifference_interval, indifference_lengths
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.repetitions import (
    Design,
    Pool,
    Sensitivity,
    crossed_likelihoods,
    draw_studies,
    joint_test,
    length_distribution,
    log_likelihoods,
    p_of_table,
    parameters_without_effect,
    pool_error,
    resampled_pools,
    share_as_short,
    two_sided_p,
)

# A world in which the truth is known: closures on surfaces, against one parameter

LEVELS = np.array([-1.0, 0.0, 1.0])
SCATTER = 0.15
TARGETS = 2


def closures(random, effect, count):
    """Closures (targets, count) at a level; skewed, and the two targets go together."""
    common = random.normal(size=count)
    own = random.normal(size=(TARGETS, count))
    slopes = np.array([[1.0], [-0.5]]) * effect
    return (1.0 + slopes) * np.exp(SCATTER * (0.6 * common + 0.8 * own))


def sensitivity(random, effect, pool, label, common=False):
    """A parameter of one rock with a pool of independent or common surfaces per level."""
    state = random.bit_generator.state
    pools = []
    for level in LEVELS:
        if common:
            random.bit_generator.state = state
        values = closures(random, effect * level, pool)
        pools.append(Pool(values, label if common else f"{label} {level}"))
    return Sensitivity(LEVELS, 0.0, tuple(pools))


def published(random, effects, draws=20):
    """Means and deviations (parameters, targets, levels) of one study of independent draws.

    The parameters share the draws at the base level.
    """
    at_base = closures(random, 0.0, draws)
    samples = np.array(
        [[closures(random, -e, draws), at_base, closures(random, e, draws)] for e in effects]
    )
    samples = np.moveaxis(samples, 1, 2)
    return samples.mean(axis=-1), samples.std(axis=-1, ddof=1)


def table_of(drawn):
    """All lengths of drawn studies (R, entries), with targets in the order of keys."""
    return np.concatenate([response.lengths for response in drawn.values()], axis=1)


def test_drawn_means_scatter_as_a_new_study_does_about_the_mean_of_a_pool():
    # with the pool's own error: s^2 (1/n + 1/(N - 1)), and within a study s^2
    random = generator(1)
    values = random.gamma(4.0, size=(1, 30))
    one = Sensitivity(LEVELS, 0.0, tuple(Pool(values, name) for name in "abc"))
    drawn = draw_studies({"x": one}, Design(draws=20), 20000, random)["x"]
    variance = values.var(ddof=1)
    expected = variance * (1 / 20 + 1 / 29)
    np.testing.assert_allclose(drawn.means[:, 0].var(axis=0), expected, rtol=0.04)
    np.testing.assert_allclose((drawn.deviations[:, 0] ** 2).mean(axis=0), variance, rtol=0.02)
    levels = np.corrcoef(drawn.means[:, 0].T)
    np.testing.assert_allclose(levels, np.eye(3), atol=0.03)  # nothing shared


def test_studies_drawn_at_once_are_those_drawn_one_by_one_from_the_same_numbers():
    one = {name: sensitivity(generator(3), e, 12, "rock", True) for name, e in EFFECTS.items()}
    design, repetitions = Design(draws=5), 40
    drawn = draw_studies(one, design, repetitions, generator(4))
    random, at_base = generator(4), None
    resampled = random.integers(12, size=(repetitions, 12), dtype=np.uint8)
    for name, (levels, base, kept) in one.items():
        indices = []
        for level in levels:
            index = random.integers(12, size=(repetitions, 5))
            if level == base:
                at_base = index if at_base is None else at_base
                index = at_base
            indices.append(index)
        for r in range(repetitions):
            for target in range(TARGETS):
                samples = []
                for pool, index in zip(kept, indices, strict=True):
                    values = pool.values[target]
                    spread = values.mean() + (values - values.mean()) * 12 / 11
                    samples.append(spread[resampled[r][index[r]]])
                means, deviations = np.mean(samples, axis=1), np.std(samples, axis=1, ddof=1)
                length = indifference_interval(levels, means, deviations, 5, base=base).length
                response = drawn[name]
                np.testing.assert_allclose(response.means[r, target], means, rtol=1e-12)
                np.testing.assert_allclose(response.deviations[r, target], deviations, rtol=1e-10)
                length = np.inf if np.isnan(length) else length
                np.testing.assert_allclose(response.lengths[r, target], length, rtol=1e-9)


def test_likelihoods_of_some_entries_are_those_of_a_table_with_these_alone():
    lengths = np.exp(generator(5).normal(size=(120, 4)))
    observed = np.array([0.5, 1.0, np.nan, 2.0])
    whole = crossed_likelihoods(lengths, observed)
    some = [3, 0]
    assert whole.of(some).p() == p_of_table(lengths[:, some], observed[some])
    assert whole.of(some).p() != whole.p()


def test_a_table_with_an_entry_without_scatter_has_no_p():
    lengths = np.exp(generator(5).normal(size=(120, 2)))
    lengths[7, 1] = 0.0
    likelihoods = crossed_likelihoods(lengths, np.ones(2))
    assert np.isnan(likelihoods.p())
    assert np.isfinite(likelihoods.of([0]).p())


@pytest.fixture(scope="module")
def common():
    """Studies drawn of pools of the same surfaces at three levels, for two targets."""
    random = generator(2)
    first = random.normal(size=30)
    values = np.stack([first, 2.0 * first])
    one = Sensitivity(LEVELS, 0.0, tuple(Pool(values, "common") for _ in LEVELS))
    return draw_studies({"x": one}, Design(draws=20), 20000, random)["x"]


def test_pools_of_the_same_surfaces_share_their_error(common):
    shared = (1 / 29) / (1 / 20 + 1 / 29)
    between = np.corrcoef(common.means[:, 0].T)[np.triu_indices(3, 1)]
    np.testing.assert_allclose(between, shared, atol=0.03)


def test_targets_of_a_case_share_its_draws(common):
    np.testing.assert_allclose(common.means[:, 1], 2.0 * common.means[:, 0], rtol=1e-12)
    np.testing.assert_allclose(common.lengths[:, 0], common.lengths[:, 1], rtol=1e-9)


WITH_DASHES = np.concatenate([np.arange(1.0, 801.0), np.full(200, np.inf)])


def test_p_of_a_dash_is_its_share():
    assert two_sided_p(WITH_DASHES, np.nan) == pytest.approx(0.2, abs=0.002)


def test_p_of_a_length_counts_a_dash_as_longer():
    assert two_sided_p(WITH_DASHES, 500.5) == pytest.approx(1.0, abs=0.002)
    assert two_sided_p(WITH_DASHES, 10.5) == pytest.approx(0.02, abs=0.002)
    assert two_sided_p(WITH_DASHES, 1e9) == pytest.approx(0.4, abs=0.002)
    assert two_sided_p(WITH_DASHES, 0.5) > 0.0


def test_the_share_of_shorter_lengths_counts_a_dash_as_longer():
    assert share_as_short(WITH_DASHES, 10.5) == pytest.approx(0.011, abs=0.001)
    assert share_as_short(WITH_DASHES, np.nan) == 1.0


def test_ranges_of_lengths_with_dashes_have_no_upper_end():
    found = length_distribution(WITH_DASHES)
    assert (found.median, found.share_without_root) == (500.0, 0.2)
    assert found.low_90 == pytest.approx(51.0, abs=1.0)
    assert found.high_90 == found.high_95 == np.inf


def test_ranges_of_lengths_leave_out_a_twentieth_or_a_fortieth_at_either_end():
    lengths = generator(3).permutation(np.arange(1.0, 1001.0))
    found = length_distribution(lengths)
    assert found == pytest.approx((500.0, 50.0, 951.0, 25.0, 976.0, 0.0, 0.0), abs=1.0)
    assert found.low_90 <= 50.0 + 1.0 <= 950.0 <= found.high_90  # and never more than that


def test_lengths_of_zero_are_a_share_of_their_own():
    """As where the same surface is drawn alone at the base."""
    found = length_distribution(np.array([0.0, 0.0, 3.0, np.inf]))
    assert (found.share_zero, found.share_without_root) == (0.5, 0.25)


def test_no_table_is_impossible_however_few_repetitions_have_a_root_or_none():
    drawn = np.exp(generator(4).normal(size=(200, 2)))
    few = drawn.copy()
    few[5:, 1] = np.inf
    for lengths in (drawn, few):
        for table in ([np.inf, np.inf], [1e-6, 1e6], [1e300, 1.0]):
            assert np.isfinite(log_likelihoods(lengths, np.array([table]))).all()
    # of so few lengths no density is known, only that there are some
    one, other = log_likelihoods(few, np.array([[1.0, 1e-6], [1.0, 1e6]]))
    assert one == other


def test_the_parameters_of_a_rock_share_the_draws_at_their_base_alone():
    random = generator(9)
    base, *others = (Pool(random.normal(size=(1, 30)), name) for name in "abcde")
    both = {
        key: Sensitivity(LEVELS, 0.0, (low, base, high))
        for key, (low, high) in {"x": others[:2], "y": others[2:]}.items()
    }
    x, y = draw_studies(both, Design(draws=5), 500, random).values()
    np.testing.assert_array_equal(x.means[:, 0, 1], y.means[:, 0, 1])
    assert abs(np.corrcoef(x.means[:, 0, 0], y.means[:, 0, 0])[0, 1]) < 0.15
    # also where all levels draw from one pool, they draw anew
    none = draw_studies(parameters_without_effect(both), Design(draws=5), 500, random)["x"]
    assert abs(np.corrcoef(none.means[:, 0].T)[0, 1]) < 0.5
    assert not (none.means[:, 0, 0] == none.means[:, 0, 1]).any()


def test_the_error_of_a_pool_is_that_of_pools_drawn_anew():
    random = generator(6)
    one = {"x": sensitivity(random, 0.1, 60, "x")}

    def above(pool):  # a share that every repetition of a pool has alike
        return float(pool["x"].pools[0].values[0].mean() > 1.0)

    again = [above(each) for each in resampled_pools(one, random, 400)]
    mean, error = one["x"].pools[0].values[0].mean(), one["x"].pools[0].values[0].std(ddof=1)
    share = scipy.stats.norm.cdf((mean - 1.0) / (error / np.sqrt(60)))
    assert np.mean(again) == pytest.approx(share, abs=0.08)
    assert pool_error(again, 10**9) == pytest.approx(np.std(again, ddof=1))
    # what is binomial of few repetitions is taken off
    noisy = random.binomial(100, 0.3, size=2000) / 100
    assert pool_error(noisy, 100) < 0.3 * noisy.std()
    assert np.isnan(pool_error([np.nan, np.nan, np.nan, 0.5], 100))


EFFECTS = {"nu": 0.0, "sigma_c": 0.1, "E": 0.3}


def pools(random, effects, size=60):
    return {name: sensitivity(random, e, size, "rock", True) for name, e in effects.items()}


def table(random, effects):
    """The lengths that one study publishes, in the order of `table_of`."""
    means, deviations = published(random, list(effects.values()))
    return indifference_lengths(LEVELS, means, deviations, 20).ravel()


ROOTS = np.exp(np.linspace(1.0, 3.0, 9))


@pytest.fixture(scope="module")
def log_normal():
    """Log-normal lengths, of which a quarter of the second entry is a dash."""
    random = generator(1)
    drawn = np.exp(random.normal(2.0, 0.5, (20000, 2)))
    drawn[random.random(20000) < 0.25, 1] = np.inf
    return drawn


def test_the_likelihood_of_a_dash_beside_log_normal_lengths_is_the_known_one(log_normal):
    tables = np.column_stack([ROOTS, np.full(9, np.inf)])
    expected = scipy.stats.norm.logpdf(np.log(ROOTS), 2.0, 0.5) + np.log(0.25)
    np.testing.assert_allclose(log_likelihoods(log_normal, tables), expected, atol=0.08)


def test_the_likelihood_of_log_normal_lengths_is_the_known_one(log_normal):
    tables = np.column_stack([ROOTS, np.full(9, np.exp(2.0))])
    expected = scipy.stats.norm.logpdf(np.log(ROOTS), 2.0, 0.5) + np.log(0.75)
    expected += scipy.stats.norm.logpdf(2.0, 2.0, 0.5)
    np.testing.assert_allclose(log_likelihoods(log_normal, tables), expected, atol=0.1)


def test_a_length_beyond_all_drawn_ones_is_unlikely(log_normal):
    assert log_likelihoods(log_normal, np.array([[1e9, 7.0]]))[0] < -10.0


@pytest.fixture(scope="module")
def drawn_tables():
    """Lengths of drawn studies, and tables of lengths of the same distribution."""
    return np.exp(generator(2).normal(size=(2, 2000, 3)))


def test_many_tables_have_the_likelihoods_of_each_alone(drawn_tables):
    drawn, tables = drawn_tables
    many = log_likelihoods(drawn, tables)
    single = np.concatenate([log_likelihoods(drawn, row[None]) for row in tables[:40]])
    np.testing.assert_allclose(many[:40], single, atol=1e-2)


def test_the_rank_of_a_table_counts_the_table_itself(drawn_tables):
    """So that no p is 0."""
    drawn = drawn_tables[0][:200]
    assert p_of_table(drawn, np.full(3, 1e9)) == 1.0 / 201.0
    assert p_of_table(drawn, np.ones(3)) > 0.9


def test_the_error_of_a_likelihood_is_its_scatter_over_sets_of_repetitions():
    random, observed = generator(3), np.exp(np.linspace(-1.5, 1.5, 8))
    found = [joint_test(np.exp(random.normal(size=(400, 8))), observed) for _ in range(60)]
    scatter = np.std([one.log_likelihood for one in found], ddof=1)
    stated = np.mean([one.standard_error for one in found])
    assert 0.7 < stated / scatter < 1.4


class World(NamedTuple):
    """Lengths of drawn studies with and without effects, p of own tables, and a median table."""

    drawn: np.ndarray
    none: np.ndarray
    own: list
    observed: np.ndarray


@pytest.fixture(scope="module")
def world():
    random = generator(4)
    effects = {"a": 0.3, "b": 0.4}
    sensitivities = pools(random, effects)
    drawn = table_of(draw_studies(sensitivities, Design(), 2000, random))
    none = table_of(draw_studies(parameters_without_effect(sensitivities), Design(), 2000, random))
    own = [joint_test(drawn, table(random, effects)).p for _ in range(12)]
    observed = np.median([table(random, effects) for _ in range(9)], axis=0)
    return World(drawn, none, own, observed)


def test_tables_of_the_same_world_are_likely(world):
    assert 0.2 < np.mean(world.own) < 0.8


def test_a_table_with_effects_is_unlikely_without_them(world):
    assert joint_test(world.none, world.observed).p < 0.01


def test_a_table_of_dashes_alone_is_unlikely(world):
    assert joint_test(world.drawn, np.full(4, np.nan)).p < 0.001


def test_a_table_of_another_world_is_unlikely(world):
    unlikely = joint_test(world.drawn, 5.0 * world.observed)
    assert unlikely.p < 0.01
    known = joint_test(world.drawn, world.observed)
    assert unlikely.log_likelihood < known.log_likelihood - 5.0


def test_pools_of_the_same_surfaces_are_resampled_together():
    pool = Pool(generator(7).normal(size=(1, 30)), "x")
    one = {"x": Sensitivity(np.arange(3.0), 1.0, (pool, Pool(pool.values + 1.0, "x"), pool))}
    for each in resampled_pools(one, generator(8), 3):
        low, middle, high = (own.values for own in each["x"].pools)
        np.testing.assert_array_equal(low, high)
        np.testing.assert_allclose(middle, low + 1.0)
        assert len(np.unique(low)) < 30


@pytest.mark.slow
@pytest.mark.parametrize("null", [False, True])
def test_joint_p_values_are_uniform_where_the_table_is_a_draw(null):
    random = generator(5)
    effects = dict.fromkeys(EFFECTS, 0.0) if null else EFFECTS
    p = []
    for _ in range(300):
        sensitivities = pools(random, effects)
        if null:
            sensitivities = parameters_without_effect(sensitivities)
        drawn = table_of(draw_studies(sensitivities, Design(), 400, random))
        p.append(joint_test(drawn, table(random, effects)).p)
    assert scipy.stats.kstest(p, "uniform").pvalue > 0.001
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09
