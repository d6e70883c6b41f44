import numpy as np
import pytest
import scipy.stats

import jointclosure as jc
from jointclosure.statistics.drawn_studies import (
    Design,
    draw_studies,
    without_effect,
)
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.predictive import joint_test, log_likelihoods
from jointclosure.statistics.randomness import generator
from tests.statistics.statistics_world import LEVELS, published, sensitivity, table_of

EFFECTS = {"nu": 0.0, "sigma_c": 0.1, "E": 0.3}


def pools(random, effects, size=60):
    return {name: sensitivity(random, e, size, "rock", True) for name, e in effects.items()}


def table(random, effects):
    """The lengths that one study publishes, in the order of `lengths_table`."""
    means, deviations = published(random, list(effects.values()))
    return indifference_lengths(LEVELS, means, deviations, 20).ravel()


def test_the_likelihood_of_log_normal_lengths_and_dashes_is_the_known_one():
    random = generator(1)
    drawn = np.exp(random.normal(2.0, 0.5, (20000, 2)))
    drawn[random.random(20000) < 0.25, 1] = np.inf
    at = np.exp(np.linspace(1.0, 3.0, 9))
    tables = np.column_stack([at, np.full(9, np.inf)])
    expected = scipy.stats.norm.logpdf(np.log(at), 2.0, 0.5) + np.log(0.25)
    np.testing.assert_allclose(log_likelihoods(drawn, tables), expected, atol=0.08)
    roots = scipy.stats.norm.logpdf(np.log(at), 2.0, 0.5) + np.log(0.75)
    roots += scipy.stats.norm.logpdf(2.0, 2.0, 0.5)
    tables[:, 1] = np.exp(2.0)
    np.testing.assert_allclose(log_likelihoods(drawn, tables), roots, atol=0.1)
    assert log_likelihoods(drawn, np.array([[1e9, 7.0]]))[0] < -10.0


def test_many_tables_have_the_likelihoods_of_each_alone():
    random = generator(2)
    drawn, tables = np.exp(random.normal(size=(2, 2000, 3)))
    many = log_likelihoods(drawn, tables)
    single = np.concatenate([log_likelihoods(drawn, row[None]) for row in tables[:40]])
    np.testing.assert_allclose(many[:40], single, atol=1e-2)


def test_the_error_of_a_likelihood_is_its_scatter_over_sets_of_repetitions():
    random = generator(3)
    observed = np.exp(np.linspace(-1.5, 1.5, 8))
    found = [joint_test(np.exp(random.normal(size=(400, 8))), observed) for _ in range(60)]
    scatter = np.std([one.log_likelihood for one in found], ddof=1)
    stated = np.mean([one.standard_error for one in found])
    assert 0.7 < stated / scatter < 1.4


def test_a_table_of_another_world_is_unlikely_and_that_of_no_effect_is_told():
    random = generator(4)
    effects = {"a": 0.3, "b": 0.4}
    sensitivities = pools(random, effects)
    drawn = table_of(draw_studies(sensitivities, Design(), 2000, random))
    none = table_of(draw_studies(without_effect(sensitivities), Design(), 2000, random))
    own = [joint_test(drawn, table(random, effects)).p for _ in range(12)]
    assert 0.2 < np.mean(own) < 0.8
    observed = np.median([table(random, effects) for _ in range(9)], axis=0)
    assert joint_test(none, observed).p < 0.01
    assert joint_test(drawn, np.full(4, np.nan)).p < 0.001  # all dashes
    unlikely = joint_test(drawn, 5.0 * observed)
    assert unlikely.p < 0.01
    assert unlikely.log_likelihood < joint_test(drawn, observed).log_likelihood - 5.0


@pytest.mark.slow
@pytest.mark.parametrize("null", [False, True])
def test_joint_p_values_are_uniform_where_the_table_is_a_draw(null):
    random = generator(5)
    effects = dict.fromkeys(EFFECTS, 0.0) if null else EFFECTS
    p = []
    for _ in range(300):
        sensitivities = pools(random, effects)
        if null:
            sensitivities = without_effect(sensitivities)
        drawn = table_of(draw_studies(sensitivities, Design(), 400, random))
        p.append(joint_test(drawn, table(random, effects)).p)
    assert scipy.stats.kstest(p, "uniform").pvalue > 0.001
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09


@pytest.mark.parametrize(
    ("lengths", "observed", "named"),
    [(np.ones((200, 3)), np.ones(2), "entries"), (np.full((200, 1), np.nan), np.ones(1), "NaN")],
)
def test_bad_tables_are_refused_by_name(lengths, observed, named):
    with pytest.raises(jc.InputError, match=named):
        joint_test(lengths, observed)
