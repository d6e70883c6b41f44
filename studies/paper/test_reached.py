"""What a study reached of the accuracy wanted, from its own scatter, and the surfaces missing."""

import numpy as np
import pandas as pd
import pytest
import scipy.stats

from jointclosure.statistics.total_error import REACH, Bias
from studies.frame.config.wanted import BLOCK, PresetErrors, Wanted
from studies.paper.claims import TARGET
from studies.paper.closures import max_closure_table
from studies.paper.planning import Goal, reached_table, surfaces_for, surfaces_next
from studies.paper.responses import responses
from studies.paper.world import world

BIASES = {1: Bias(0.02), 2: Bias(-0.01, 0.005)}
AT = "somewhere"
ROCKS = ("dolerite", "siltstone", "limestone", "slate")


@pytest.fixture(scope="module")
def study():
    return world()


def known(biases):
    """The same errors for every rock."""
    return dict.fromkeys(ROCKS, PresetErrors(biases, AT))


def wanted(of="mean", within=0.05, most=1000):
    return Wanted(of, within, most, None)


def test_total_errors_of_means_are_the_presets_bias_and_the_studys_own_interval(study):
    table = reached_table(study, None, wanted(), known(BIASES), 0.05)
    own = max_closure_table(study)
    error = own.max_closure_mean_mm_standard_error / own.max_closure_mean_mm
    students = scipy.stats.t.ppf(0.975, own.samples.to_numpy() - 1)
    assert table.sampling_percent.to_numpy() == pytest.approx(100.0 * students * error.to_numpy())
    size = 100.0 * table.cycle.map({1: 0.02, 2: 0.01})
    known_to = 100.0 * REACH * table.cycle.map({1: 0.0, 2: 0.005})
    total = size + np.hypot(known_to, table.sampling_percent)
    assert np.allclose(table.total_percent, total)
    assert set(table.bias_known_at) == {AT}
    assert (table.met == (table.total_percent <= 5.0)).all()
    # the number that is needed gives what is wanted, by the square root of numbers
    some = table[table.surfaces_needed > 2]
    assert len(some)
    ratio = REACH / scipy.stats.t.ppf(0.975, some.surfaces - 1)
    left = ratio * some.sampling_percent * np.sqrt(some.surfaces / some.surfaces_needed)
    assert (size[some.index] + np.hypot(known_to[some.index], left) <= 5.0 + 1e-9).all()


def test_surfaces_that_intervals_need_are_those_of_the_plan(study):
    table = reached_table(study, None, wanted("interval", 0.2), known({2: Bias(0.0)}), 0.05)
    assert set(table.cycle) == {2}  # of the first nothing is known
    for row, response in zip(
        table.itertuples(), [r for r in responses(study, TARGET) if r.cycle == 2], strict=True
    ):
        wish = Goal("width", 0.4)
        assert row.surfaces_needed == surfaces_for(response, wish, 0.05, response.paired)


def test_a_bias_that_is_larger_than_what_is_wanted_is_never_met(study):
    table = reached_table(study, None, wanted("interval", 0.2), known({2: Bias(0.3)}), 0.05)
    assert not table.met.any()
    assert np.isinf(table.surfaces_needed).all()


def rows(*needed, surfaces=20):
    return pd.DataFrame(
        {
            "rock": "slate", "parameter": "base", "level": "base", "cycle": 1,
            "surfaces": surfaces, "surfaces_needed": needed,
            "met": [each <= surfaces for each in needed],
            "total_percent": np.arange(1.0, 1.0 + len(needed)),
        }
    )  # fmt: skip


def test_surfaces_are_added_in_blocks_until_all_is_met_or_the_most_are_there():
    assert surfaces_next(rows(5, 12), wanted()) is None
    assert surfaces_next(rows(5, 33), wanted()) == 40
    assert surfaces_next(rows(5, 21), wanted()) == 30
    assert surfaces_next(rows(5, np.inf), wanted(most=70)) == 70
    assert surfaces_next(rows(5, np.inf, surfaces=70), wanted(most=70)) is None
    # failed realisations are in no count: a block more is asked for all the same
    assert surfaces_next(rows(40, surfaces=38), wanted()) == 40 + BLOCK
