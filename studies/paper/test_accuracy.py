"""Accuracy of a study by two levels: results, their intervals, and what `make study` does next."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.engine.assess import FINEST
from jointclosure.inputs import InputError
from jointclosure.statistics.two_level import t_interval
from studies.frame.cases import closed_keys
from studies.frame.closing import Ensemble
from studies.frame.keys import Accuracy
from studies.paper.accuracy import (
    START,
    Counts,
    next_counts,
    reached_table,
    start_counts,
)
from studies.paper.claims import TARGET
from studies.paper.responses import responses
from tests.studied import checked_study, study_of
from tests.world import ELASTICITIES, world

LEVELS = {"poisson_ratio": None, "compressive_strength_MPa": None, "jrc": None}


def slate(surfaces, seed=1, draws="independent", elasticity=-1.0):
    """A rock with three levels of E whose truth is known."""
    study = {"rocks": ["slate"], "realizations": surfaces, "root_seed": seed, "draws": draws}
    rocks = {"slate": {"levels": LEVELS}}
    known = ELASTICITIES[2] | {"youngs_modulus": elasticity}
    closed = world(study_of({"study": study, "rocks": rocks}), {1: known, 2: known})
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
    assert (table.surfaces == 40).all()
    assert (table.differences == 12).all()
    closures, finer = (1e3 * part.max_closure.values[0, :, 0] for part in (study, finest))
    row = table.iloc[0]
    assert row.value == pytest.approx(closures.mean() + (finer - closures[:12]).mean())
    assert row.study_value == pytest.approx(closures.mean())
    assert row.low < row.value < row.high
    assert row.half_width_percent == pytest.approx(50.0 * (row.high - row.low) / row.value)
    assert (table.met == (table.half_width_percent <= 10.0)).all()
    # without any difference it is the interval of the surfaces, but for degrees of freedom
    same = reached_closures(study, study.isel(realization=slice(38)), 0.1)
    alone = t_interval(closures)
    assert same.value[0] == pytest.approx(alone.value)
    assert same.high[0] == pytest.approx(alone.high, rel=0.01)


def test_failed_joints_of_either_level_are_left_out_and_few_differences_never_suffice():
    study, bad = slate(20), np.zeros((3, 20), dtype=np.int16)
    bad[0, [1, 15]] = 16
    study = study.assign(status=(("case", "realization"), bad))
    finest = refined(slate(20), 9)
    failed = np.zeros((3, 9), dtype=np.int16)
    failed[0, 4] = 16
    finest = finest.assign(status=(("case", "realization"), failed))
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
    truth = {
        r.cycle: 100.0 * r.interval(0.05, 100).length / r.base for r in responses(whole, TARGET)
    }
    wish, covered = Accuracy(within=0.5, of="interval"), []
    for seed in range(12):
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


def rows(needed, differences=8, half=9.0, least=4.0):
    return pd.DataFrame(
        {
            "rock": "slate", "parameter": "base", "level": "base", "cycle": 1, "surfaces": 10,
            "quantity": "max_closure",
            "differences": 8, "surfaces_needed": needed, "differences_needed": differences,
            "half_width_percent": half, "met": [need <= 10 for need in needed],
            "least_percent": least, "surface_core_minutes": 1.0, "difference_core_minutes": 4.0,
        }
    )  # fmt: skip


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
    price = pd.DataFrame(
        {"ensemble": ["cases", "finest"], "rock": "slate", "cases": 9, "seconds": [2.0, 20.0]}
    )

    def start(minutes):
        return start_counts(price, Accuracy(within=0.05, budget_core_minutes=minutes))

    assert start(28.0) == START
    assert start(20.0) == (5, 4)
    assert start(7.0) == (2, 2)
    words = "must be at least 6.6, for 2 surfaces of all 9 cases; a joint takes up to 2 s"
    with pytest.raises(InputError, match=re.escape(words)):
        start(6.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"numerics": {"breakage": "resolved", "tolerance": 0.001}}, "tolerance = 0.001: must"),
        ({"statistics": {"control_variates": 150}}, "control_variates = 150: must be more"),
        ({"study": {"accuracy": {"within": 1.5}}}, "study.accuracy.within = 1.5: must be below 1"),
        ({"study": {"accuracy": {"within": 0.1, "of": "median"}}}, "mean, interval, stiffness"),
    ],
)
def test_a_request_that_cannot_be_is_refused(changes, words):
    with pytest.raises(InputError, match=re.escape(words)):
        checked_study({"study": {"accuracy": {"within": 0.1}}}, changes)


def test_a_mean_stiffness_is_harmonic_and_its_interval_in_order():
    study = slate(40)
    finest = refined(study, 12)
    table = reached_table(study, finest, Accuracy(within=0.1, of="stiffness"), 0.05)
    closures = reached_closures(study, finest, 0.1)
    assert (table.low < table.value).all()
    assert (table.value < table.high).all()
    np.testing.assert_allclose(table.half_width_percent, closures.half_width_percent)
    np.testing.assert_allclose(table.value * closures.value, 1.0)  # in MPa/mm and mm


def test_the_finest_joints_are_the_first_of_each_case_with_all_effects():
    study = {"rocks": ["slate"], "realizations": 25, "pool": None, "accuracy": {"within": 0.1}}
    whole = checked_study({"study": study, "effects": {"auto": 0.05}, "flow": True})
    cases, finest = (Ensemble(whole.typed, name) for name in ("cases", "finest"))
    assert [len(block) for block in cases.blocks] == [10, 10, 5]
    assert [len(block) for block in finest.blocks] == [4, 4]
    one, other = (part.settings("slate-jrc-low", range(2)) for part in (cases, finest))
    assert other.surfaces == one.surfaces
    assert other.numerics == FINEST != one.numerics
    assert cases.pilots(Path()).keys() == {"slate"}
    assert finest.pilots(Path()) == {}
    plain = checked_study({"study": study | {"accuracy": None}})
    assert closed_keys(whole.keys)["study"].keys() == plain.keys["study"].keys() - {"accuracy"}
    assert len(Ensemble(plain.typed).blocks) == 1
