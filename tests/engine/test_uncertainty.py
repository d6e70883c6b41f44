"""Range of a closed joint over what the model leaves open."""

import numpy as np
import pandas as pd
import pytest
import scipy

import jointclosure as jc
from jointclosure.engine.budget import (
    ALL,
    CLOSURE_GROSS,
    CLOSURE_NET,
    NUMBERS,
    ORDER,
    QUANTITIES,
    SHARED,
    Source,
    ranges_of,
    total_indices,
)
from jointclosure.engine.uncertainty import (
    DRAWS,
    PLAUSIBLE,
    random_shares,
    sources_of,
    uncertainty_budget,
    variants_of,
)
from jointclosure.joint.curves import cycle_table
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import close_walls
from jointclosure.walls.scan_errors import ScanErrors
from studies.frame.yaml_files import read_plain
from tests.joints import DOLERITE, SPACING, pair
from tests.studied import ROOT

CONDITIONS = jc.Conditions(
    SPACING, DOLERITE, 2e6, 1, 0.2e6, choices=jc.Choices(strength_bound="none")
)
CLOSURE = next(iter(QUANTITIES))
MODULI = {"youngs_modulus": (50e9, 90e9)}


@pytest.fixture(scope="module")
def budget():
    return uncertainty_budget(*pair((20, 24)), CONDITIONS, MODULI, workers=1)


def test_total_indices_are_those_of_a_product():
    """Y = a b + e: sources act alone and as a pair, whose variance counts for both of them."""
    random = np.random.default_rng(0)
    a, b, e = (scale * random.standard_normal(10**6) for scale in (0.5, 0.3, 0.1))
    alone = {"a": a.var(), "b": b.var()}
    departures = ((1.0 + a) * (1.0 + b) + e - a - b).var()
    draws = {ORDER: np.array([-1.0, 1.0]) * 0.1}  # with that of the joint, a variance of 0.01
    indices, total = total_indices(alone, draws, departures), sum(alone.values()) + departures
    both = (a * b).var()
    assert indices["a"] == pytest.approx((alone["a"] + both) / total, rel=1e-3)
    assert indices["b"] == pytest.approx((alone["b"] + both) / total, rel=1e-3)
    assert indices[ORDER] == pytest.approx(0.01 / total, rel=1e-3)
    assert sum(indices.values()) == pytest.approx(1.0 + both / total, rel=1e-3)


def test_random_sources_have_no_more_than_the_departures_and_none_of_the_order():
    draws = {"noise": np.array([0.0, 2.0]), ORDER: np.array([1.0, np.nan])}
    indices = total_indices({"a": 1.0}, draws, 1.0)  # 2.0 - 0.5 of noise, 0.5 of the order
    assert indices == pytest.approx({"a": 0.5, "noise": 0.375, ORDER: 0.125})
    quiet = total_indices({"a": 1.0}, {"noise": np.array([3.0, 3.0])}, 0.0)
    assert quiet == {"a": 1.0, "noise": 0.0}
    assert np.isnan(total_indices({"a": 0.0}, {}, 0.0)["a"])  # nothing has a share in no range


def range_of(widths, scatter=0.0, seed=0):
    """The range of log(result/2) = sum of u width + noise, with u uniform in (-1, 1)."""
    sources = {name: Source((0.0, 1.0), "range") for name in widths}
    shares, further = (random_shares(sources, n, seed) for n in (DRAWS, 10_000))
    widest = np.array(list(widths.values()))
    noise = scatter * np.random.default_rng(seed).standard_normal(DRAWS)
    logs = [0.0, *(end for width in widest for end in (-width, width))]
    logs += list((2.0 * shares - 1.0) @ widest + noise)
    names = ["", *(name for name in widths for _ in "ab"), *[ALL] * DRAWS]
    values = dict.fromkeys(QUANTITIES, 2.0 * np.exp(logs))
    results = pd.DataFrame({"cycle": 1, "source": names} | values)
    return ranges_of(results, sources, shares, further).iloc[0]


def test_variants_of_another_tolerance_are_compared_with_the_joint_that_has_it():
    sources = {"breakage": Source((0, 1), SHARED), "a": Source((0.0, 1.0), "range")}
    shares, further = (random_shares(sources, n, 0) for n in (DRAWS, 10_000))
    shares[:, 0] = 0.0
    names = ["", "breakage", "a", "a", *[ALL] * DRAWS]
    changes = np.concatenate([[0.0, 0.0, -1.0, 1.0], 2.0 * shares[:, 1] - 1.0])

    def ends(factor, further):
        values = 2.0 * np.exp(changes) * np.where(np.array(names) == "", 1.0, factor)
        results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(QUANTITIES, values))
        return ranges_of(results, sources, shares, further).iloc[0][["median", "low", "high"]]

    without = further * [0.0, 1.0]
    np.testing.assert_allclose(ends(1.3, without), ends(1.0, without), rtol=1e-12)
    assert 1.03 < ends(1.3, further)["median"] / ends(1.0, further)["median"] < 1.27


