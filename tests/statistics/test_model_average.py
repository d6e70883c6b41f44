"""Averages over models, on tables of log-normal lengths whose likelihoods are known."""

import numpy as np
import pytest
import scipy

import jointclosure as jc
from jointclosure.statistics.model_average import (
    compare,
    p_averaged,
    p_selected,
    sharpness,
    weights,
)
from jointclosure.statistics.randomness import generator

MEANS = np.array([0.0, 0.5, 1.0])


def drawn_tables(copies, repetitions=600, entries=4, seed=1):
    """Lengths (models, R, entries * copies): each entry is published ``copies`` times."""
    random = generator(seed)
    logs = MEANS[:, None, None] + random.normal(size=(len(MEANS), repetitions, entries))
    return np.repeat(np.exp(logs), copies, axis=2)


def known_weights(logs):
    """Weights of the models by the density of independent normal logs (entries,)."""
    return scipy.special.softmax(scipy.stats.norm.logpdf(logs, MEANS[:, None]).sum(axis=1))


@pytest.mark.parametrize("copies", [1, 3])
def test_weights_are_those_of_the_independent_entries_however_often_published(copies):
    logs = np.array([0.1, 0.9, 0.4, 0.2])
    comparison = compare(drawn_tables(copies), np.repeat(np.exp(logs), copies))
    every = np.ones(4 * copies, bool)
    np.testing.assert_allclose(weights(comparison, every), known_weights(logs), atol=0.06)
    assert sharpness(comparison.drawn.sum(axis=-1)) == pytest.approx(1.0 / copies, rel=0.15)


def test_weights_of_drawn_tables_are_the_frequencies_of_their_models():
    random = generator(5)
    lengths = drawn_tables(2, repetitions=150, entries=2)
    source = random.integers(len(MEANS), size=200)
    logs = np.repeat(MEANS[source][:, None] + random.normal(size=(200, 2)), 2, axis=1)
    every = np.ones(4, bool)
    of_tables = np.array([weights(compare(lengths, np.exp(row)), every) for row in logs])
    of_source = of_tables[np.arange(200), source]
    expected = (of_tables**2).sum(axis=1)
    assert of_source.mean() == pytest.approx(expected.mean(), abs=0.06)


def test_only_the_entries_that_are_seen_or_tested_count():
    observed = np.exp([0.0, 0.0, 9.0, 9.0])
    comparison = compare(drawn_tables(1), observed)
    first, last = np.array([True, True, False, False]), np.array([False, False, True, True])
    assert weights(comparison, first).argmax() == 0
    assert weights(comparison, last).argmax() == 2
    equal = np.full(3, 1 / 3)
    assert p_averaged(comparison, last, equal) < 0.01 < 0.3 < p_averaged(comparison, first, equal)
    assert p_averaged(comparison, first, np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("p", [p_averaged, p_selected])
def test_p_is_uniform_for_tables_drawn_from_the_average(p):
    random = generator(7)
    lengths = drawn_tables(1, repetitions=150, entries=2)
    every, weight = np.ones(2, bool), np.full(3, 1 / 3)
    values = [
        p(compare(lengths, np.exp(random.choice(MEANS) + random.normal(size=2))), every, weight)
        for _ in range(200)
    ]
    assert scipy.stats.kstest(values, "uniform").pvalue > 0.001
    assert np.mean(values) == pytest.approx(0.5, abs=0.07)


def test_a_chosen_model_makes_a_table_look_likelier_than_it_is():
    comparison = compare(drawn_tables(1), np.exp(np.full(4, 2.2)))
    every, last = np.ones(4, bool), np.array([0.0, 0.0, 1.0])
    assert p_selected(comparison, every, last) < p_averaged(comparison, every, last) < 0.5


@pytest.mark.parametrize(
    ("lengths", "observed", "value"),
    [
        (np.ones((2, 200, 3)), np.ones(4), r"\(4,\)"),
        (np.ones((1, 200, 3)), np.ones(3), "1 models"),
        (np.ones((2, 50, 3)), np.ones(3), "50 repetitions"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(lengths, observed, value):
    with pytest.raises(jc.InputError, match=value):
        compare(lengths, observed)
