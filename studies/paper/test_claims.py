"""Claims are judged in a world where they are known to be true, or made false one by one."""

import numpy as np
import pytest

from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv
from studies.frame.cases import pool_of
from studies.frame.yaml_files import PAPER_TABLE_3
from studies.paper.claims import HERTZ_EXCESS, NEGLIGIBLE, TOLERANCE
from studies.paper.judged_claims import Evidence, judge_claims
from tests.studied import study_of
from tests.world import ELASTICITIES, world

PAPER = read_csv(PAPER_TABLE_3)
TWO = {"study": {"rocks": ["dolerite", "slate"], "pool": 30}}
ONE = {"study": {"rocks": ["dolerite"], "pool": 30}}


def both_tables(study, pool, repetitions=200, paper=PAPER, pools=0):
    """Claims by number, and the margins that decide them; without the pool's error."""
    evidence = Evidence(study, pool, Design(), repetitions, 1, pools)
    claims, margins = judge_claims(evidence, paper)
    return claims.set_index("number"), margins


def judged(configuration, repetitions=10, **stated):
    """The table of claims of a pool in a world, by number; its study has the base case alone."""
    pool = world(pool_of(configuration), **stated)
    return both_tables(pool.isel(case=slice(1)), pool, repetitions)[0]


def changed(first=None, **second):
    """Other powers of the world, on its first cycle and on its second one."""
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
    shares, errors = table.found_share.dropna(), table.found_error.dropna()
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


def test_a_small_difference_is_none_and_few_surfaces_do_not_show_it():
    alike = judged(study_of(ONE), **changed(poisson_ratio=0.05 + 0.3 * TOLERANCE))
    assert alike.verdict["1a, cycle 2"] == "no difference"
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


def test_the_papers_own_table_is_judged_by_the_same_rules():
    table = judged(study_of({"study": {"pool": 4}}))
    found = table.paper_finds.dropna()
    # slate's JRC has the widest interval of cycle 2, and three entries of nu are below 0.1;
    # on cycle 1 limestone has none of E, and the shortest ones of dolerite are of JRC
    no = ["1a, cycle 2", "1b", "2b", "3, cycle 1", "3c"]
    assert set(found[no]) == {"no"}
    assert set(found.drop(no)) == {"yes"}
    assert "slate 3.18 (49 %)" in table.paper["4"]


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
