"""Claims are judged in a world where they are true, or made false one by one."""

import numpy as np
import pytest

from jointclosure.joint.status import FAILURE
from jointclosure.statistics.quadratics import smoothed_by_all_levels
from jointclosure.statistics.repetitions import Design, DrawnResponse
from jointclosure.storage.files import read_csv
from studies.frame.cases import pool_of
from studies.frame.yaml_files import PAPER_TABLE_3
from studies.paper.claims import (
    E_MOST,
    HERTZ_EXCESS,
    NEGLIGIBLE,
    NU_LEAST,
    STRENGTH_NEXT,
    TARGET,
    TOLERANCE,
    Findings,
)
from studies.paper.judged_claims import ClosedModel, Evidence, judge_claims
from studies.paper.report.page_tables import percent_text
from studies.paper.responses import Levels, RockSample
from tests.studied import study_of
from tests.world import ELASTICITIES, world

PAPER = read_csv(PAPER_TABLE_3)
TWO = {"study": {"rocks": ["dolerite", "slate"], "pool": 30}}
ONE = {"study": {"rocks": ["dolerite"], "pool": 30}}


def both_tables(study, pool, repetitions=200, paper=PAPER, pools=0):
    """Return claims by number, and their margins, by default without the pool's error."""
    evidence = Evidence(study, pool, Design(), repetitions, 1, pools)
    claims, margins = judge_claims(evidence, paper)
    return claims.set_index("number"), margins


def judged(configuration, repetitions=10, **stated):
    """Return the claims of a pool in a known world by number; its study is the base case only."""
    pool = world(pool_of(configuration), **stated)
    return both_tables(pool.isel(case=slice(1)), pool, repetitions)[0]


def changed(first=None, **second):
    """Return other elasticities for the first and for the second cycle, as keywords of `world`."""
    return {"elasticities": {1: ELASTICITIES[1] | (first or {}), 2: ELASTICITIES[2] | second}}


@pytest.fixture(scope="module")
def true_world():
    configuration = study_of(TWO)
    return world(configuration), world(pool_of(configuration))


@pytest.fixture(scope="module")
def of_true(true_world):
    return both_tables(*true_world)


def test_what_is_true_of_the_model_stands_in_all_rocks(of_true):
    table, margins = of_true
    false = {"2b", "3, cycle 1", "3c"}  # JRC rules its first cycle; its scatter hides 5 %
    alike = "1a, cycle 2"  # JRC and Poisson's ratio hardly matter there, both
    assert set(table.verdict.drop([*false, alike, "8"])) == {"stands"}
    assert set(table.verdict[list(false)]) == {"falls"}
    assert table.verdict[[alike, "8"]].tolist() == ["no difference", "undecided"]
    of_claim = margins[(margins.number == "2a") & margins.decides].set_index("rock")
    assert of_claim.index.tolist() == ["dolerite", "slate"]
    # |e(E)| - |e(sigma_c)| of the world on its second cycle
    np.testing.assert_allclose(of_claim.value, 0.4, atol=5.0 * of_claim.standard_error.max())
    assert ((of_claim.low < of_claim.value) & (of_claim.value < of_claim.high)).all()
    shares = table.found_share.dropna()
    errors = table.found_error.dropna()
    np.testing.assert_allclose(errors, np.sqrt(shares * (1.0 - shares) / 200))


@pytest.mark.parametrize(
    ("falls", "stated"),
    [
        (
            ["1a, cycle 1", "1a, cycle 2", "1b"],
            changed(first={"poisson_ratio": 0.6}, poisson_ratio=0.5),
        ),
        (
            ["2a", "2a, net", "3, cycle 2", "5c"],
            changed(first={"jrc": -0.8}, compressive_strength=1.5),
        ),
        (["3, cycle 2", "4", "6a", "6b"], changed(jrc=1.2) | {"loop": -0.02, "power": 2.0}),
        (  # equal stresses close equally
            ["2c", "3b", "6a", "6b"],
            changed(youngs_modulus=-0.1, compressive_strength=0.05)
            | {"loop": 0.5 * NEGLIGIBLE, "power": 1.0},
        ),
        # a loop of rounding, of branches that are one curve
        (["5a", "5a, net", "6a"], changed(youngs_modulus=1.0) | {"loop": 1e-15}),
        (["5b", "5d"], changed(compressive_strength=-0.6, jrc=0.5)),
        # Poisson's ratio matters more than JRC by such a part of the tolerance
        (["1a, cycle 2"], changed(poisson_ratio=0.05 + 3.0 * TOLERANCE)),
    ],
)
def test_what_is_false_of_the_model_falls(falls, stated):
    assert set(judged(study_of(ONE), **stated).verdict[falls]) == {"falls"}


def test_a_small_difference_is_none():
    alike = judged(study_of(ONE), **changed(poisson_ratio=0.05 + 0.3 * TOLERANCE))
    assert alike.verdict["1a, cycle 2"] == "no difference"