def lower_end(*of):
    return float(np.log(range_of(*of).low / 2.0))


def test_departures_are_an_interaction_of_the_sources_that_act():
    linear, noise = range_of({"a": 1.0, "b": 2.0}), range_of({"a": 0.0, "b": 1.0}, 1.0)
    assert (linear.a, linear.b) == pytest.approx((0.2, 0.8), abs=1e-3)
    assert (noise.a, noise.b) == pytest.approx((0.0, 1.0))
    mixed = range_of({"a": 1.0, "b": 1.0}, np.sqrt(2.0 / 3.0))  # half of the variance by noise
    assert 1.2 < mixed.a + mixed.b < 1.8


def test_the_range_holds_nine_in_ten_of_the_random_results():
    assert lower_end({"a": 1.0}) == pytest.approx(-0.9, abs=1e-3)
    both = lower_end({"a": 1.0, "b": 1.0})  # the sum of both has a triangular density
    assert both == pytest.approx(-2.0 + np.sqrt(0.4), abs=0.03)
    noise = [lower_end({"a": 0.0}, 1.0, seed) for seed in range(40)]
    assert scipy.stats.norm.cdf(noise).mean() == pytest.approx(0.05, abs=0.02)


def test_ends_are_in_the_order_of_net_and_gross_and_not_below_zero():
    """As in each joint, though departures from the sum of the sources are of few joints."""
    sources = {"a": Source((0.0, 1.0), "range")}
    shares, further = (random_shares(sources, n, 0) for n in (DRAWS, 1000))
    random = np.random.default_rng(2)
    for _ in range(20):
        net = np.exp(random.standard_normal(DRAWS + 3))
        values = dict.fromkeys(QUANTITIES, net) | {CLOSURE_GROSS: net + random.random(net.size)}
        values["residual_closure_seated_net_mm"] = np.append([0.1, 0.0], np.exp(net[2:]) - 1.0)
        results = pd.DataFrame({"cycle": 1, "source": ["", "a", "a", *[ALL] * DRAWS]} | values)
        ends = ranges_of(results, sources, shares, further).loc[1][["low", "high"]]
        assert ends.loc["contact_at_max"].max() <= 1.0
        assert (ends.loc[CLOSURE_NET] <= ends.loc[CLOSURE_GROSS]).all()
        assert (ends.low >= 0.0).all()


def test_a_budget_has_results_of_all_joints_and_the_best(budget, small_joint):
    again = uncertainty_budget(*small_joint, CONDITIONS, MODULI, workers=2)
    pd.testing.assert_frame_equal(budget.results, again.results, check_exact=True)
    pd.testing.assert_frame_equal(budget.curves, again.curves, check_exact=True)
    drawn = budget.results[budget.results.source == ALL]
    assert len(drawn) == DRAWS
    assert drawn.value.is_unique
    for name in QUANTITIES:
        best, median, low, high = budget.ranges.loc[(1, name), NUMBERS]
        assert best == budget.results[name].iloc[0]
        assert low < median < high
    printed = str(budget)
    assert budget.text(1, CLOSURE) in printed
    assert budget.sentences()[-1] in printed


@pytest.mark.filterwarnings("ignore:All-NaN:RuntimeWarning")
def test_a_joint_that_fails_has_unknown_results_and_no_error(small_joint):
    load = {"max_normal_stress": 3e9, "effects": jc.Effects(gouge=False), "unusual_values": True}
    walls = [wall[:8, :8] for wall in small_joint]
    budget = uncertainty_budget(*walls, CONDITIONS._replace(**load))
    best = budget.results[budget.results.source == ""]
    assert (best.status >= FAILURE).all()
    assert best[CLOSURE].isna().all()


def test_random_values_fill_their_ranges():
    conditions = CONDITIONS.checked()
    sources = sources_of(conditions, (20, 24), MODULI)
    drawn = [v for v in variants_of(conditions, sources, 40) if v.source == ALL]
    ratios = np.sort([v.conditions.choices.peak_modulus_ratio for v in drawn])
    low, high = PLAUSIBLE["peak_modulus_ratio"]
    expected = low * (high / low) ** ((np.arange(40) + 0.5) / 40)
    np.testing.assert_allclose(ratios, expected, rtol=0.1)  # one in each part of equal probability
    moduli = [v.conditions.rock[0].youngs_modulus for v in drawn]
    assert 50e9 <= min(moduli) < 52e9 < 88e9 < max(moduli) <= 90e9
    for values in ([v.step for v in drawn], [v.conditions.choices.peaks for v in drawn]):
        assert [values.count(value) for value in set(values)] == [20, 20]