def test_few_surfaces_do_not_show_a_small_difference():
    few = judged(study_of(ONE), irregular=0.4)
    assert few.verdict[["1a, cycle 2", "6a"]].tolist() == ["undecided", "stands"]


@pytest.mark.parametrize(
    ("number", "stated"),
    [
        ("3c", changed(compressive_strength=2.5)),  # 5 % of it are significant
        ("2b", changed(first={"youngs_modulus": -2.0})),
        ("5d", changed(jrc=-0.5)),  # a trend that is not there
    ],
)
def test_a_study_finds_what_is_plainly_true(of_true, number, stated):
    found = judged(study_of(ONE), 200, **stated).loc[number]
    assert (found.verdict, found.found_share > 0.9) == ("stands", True)
    assert of_true[0].found_share[number] < 0.9


@pytest.mark.parametrize(
    ("lengths", "found"),
    [  # of nu, E, sigma_c, JRC in percent of the rock's value, by the claims that they confirm
        ((9.0, 1.0, 2.0, 3.0), {"1a", "2a", "3"}),
        ((np.inf, 1.0, np.inf, np.inf), {"1a", "2a"}),  # nothing is next
        ((np.inf, 1.0, 2.0, np.inf), {"1a", "2a", "3"}),
        ((np.inf, np.inf, 2.0, np.inf), {"1a"}),  # and E is not the most sensitive
        ((np.inf,) * 4, set()),  # without any significant change nothing is ranked
        ((9.0, 1.0, 1.0, 3.0), {"1a", "2a"}),
        ((2.0, 1.0, 1.5, 9.0), {"2a", "3"}),
    ],
)
def test_lengths_without_an_end_rank_nothing_before_those_with_one(lengths, found):
    levels = np.array([0.5, 1.0, 1.5])
    none = np.full((1, 1, 3), np.nan)
    names = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
    drawn = {
        ("slate", name): DrawnResponse(levels, 1.0, none, none, np.array([[0.01 * length]]))
        for name, length in zip(names, lengths, strict=True)
    }
    studies = Findings(drawn, ((TARGET, 2),))
    ranked = {"1a": NU_LEAST, "2a": E_MOST, "3": STRENGTH_NEXT}
    confirmed = {name for name, one in ranked.items() if one.finds(studies, "slate", 2, TARGET)[0]}
    assert confirmed == found


def test_the_papers_own_table_is_judged_by_the_same_rules():
    table = judged(study_of({"study": {"pool": 4}}))
    found = table.paper_finds.dropna()
    # slate's JRC has the widest interval of cycle 2, and three entries of nu are below 0.1;
    # on cycle 1 limestone has none of E, and the shortest ones of dolerite are of JRC
    no = ["1a, cycle 2", "1b", "2b", "3, cycle 1", "3c"]
    assert set(found[no]) == {"no"}
    assert set(found.drop(no)) == {"yes"}
    assert "slate 3.18 (49 %)" in table.paper["4"]


NO_RANK = {"poisson_ratio": None, "jrc": None}  # no claims on all four properties
THREE_LEVELS = {
    "study": {"rocks": ["dolerite"], "pool": None, "realizations": 20},
    "rocks": {"dolerite": {"levels": NO_RANK}},
}
MANY_LEVELS = {
    "study": THREE_LEVELS["study"],
    "rocks": {
        "dolerite": {
            "levels": {
                "youngs_modulus_GPa": [70, 72, 74, 76, 79, 80, 82, 84, 85],
                "compressive_strength_MPa": [150, 154, 158, 162, 168, 170, 172, 176, 180],
                **NO_RANK,
            }
        }
    },
}
TRENDS = ["5a", "5a, net", "5b"]


def test_with_ten_levels_a_trend_is_found_more_often_than_with_three():
    common = {"study": {"draws": "common"}}  # so that the pools have the same trends
    three = study_of(THREE_LEVELS, common)
    ten = study_of(MANY_LEVELS, common)
    assert len(ten.rocks["dolerite"].levels["youngs_modulus"]) == 10
    tables = [both_tables(world(c), world(c))[0] for c in (three, ten)]
    fewer, more = (table.found_share[TRENDS] for table in tables)
    assert (more >= fewer).all()
    assert more.min() > fewer.min()
    assert tables[1].found_here[TRENDS].tolist() == ["yes"] * 3


def test_ten_levels_of_few_surfaces_show_a_trend_with_less_error_than_three():
    errors = []
    for configuration in (study_of(THREE_LEVELS), study_of(MANY_LEVELS)):
        dataset = world(configuration)
        table, margins = both_tables(dataset, dataset, 1)
        rows = margins[margins.number.isin(TRENDS)]
        errors.append(rows.set_index(["number", "quantity"]).standard_error)
        assert "falls" not in set(table.verdict[TRENDS])
    assert (errors[1] < errors[0]).all()
    common = study_of(MANY_LEVELS, {"study": {"draws": "common"}})
    dataset = world(common, irregular=0.03)  # single steps of the levels turn
    assert set(both_tables(dataset, dataset, 1)[0].verdict[["5a", "5a, net"]]) == {"stands"}


def test_a_response_that_turns_within_the_levels_is_no_trend():
    dataset = world(study_of(MANY_LEVELS, {"study": {"draws": "common"}}))
    stiffer = np.maximum(dataset.youngs_modulus / 78e9, 1.0)
    for name in ("max_closure", "max_closure_net"):
        dataset[name] = dataset[name] * stiffer**3  # 2 instead of -1 above the rock's value
    table, margins = both_tables(dataset, dataset, 1)
    assert set(table.verdict[["5a", "5a, net"]]) == {"falls"}
    assert table.found_here["5a"] == "no"
    values = margins[margins.number == "5a"].set_index("quantity").value
    assert values["fall with E, lower half of the levels"] > 0.5
    assert values["fall with E, upper half of the levels"] < -1.0


def test_three_levels_are_judged_by_their_own_means():
    levels = np.array([1.0, 3.0, 4.0])
    means = np.array([[0.1, 0.3, 0.7]])
    three, smoothed = smoothed_by_all_levels(levels, means, 3.0)
    np.testing.assert_array_equal(three, levels)
    np.testing.assert_array_equal(smoothed, means)


@pytest.mark.parametrize("count", [3, 10])
def test_many_models_at_once_have_the_numbers_of_each_alone(count):
    levels = np.linspace(0.5, 1.5, count)
    levels[count // 2] = 1.0
    values = np.random.default_rng(1).uniform(1.0, 2.0, (1, count, 5))
    cases = np.roll(np.arange(count), count // 2)  # case 0 is that of the rock's value
    sample = RockSample(
        "rock", ((TARGET, 1),), {"youngs_modulus": Levels(levels, cases, 1.0)}, values, True
    )
    means = np.moveaxis(values, -1, 0)

    def numbers(means):
        model = ClosedModel(sample, means, 1.0)
        return [
            model.elasticity("youngs_modulus", 1, TARGET),
            model.change("youngs_modulus", 1, 0.1),
            model.share(TARGET, 1),
            *model.slopes("youngs_modulus", 1, TARGET),
        ]

    alone = [numbers(one) for one in means]
    np.testing.assert_allclose(np.transpose(numbers(means)), alone, rtol=1e-12)


def test_failed_realisations_never_enter(true_world):
    dolerite = [dataset.isel(case=dataset.rock == "dolerite") for dataset in true_world]
    clean, spoilt = ([dataset.copy(deep=True) for dataset in dolerite] for _ in range(2))
    for dataset in (*clean, *spoilt):
        dataset["status"][:, 3] = FAILURE
    for dataset in spoilt:
        for name in ("max_closure", "max_closure_net", "closure"):
            dataset[name][:, 3] = 1e3
    left = [dataset.isel(realization=dataset.realization.values != 3) for dataset in clean]
    one, other, without = (both_tables(*pair, repetitions=20) for pair in (clean, spoilt, left))
    assert one[0].equals(other[0])
    assert one[1].equals(other[1])
    assert one[1].equals(without[1])


def test_the_excess_at_low_stress_is_that_of_hertz():
    pool = world(pool_of(study_of(ONE)), power=2.0 / 3.0).isel(case=slice(1))
    margins = both_tables(pool, pool, 1)[1]
    np.testing.assert_allclose(margins.value[margins.number == "6b"], HERTZ_EXCESS, atol=1e-3)


def test_other_rocks_are_asked_without_the_papers_figures():
    paper = PAPER[PAPER.rock == "limestone"]
    without = {"rocks": {"dolerite": {"levels": {"poisson_ratio": None}}}}
    pool = world(pool_of(study_of(ONE, without)))
    table = both_tables(pool, pool, 100, paper)[0]
    assert not {"paper", "paper_finds"} & set(table.columns)
    # without Poisson's ratio nothing is ranked
    others = ["2c", "3b", "3c", "4", "5a", "5a, net", "5b", "5c", "5d", "6a", "6b"]
    assert table.index.tolist() == others


@pytest.mark.parametrize(
    ("shares", "text"),
    [
        ((0.98, 0.05, 0.88, 1.0), "98 % (88 to 100)"),
        ((0.999, 0.004), "100 % (99.1 to 100)"),
        ((0.01, 0.02), "1 % (0 to 5)"),
        ((1.0, 0.0, 0.96, 1.0), "100 % (96 to 100)"),
        ((0.5, 0.0), "50 %"),
        ((np.nan, np.nan), ""),
    ],
)
def test_shares_in_the_report_have_intervals_within_0_and_100_percent(shares, text):
    assert percent_text(*shares) == text