def test_each_source_is_varied_alone_to_its_plausible_values(budget, small_joint):
    results = budget.results.set_index(["source", "value"])[CLOSURE]
    alone = {
        ("", ""): CONDITIONS,
        ("peak_modulus_ratio", "0.2"): CONDITIONS._replace(
            choices=CONDITIONS.choices._replace(peak_modulus_ratio=0.2)
        ),
        ("breakage", "tolerance 0.02"): CONDITIONS._replace(
            numerics=jc.Numerics(breakage="resolved")
        ),
        ("youngs_modulus", "50 (GPa)"): CONDITIONS._replace(
            rock=DOLERITE._replace(youngs_modulus=50e9)
        ),
    }
    for variant, conditions in alone.items():
        closed = close_walls(*small_joint, conditions.checked())
        assert results[variant] == cycle_table(closed)[CLOSURE].iloc[0]
    assert budget.omitted == ("registration", "poisson_ratio", "compressive_strength")
    low, high = budget.ranges.loc[(1, CLOSURE), ["low", "high"]]
    assert low < results["", ""] < high


def test_variants_thin_out_and_copy_the_walls_themselves(small_joint):
    upper, lower = small_joint
    sources = sources_of(CONDITIONS, upper.shape)
    variants = {(v.source, v.value): v for v in variants_of(CONDITIONS, sources)}
    coarse = variants["spacing", "every 2. cell"]
    np.testing.assert_array_equal(coarse.walls(upper, lower, None)[0], upper[::2, ::2])
    assert coarse.conditions.spacing == 2 * SPACING
    copied = variants[ORDER, "mirrored"]
    np.testing.assert_array_equal(copied.walls(upper, lower, None)[1], lower[:, ::-1])
    assert copied.conditions == CONDITIONS
    elastic = CONDITIONS._replace(effects=jc.Effects(True, True, False, False, False))
    assert set(sources_of(elastic, upper.shape)) == {"spacing", "base_radius_in_cells"}


def test_errors_of_the_scans_are_drawn_anew_for_each_joint(small_joint):
    none = np.zeros(small_joint[0].shape, bool)
    covariance, middle = np.diag([1e-6, 0.01, 0.01]), np.array([12.0, 10.0])
    errors = ScanErrors(np.zeros(3), covariance, middle, (2e-6, 2e-6), none)
    sources = sources_of(CONDITIONS, none.shape, {}, errors)
    variants = list(variants_of(CONDITIONS, sources))
    assert len(variants) == 30
    walls = [v.walls(*small_joint, errors)[0] for v in variants if v.source == ALL and v.step == 1]
    assert len({wall.tobytes() for wall in walls}) == len(walls)
    budget = uncertainty_budget(*small_joint, CONDITIONS, errors=errors)
    assert "registration" not in budget.omitted
    assert (budget.ranges.loc[(1, CLOSURE), ["registration", "noise", ORDER]] >= 0.0).all()


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({"strength": (1.0, 2.0)}, "'strength': must be one of"),
        ({"youngs_modulus": (2e9, 1e9)}, "lowest value must come first"),
        (
            {"compressive_strength": (1e6, 2e6)},
            "compressive_strength_MPa = 1 to 2: must contain that",
        ),
        ({"peak_modulus_ratio": (0.1, 0.2)}, "must contain that of the joint, 0.05"),
        ({"youngs_modulus": (1e9,)}, "must be \\(lowest, highest\\)"),
        ({"peak_modulus_ratio": (0.1, 2.0)}, "peak_modulus_ratio = 2.0"),
        ({"spacing": (SPACING, 1.2 * SPACING)}, "must begin at the spacing"),
    ],
)
def test_ranges_that_cannot_be_are_refused_by_name(ranges, message):
    with pytest.raises(jc.InputError, match=message):
        sources_of(CONDITIONS, (20, 24), ranges)


def test_what_is_plausible_is_what_the_global_sensitivity_study_varies():
    inputs = read_plain(ROOT / "studies/global_sensitivity/global_sensitivity.yaml")[
        "global_sensitivity"
    ]["inputs"]
    studied = {
        about["key"].removeprefix("choices."): about.get("between", about.get("values"))
        for about in inputs.values()
        if about["key"].startswith("choices.")
    }
    del studied["largest_radius_mm"]  # it has no share of the variance of a closure
    assert {name: list(values) for name, values in PLAUSIBLE.items()} == studied
