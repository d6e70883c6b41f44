"""Range of a closed joint over what the model leaves open."""

import functools

import numpy as np
import pandas as pd
import pytest
import scipy

import jointclosure as jc
from jointclosure.cli.command_results import summary
from jointclosure.ensembles.quantities import CURVES
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.cycle_results import largest_jump, net_responses
from jointclosure.joint.interpolation import monotone_curve
from jointclosure.joint.laws import laws_of_joint
from jointclosure.joint.load import stated_load
from jointclosure.joint.result_tables import ENDS, cycle_table, stress_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import FAILURE
from jointclosure.plotting.joint import engineering_figure, range_figure
from jointclosure.uncertainty import budget as budget_module
from jointclosure.uncertainty import ranges as ranges_module
from jointclosure.uncertainty.budget import Budget, uncertainty_budget
from jointclosure.uncertainty.numerical_error import (
    differences_of_loading,
    limits_of_error,
    log_change,
    log_scatter,
    numerical_error,
    numerical_errors_of,
)
from jointclosure.uncertainty.ranged_results import (
    APERTURE,
    CLOSURE_GROSS,
    CLOSURE_NET,
    KNI,
    RANGED_RESULTS,
    RESIDUAL_NET,
    STIFFNESS,
    VM,
)
from jointclosure.uncertainty.ranges import (
    NUMBERS,
    WIDENED,
    WIDENED_OTHERS,
    WIDER,
    bands_of,
    ranges_of,
    total_indices,
)
from jointclosure.uncertainty.sources import (
    ALL,
    ORDER,
    OTHER_RULE,
    PLAUSIBLE,
    SHARED,
    VARIED,
    Source,
    coarser,
    sources_of,
)
from jointclosure.uncertainty.uncertain_joint import (
    threads_for,
    uncertain_joint,
)
from jointclosure.uncertainty.variants import RANDOM_JOINTS, SEED, random_positions, variants_of
from jointclosure.walls.scan_errors import ScanErrors
from studies.frame.yaml_files import read_plain
from tests.joints import DOLERITE, SPACING, pair
from tests.studied import ROOT

CONDITIONS = jc.Conditions(
    SPACING, DOLERITE, 2e6, 1, 0.2e6, choices=jc.Choices(strength_bound="none")
).checked()
CLOSURE = next(iter(RANGED_RESULTS))
MODULI = {"youngs_modulus": (50e9, 90e9)}


NO_LAWS = laws_of_joint(2.0, 165e6, 0.2e6, 1)


@functools.cache
def budget_joint():
    return simulate_walls(*pair((20, 24)), CONDITIONS)


@pytest.fixture(scope="module")
def budget():
    return uncertainty_budget(uncertain_joint(*pair((20, 24)), CONDITIONS, MODULI), workers=1)


def test_bands_with_other_choices_contain_those_of_nine_in_ten(budget):
    curves = budget.curves
    names = [name for name in CURVES if f"{name}_low" in curves]
    for name in names:
        ends = [f"{name}_{end}" for end in (WIDER[0], *ENDS, WIDER[1])]
        known = curves[ends].dropna()
        assert len(known)
        assert (np.diff(known, axis=1) >= 0.0).all(), name
        assert (known[ends[3]] - known[ends[0]] > known[ends[2]] - known[ends[1]]).any(), name


@pytest.mark.parametrize("branch", ["loading", "unloading"])
@pytest.mark.parametrize(
    ("curve", "result"),
    [("closure_net_since_seating_mm", CLOSURE_NET), ("mean_aperture_mm", APERTURE)],
)
def test_a_result_has_one_range_in_the_table_and_at_the_end_of_its_band(
    budget, curve, result, branch
):
    curves = budget.curves
    along = curves[curves.branch == branch]
    row = budget.ranges.loc[1, result]
    for end in (*ENDS, *WIDER):
        band = along[f"{curve}_{end}"]
        assert band.iloc[-1] == row[end]
        assert (np.diff(band) * (1.0 if CURVES[curve][1] else -1.0) >= 0.0).all()


def test_named_stresses_have_ranges_with_other_choices_too(budget):
    text, answer = summary(budget_joint(), NO_LAWS, budget.curves, budget, [2e6])
    (row,) = answer["at_with_other_choices"]
    (usual,) = answer["at"]
    title = CURVES["closure_net_since_seating_mm"][0]
    at_maximum = budget.curves[budget.curves.branch == "loading"].iloc[-1]
    low, high = (at_maximum[f"closure_net_since_seating_mm_{end}"] for end in WIDER)
    assert [float(end) for end in row[title].split(" to ")] == pytest.approx([low, high], rel=0.1)
    # the result at the maximum stress has the same text in the table
    assert row[title] == answer["with_other_choices"]["cycle 1"][RANGED_RESULTS[CLOSURE_NET]]
    assert row["cycle"] == usual["cycle"]
    assert f"The same, {budget.wider_title()}" in text
    single = summary(budget_joint(), NO_LAWS, stress_table(budget_joint()), None, [2e6])[1]
    assert single["at_with_other_choices"] == []


def test_small_results_are_seen_beside_large_ones(budget):
    ranges = budget.ranges.copy()
    least = 0.01 * ranges.loc[(1, CLOSURE_NET), WIDER[0]]
    ranges.loc[(1, CLOSURE_NET), WIDER[0]] = least
    axes = range_figure(budget._replace(ranges=ranges), "a joint").axes[0]
    assert axes.get_xscale() == "log"
    assert "logarithmic" in axes.get_xlabel()
    assert 0.5 * least < axes.get_xlim()[0] < least


def test_bands_with_other_choices_are_drawn_and_named(budget):
    figure = engineering_figure(budget_joint(), "a joint", budget.curves)
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert "cycle 1, with other choices of the model" in names


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


def test_random_sources_have_no_more_than_the_departures():
    draws = {"noise": np.array([0.0, 2.0]), ORDER: np.array([1.0, np.nan])}
    indices = total_indices({"a": 1.0}, draws, 1.0)  # 2.0 - 0.5 of noise, 0.5 of the order
    assert indices == pytest.approx({"a": 0.5, "noise": 0.375, ORDER: 0.125})


def test_random_sources_without_scatter_have_no_more_than_nothing():
    quiet = total_indices({"a": 1.0}, {"noise": np.array([3.0, 3.0])}, 0.0)
    assert quiet == {"a": 1.0, "noise": 0.0}


def test_total_indices_of_a_range_of_nothing_are_unknown():
    assert np.isnan(total_indices({"a": 0.0}, {}, 0.0)["a"])


def test_a_source_that_is_fixed_in_the_random_joints_has_no_part_in_their_departures():
    """Otherwise a choice of the model had the interactions of others, and a share like theirs."""
    alone = {"a": 1.0, "b": 1.0, "choice": 1.0}
    indices = total_indices(alone, {}, 3.0, fixed={"choice"})
    assert indices == pytest.approx({"a": 4.0 / 6.0, "b": 4.0 / 6.0, "choice": 1.0 / 6.0})
    one = {ORDER: np.array([-1.0, 1.0])}
    indices = total_indices({"a": 1.0, "choice": 1.0}, one, 4.0, fixed={"choice"})
    assert indices == pytest.approx({"a": 4.0 / 6.0, "choice": 1.0 / 6.0, ORDER: 1.0 / 6.0})
    assert total_indices({"choice": 1.0}, {}, 1.0, fixed={"choice"}) == {"choice": 1.0}


def range_of(widths, scatter=0.0, seed=0):
    """The range of log(result/2) = sum of u width + noise, with u uniform in (-1, 1)."""
    sources = {name: Source((0.0, 1.0), "range") for name in widths}
    positions, further = (random_positions(sources, n, seed) for n in (RANDOM_JOINTS, 10_000))
    widest = np.array(list(widths.values()))
    noise = scatter * np.random.default_rng(seed).standard_normal(RANDOM_JOINTS)
    logs = [0.0, *(end for width in widest for end in (-width, width))]
    logs += list((2.0 * positions - 1.0) @ widest + noise)
    names = ["", *(name for name in widths for _ in "ab"), *[ALL] * RANDOM_JOINTS]
    values = dict.fromkeys(RANGED_RESULTS, 2.0 * np.exp(logs))
    results = pd.DataFrame({"cycle": 1, "source": names} | values)
    return ranges_of(results, sources, positions, further).iloc[0]


def test_variants_of_another_tolerance_are_compared_with_the_joint_that_has_it():
    sources = {"breakage": Source((0, 1), SHARED), "a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 10_000))
    positions[:, 0] = 0.5
    names = ["", "breakage", "a", "a", *[ALL] * RANDOM_JOINTS]
    changes = np.concatenate([[0.0, 0.0, -1.0, 1.0], 2.0 * positions[:, 1] - 1.0])

    def ends(factor, further):
        values = 2.0 * np.exp(changes) * np.where(np.array(names) == "", 1.0, factor)
        results = pd.DataFrame(
            {"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, values)
        )
        return ranges_of(results, sources, positions, further).iloc[0][["low", "high"]]

    without = further * [0.0, 1.0] + [0.5, 0.0]
    np.testing.assert_allclose(ends(1.3, without), ends(1.0, without), rtol=1e-12)
    wider = ends(1.3, further) / ends(1.0, further)  # the error of steps has either sign
    assert 1.0 / 1.3 < wider.low < 0.97
    assert 1.03 < wider.high < 1.3


@pytest.fixture
def as_sources_make_it(monkeypatch):
    """Ranges as wide as the sources make them, without the factor of their width."""
    monkeypatch.setattr(ranges_module, "WIDENED_OTHERS", 1.0)


def lower_end(*of):
    return float(np.log(range_of(*of).low / 2.0))


def test_departures_are_an_interaction_of_the_sources_that_act():
    linear, noise = range_of({"a": 1.0, "b": 2.0}), range_of({"a": 0.0, "b": 1.0}, 1.0)
    assert (linear.a, linear.b) == pytest.approx((0.2, 0.8), abs=1e-3)
    assert (noise.a, noise.b) == pytest.approx((0.0, 1.0))
    mixed = range_of({"a": 1.0, "b": 1.0}, np.sqrt(2.0 / 3.0))  # half of the variance by noise
    assert 1.2 < mixed.a + mixed.b < 1.8


@pytest.mark.usefixtures("as_sources_make_it")
def test_the_range_holds_nine_in_ten_of_the_random_results():
    assert lower_end({"a": 1.0}) == pytest.approx(-0.9, abs=1e-3)
    both = lower_end({"a": 1.0, "b": 1.0})  # the sum of both has a triangular density
    assert both == pytest.approx(-2.0 + np.sqrt(0.4), abs=0.03)
    noise = [lower_end({"a": 0.0}, 1.0, seed) for seed in range(40)]
    assert scipy.stats.norm.cdf(noise).mean() == pytest.approx(0.05, abs=0.02)


@pytest.mark.usefixtures("as_sources_make_it")
def test_both_ends_leave_out_a_twentieth():
    for widths in ({"a": 1.0}, {"a": 0.5, "b": 2.0}):
        found = range_of(widths)
        positions = random_positions(widths, 10_000, 0)
        exact = 2.0 * np.exp((2.0 * positions - 1.0) @ np.array(list(widths.values())))
        for end, part in (("low", 0.05), ("high", 0.95)):
            assert found[end] == pytest.approx(np.quantile(exact, part), rel=1e-6)


def of_equal_departures():
    """Results of 16 random joints that lie 1 off on either side of the best, in logarithms."""
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (16, 1000))
    logs = np.array([0.0, 0.0, 0.0, *np.tile([-1.0, 1.0], 8)])
    return sources, positions, further, ["", "a", "a", *[ALL] * 16], 2.0 * np.exp(logs)


@pytest.mark.usefixtures("as_sources_make_it")
def test_departures_have_the_variance_of_a_further_joint():
    """Student's t of a sample of n about its mean: s^2 (1 + 1/n), with s^2 = 16/15 and n = 16."""
    sources, positions, further, names, values = of_equal_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, values))
    ends = ranges_of(results, sources, positions, further).iloc[0]
    half = np.log(ends[["low", "high"]].astype(float) / 2.0)
    scale = np.sqrt(16.0 / 15.0 * (1.0 + 1.0 / 16.0))
    np.testing.assert_allclose(np.abs(half), scale * scipy.stats.t.ppf(0.95, 15), rtol=5e-3)


def test_a_band_is_as_wide_as_the_range_of_the_same_results():
    sources, positions, further, names, values = of_equal_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, values))
    ends = ranges_of(results, sources, positions, further).loc[(1, CLOSURE)]
    name, place = "closure_net_since_seating_mm", {"cycle": 1, "branch": "loading"}
    curves = [
        pd.DataFrame(place | {"normal_stress_MPa": stress, "source": names, name: part * values})
        for stress, part in ((0.5, 0.0), (1.0, 0.5), (2.0, 1.0))
    ]
    bands = bands_of(pd.concat(curves), sources, positions, further)
    for number in ("low", "high"):
        expected = np.array([0.0, 0.5, 1.0]) * ends[number]
        np.testing.assert_allclose(bands[f"{name}_{number}"], expected, rtol=1e-12, atol=1e-12)


APERTURE = "mean_aperture_at_max_mm"


@pytest.fixture(scope="module")
def half_widths():
    """Logarithmic widths of the ranges of two cycles with equal departures."""
    sources, positions, further, names, values = of_equal_departures()
    results = pd.concat(
        pd.DataFrame({"cycle": cycle, "source": names} | dict.fromkeys(RANGED_RESULTS, values))
        for cycle in (1, 2)
    )
    widths = np.log(ranges_of(results, sources, positions, further)[["low", "high"]].astype(float))
    return widths.high - widths.low


def test_ranges_are_widened_by_the_factors_that_pairs_of_known_truth_needed(half_widths):
    """They are those of results on all cycles, on the scale of the range."""
    alone = half_widths[1, CLOSURE] / WIDENED_OTHERS
    *_, values = of_equal_departures()
    changes = np.log(values[3:] / values[0])
    scale = np.sqrt((1.0 + 1.0 / changes.size) * changes.var(ddof=1))
    assert alone == pytest.approx(2.0 * scale * scipy.stats.t.ppf(0.95, 15), rel=5e-3)
    for cycle in (1, 2):
        assert half_widths[cycle, STIFFNESS] == pytest.approx(WIDENED_OTHERS * alone)
        assert half_widths[cycle, APERTURE] == pytest.approx(WIDENED["aperture"] * alone)


def test_bands_of_apertures_are_wider_as_their_ranges(half_widths):
    sources, positions, further, names, values = of_equal_departures()
    place, name = {"cycle": 1, "branch": "loading"}, "mean_aperture_mm"
    curves = [
        pd.DataFrame(place | {"normal_stress_MPa": stress, "source": names, name: part * values})
        for stress, part in ((0.5, 3.0), (1.0, 2.0), (2.0, 1.0))
    ]
    bands = bands_of(pd.concat(curves), sources, positions, further)
    of_band = np.log(bands[f"{name}_high"] / bands[f"{name}_low"])
    np.testing.assert_allclose(of_band, half_widths[1, APERTURE], rtol=1e-9)


NUMERICAL_LIMITS = {(1, CLOSURE): 0.2, (1, STIFFNESS): 0.0001}


def of_close_departures():
    """As `of_equal_departures`, in a narrow range."""
    *about, values = of_equal_departures()
    return *about, 2.0 * (values / 2.0) ** 0.01


@pytest.fixture(scope="module")
def limited_ranges():
    """Narrow ranges without and with the limits of the numerical error."""
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    given = results, sources, positions, further
    return ranges_of(*given), ranges_of(*given, NUMERICAL_LIMITS)


def test_ranges_contain_the_limit_of_the_numerical_error(limited_ranges):
    _, ranges = limited_ranges
    for low, high in (("low", "high"), WIDER):
        assert ranges.loc[(1, CLOSURE), [low, high]].tolist() == pytest.approx([2.0 / 1.2, 2.4])


def test_a_numerical_error_below_the_range_changes_nothing(limited_ranges):
    narrow, ranges = limited_ranges
    for quantity in RANGED_RESULTS:
        if quantity != CLOSURE and "closure" not in quantity:
            pd.testing.assert_series_equal(ranges.loc[1, quantity], narrow.loc[1, quantity])


def test_bands_contain_the_limit_of_the_numerical_error():
    sources, positions, further, names, close = of_close_departures()
    place, name = {"cycle": 1, "branch": "loading"}, "closure_net_since_seating_mm"
    curves = [
        pd.DataFrame(place | {"normal_stress_MPa": stress, "source": names, name: part * close})
        for stress, part in ((0.5, 0.0), (1.0, 0.5), (2.0, 1.0))
    ]
    bands = bands_of(pd.concat(curves), sources, positions, further, NUMERICAL_LIMITS)
    low = np.array([0.0, 1.0, 2.0]) / 1.2
    np.testing.assert_allclose(bands[f"{name}_low"], low, atol=1e-12)
    np.testing.assert_allclose(bands[f"{name}_high"], [0.0, 1.2, 2.4], atol=1e-12)


def test_an_error_beyond_the_result_itself_leaves_the_range_positive():
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    ranges = ranges_of(results, sources, positions, further, {(1, STIFFNESS): 3.0})
    ends = ranges.loc[(1, STIFFNESS), ["low", "high"]].tolist()
    assert ends == pytest.approx([0.5, 8.0])


def test_the_limit_of_gross_closure_is_that_of_the_net_one_in_length():
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    results[CLOSURE_GROSS] = 2.0 * results[CLOSURE]
    ranges = ranges_of(results, sources, positions, further, NUMERICAL_LIMITS)
    assert ranges.loc[(1, CLOSURE), "high"] == pytest.approx(2.4)
    assert ranges.loc[(1, CLOSURE_GROSS), "high"] == pytest.approx(4.4)


def test_the_limit_of_residual_closure_is_that_of_net_closure_in_length():
    """What remains is the net closure less an elastic recovery that is known well."""
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    results[RESIDUAL_NET] = 0.8 * results[CLOSURE]
    ranges = ranges_of(results, sources, positions, further, NUMERICAL_LIMITS)
    assert ranges.loc[(1, RESIDUAL_NET), "high"] == pytest.approx(1.6 + 0.4)


def test_a_closure_of_which_nothing_remains_has_no_limit():
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    results[RESIDUAL_NET] = 1e-4 * results[CLOSURE]
    given = results, sources, positions, further
    limited, free = (ranges_of(*given, limits) for limits in (NUMERICAL_LIMITS, {}))
    pd.testing.assert_series_equal(limited.loc[1, RESIDUAL_NET], free.loc[1, RESIDUAL_NET])


def test_a_band_of_stiffness_is_a_curve_without_steps():
    """Quantiles at each stress fall here and there: one mean of neighbours would be a step."""
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    name, random = "normal_stiffness_net_MPa_per_mm", np.random.default_rng(4)
    stresses, rows = np.arange(1.0, 21.0), []
    for source in ["", "a", "a", *[ALL] * RANDOM_JOINTS]:
        saw = np.exp(0.3 * random.standard_normal(stresses.size))
        rows.append(pd.DataFrame({"normal_stress_MPa": stresses, name: stresses * saw}))
        rows[-1] = rows[-1].assign(cycle=1, branch="loading", source=source)
    bands = bands_of(pd.concat(rows), sources, positions, further)
    low, high = (bands[f"{name}_{end}"].to_numpy() for end in ("low", "high"))
    assert (np.diff(low) > 0.0).all()
    assert (np.diff(high) > 0.0).all()
    assert (low < high).all()


@pytest.mark.usefixtures("as_sources_make_it")
def test_a_band_contains_the_curve_of_the_joint():
    """Though all joints with random values lie above it."""
    sources = {"noise": Source((0, 1, 2), "random")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    name, place = "closure_net_since_seating_mm", {"cycle": 1, "branch": "loading"}
    names = ["", "noise", "noise", *[ALL] * RANDOM_JOINTS]
    values = np.where(np.array(names) == "", 1.0, 2.0)
    curves = [
        pd.DataFrame(place | {"normal_stress_MPa": stress, "source": names, name: part * values})
        for stress, part in ((0.5, 0.0), (1.0, 0.5), (2.0, 1.0))
    ]
    bands = bands_of(pd.concat(curves), sources, positions, further)
    np.testing.assert_allclose(bands[f"{name}_low"], [0.0, 0.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(bands[f"{name}_high"], [0.0, 1.0, 2.0], atol=1e-12)


def test_a_band_of_the_hydraulic_aperture_ends_in_those_of_its_bounds():
    """The change by half the spacing, which is not simulated, would lead beyond them here."""
    sources = {"spacing": Source((1.0, 2.0), "multiple", varied=False)}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    names = ["", "spacing", *[ALL] * RANDOM_JOINTS]
    place = {"cycle": 1, "branch": "loading", "flow_status": "flows", "source": names}
    twice = np.array(names) == "spacing"
    curves = pd.concat(
        pd.DataFrame(place)
        .assign(normal_stress_MPa=stress, hydraulic_aperture_mm=np.where(twice, 1e-5, 1e-2))
        .assign(smallest_hydraulic_mm=np.where(twice, 5e-3, 8e-3), largest_hydraulic_mm=0.012)
        for stress in (1.0, 2.0)
    )
    bands = bands_of(curves, sources, positions, further).iloc[0]
    assert (
        bands.hydraulic_aperture_mm_low_with_choices == bands.smallest_hydraulic_mm_low_with_choices
    )
    assert (
        bands.hydraulic_aperture_mm_high_with_choices
        == bands.largest_hydraulic_mm_high_with_choices
    )
    largest = bands.largest_transmissivity_m2_per_s_high_with_choices
    assert bands.transmissivity_m2_per_s_high_with_choices == largest


@pytest.mark.parametrize(
    ("name", "with_half"),
    [("mean_aperture_mm", 2.0 * 0.08 - 0.02), ("normal_stiffness_net_MPa_per_mm", 0.08**2 / 0.02)],
)
def test_half_the_spacing_changes_an_aperture_by_a_difference_and_others_by_a_factor(
    monkeypatch, name, with_half
):
    monkeypatch.setattr(ranges_module, "widening_of", lambda quantity: 1.0)
    sources = {"spacing": Source((1.0, 2.0), "multiple", varied=False)}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    names = ["", "spacing", *[ALL] * RANDOM_JOINTS]
    place = {"cycle": 1, "branch": "loading", "source": names}
    values = np.where(np.array(names) == "spacing", 0.02, 0.08)
    curves = [
        pd.DataFrame(place | {"normal_stress_MPa": stress, name: values}) for stress in (1.0, 2.0)
    ]
    band = bands_of(pd.concat(curves), sources, positions, further).iloc[0]
    np.testing.assert_allclose(band[f"{name}_low_with_choices"], 0.02, rtol=1e-9)
    np.testing.assert_allclose(band[f"{name}_high_with_choices"], with_half, rtol=1e-9)


def test_a_monotone_curve_leads_through_the_middles_of_equal_values():
    at, values = np.arange(7.0), np.array([0.0, 2.0, 4.0, 3.0, 2.0, 5.0, 6.0])
    np.testing.assert_array_equal(monotone_curve(at, np.sort(values), True), np.sort(values))
    blocked = np.array([0.3, 0.1, 0.2, 0.1, 0.0, 0.0, 0.0])  # a flow that is 0 stays 0
    np.testing.assert_array_equal(monotone_curve(at, blocked, False)[4:], 0.0)
    curve = monotone_curve(at, values, True)
    assert (np.diff(curve) > 0.0).all()
    assert curve[3] == pytest.approx(3.0, abs=0.3)
    np.testing.assert_allclose(monotone_curve(at, -values, False), -curve)


@pytest.fixture(scope="module")
def random_ends():
    """Ends of ranges of random results, whose departures from the sum of the sources are of few
    joints."""
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    random, found = np.random.default_rng(2), []
    for _ in range(20):
        net = np.exp(random.standard_normal(RANDOM_JOINTS + 3))
        values = dict.fromkeys(RANGED_RESULTS, net) | {CLOSURE_GROSS: net + random.random(net.size)}
        values["residual_closure_seated_net_mm"] = np.append([0.1, 0.0], np.exp(net[2:]) - 1.0)
        results = pd.DataFrame(
            {"cycle": 1, "source": ["", "a", "a", *[ALL] * RANDOM_JOINTS]} | values
        )
        found.append(ranges_of(results, sources, positions, further).loc[1][["low", "high"]])
    return found


def test_ends_are_in_the_order_of_net_and_gross_closure(random_ends):
    """As in each joint."""
    for ends in random_ends:
        assert (ends.loc[CLOSURE_NET] <= ends.loc[CLOSURE_GROSS]).all()


def test_no_end_of_a_range_is_below_zero(random_ends):
    assert all((ends.low >= 0.0).all() for ends in random_ends)


def test_ends_of_the_share_in_contact_are_below_one(random_ends):
    assert all(ends.loc["contact_at_max"].max() < 1.0 for ends in random_ends)


def budget_of(values):
    """A budget of one source, whose five results have the values of some quantities."""
    sources = {"youngs_modulus": Source((0.0, 1.0), "range")}
    names = ["", *["youngs_modulus"] * 2, *[ALL] * 2]
    values = dict.fromkeys(RANGED_RESULTS, np.ones(5)) | values
    results = pd.DataFrame({"cycle": 1, "source": names, "value": ""} | values)
    positions = np.array([[0.2], [0.8]])
    return Budget(results, ranges_of(results, sources, positions, positions), ())


@pytest.mark.parametrize(("size", "modelled"), [(1e-15, False), (1e-9, True)])
def test_results_that_are_the_rounding_of_zero_are_not_modelled(size, modelled):
    budget = budget_of({CLOSURE_GROSS: np.full(5, size), CLOSURE_NET: np.full(5, size)})
    assert budget.modelled(1, CLOSURE_GROSS) == modelled
    assert (budget.text(1, CLOSURE_GROSS) == budget_module.NOT_MODELLED) != modelled


def test_a_range_of_the_share_in_contact_lies_about_that_of_the_joint():
    ends = budget_of({"contact_at_max": np.array([0.8, 0.75, 0.85, 0.78, 0.82])}).ranges
    low, high = ends.loc[(1, "contact_at_max"), ["low", "high"]]
    assert 0.6 < low < 0.8 < high < 0.95


def test_a_result_at_an_end_of_its_range_says_why():
    moved = np.array([1.0, 1.0, 2.0, 1.2, 1.8])
    (line,) = budget_of({CLOSURE_NET: moved, CLOSURE_GROSS: moved + 1.0}).one_sided()
    assert "net closure since seating, cycle 1" in line
    assert "almost only in one direction" in line
    assert line in budget_of({CLOSURE_NET: moved, CLOSURE_GROSS: moved + 1.0}).sentences()
    around = np.array([1.0, 0.8, 1.25, 0.9, 1.1])
    assert not budget_of({CLOSURE_NET: around, CLOSURE_GROSS: around + 1.0}).one_sided()


def test_a_result_at_the_edge_of_those_of_random_inputs_has_a_mark_in_the_table():
    aside = np.array([1.0, 1.0, 2.0, 1.2, 1.8])
    around = np.array([1.0, 0.8, 1.25, 0.9, 1.1])
    budget = budget_of({CLOSURE_NET: aside, CLOSURE_GROSS: around + 1.0})
    table = budget.table()[budget.table().columns[0]]
    assert table[RANGED_RESULTS[CLOSURE_NET]] == f"{budget.text(1, CLOSURE_NET)} *"
    assert table[RANGED_RESULTS[CLOSURE_GROSS]] == budget.text(1, CLOSURE_GROSS)
    assert budget.notes() == [budget_module.AT_EDGE]
    assert budget_module.AT_EDGE in str(budget)
    assert budget_of({CLOSURE_NET: around, CLOSURE_GROSS: around + 1.0}).notes() == []


@pytest.mark.parametrize("missing", [5, 1])
def test_a_largest_closure_that_joints_do_not_determine_is_stated(missing):
    """Of all joints, or of one of those with random values."""
    sources = {"youngs_modulus": Source((0.0, 1.0), "range")}
    vm = np.where(np.arange(5) < 5 - missing, 1.0, np.nan)
    names = ["", *["youngs_modulus"] * 2, *[ALL] * 2]
    values = dict.fromkeys(RANGED_RESULTS, np.ones(5)) | {VM: vm}
    results = pd.DataFrame({"cycle": 1, "source": names, "value": ""} | values)
    positions = np.array([[0.2], [0.8]])
    budget = Budget(results, ranges_of(results, sources, positions, positions), ())
    assert budget.text(1, VM) == ("undetermined" if missing == 5 else "1.0 (1.0 to 1.0)")
    assert any(f"undetermined for {missing} of 5 variants" in line for line in budget.sentences())


def test_an_initial_stiffness_that_joints_do_not_determine_is_stated():
    """The range is that of the others, and does not begin at 0."""
    kni = np.array([140.0, np.nan, 8000.0, 130.0, 150.0])
    budget = budget_of({KNI: kni})
    assert budget.text(1, KNI).startswith("140 (1")
    (line,) = (line for line in budget.sentences() if "undetermined for" in line)
    assert "kni" in line
    assert "1 of 5 variants" in line
    assert budget_of({KNI: np.full(5, np.nan)}).text(1, KNI) == "undetermined"


def test_the_stiffness_of_unloading_has_the_error_of_the_loading_that_follows_it():
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    stiffness = "normal_stiffness_net_MPa_per_mm"
    curves = pd.concat([
        pd.DataFrame({"cycle": [1, 1, 1, 1, 2, 2], "branch": 2 * ["loading"] + 2 * ["unloading"]
                      + 2 * ["loading"], "normal_stress_MPa": 3 * [1.0, 2.0],
                      stiffness: 3 * [100.0, 200.0], "source": name})
        for name in ["", "a", "a", *[ALL] * RANDOM_JOINTS]
    ])  # fmt: skip
    limits = {(1, STIFFNESS): 0.5, (2, STIFFNESS): 0.1}
    bands = bands_of(curves, sources, positions, further, limits)
    widths = bands[f"{stiffness}_high"] / bands[stiffness]
    np.testing.assert_allclose(widths, [1.5, 1.5, 1.1, 1.1, 1.1, 1.1])


@pytest.mark.parametrize("status", ["not_solved", "at_least", "blocked"])
def test_a_band_of_flow_is_not_known_where_that_of_any_variant_is_not(status):
    """A blocked flow is known to be 0; the bounds are always known."""
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 1000))
    names = ["", "a", "a", *[ALL] * RANDOM_JOINTS]
    curves = [
        pd.DataFrame({"cycle": 1, "branch": "loading", "normal_stress_MPa": [1.0, 2.0],
                      "hydraulic_aperture_mm": [0.2, 0.1], "largest_hydraulic_mm": [0.4, 0.3],
                      "flow_status": "flows", "source": name})
        for name in names
    ]  # fmt: skip
    curves[5].loc[1, "flow_status"] = status
    curves[5].loc[1, "hydraulic_aperture_mm"] = 0.0 if status == "blocked" else np.nan
    band = bands_of(pd.concat(curves), sources, positions, further)
    ends = band[[f"hydraulic_aperture_mm_{end}" for end in ("low", "high")]]
    assert np.isfinite(ends.iloc[0]).all()
    assert np.isfinite(ends.iloc[1]).all() == (status == "blocked")
    assert band.largest_hydraulic_mm_high.notna().all()
    assert band.range_flow_status.tolist() == ["flows", status]
    assert band.flow_status.tolist() == ["flows", "flows"]  # that of the joint itself
    known = band.filter(like="transmissivity").notna()
    np.testing.assert_array_equal(known.all(axis=1), [True, status == "blocked"])


def test_a_budget_is_the_same_by_any_number_of_workers(budget, small_joint):
    joint = uncertain_joint(*small_joint, CONDITIONS, MODULI)
    again = uncertainty_budget(joint, workers=2)
    pd.testing.assert_frame_equal(budget.results, again.results, check_exact=True)
    pd.testing.assert_frame_equal(budget.curves, again.curves, check_exact=True)


def test_a_budget_has_results_of_all_drawn_joints(budget):
    drawn = budget.results[budget.results.source == ALL]
    assert len(drawn) == RANDOM_JOINTS
    assert drawn.value.is_unique


@pytest.mark.parametrize("name", RANGED_RESULTS)
def test_the_range_of_a_budget_holds_the_best_value(budget, name):
    best, low, high, lower, higher = budget.ranges.loc[(1, name), NUMBERS]
    assert best == budget.results[name].iloc[0]
    assert lower <= low <= best <= high <= higher
    if name not in (CLOSURE, STIFFNESS):  # of which the limit of the error may be wider
        assert higher - lower > high - low


def test_a_budget_prints_its_ranges_with_its_sentences(budget):
    printed = str(budget)
    assert budget.text(1, CLOSURE) in printed
    assert budget.sentences()[-1] in printed


@pytest.mark.filterwarnings("ignore:All-NaN:RuntimeWarning")
def test_a_joint_that_fails_has_unknown_results(small_joint):
    load = {"load": stated_load(3e9), "effects": jc.Effects(gouge=False), "unusual_values": True}
    walls = [wall[:8, :8] for wall in small_joint]
    conditions = CONDITIONS._replace(**load)
    budget = uncertainty_budget(uncertain_joint(*walls, conditions))
    best = budget.results[budget.results.source == ""]
    assert (best.status >= FAILURE).all()
    assert best[CLOSURE].isna().all()


def test_random_values_fill_their_ranges():
    conditions = CONDITIONS
    stated = {"peak_modulus_ratio": PLAUSIBLE["peak_modulus_ratio"]}
    stated |= MODULI | {"spacing": (SPACING, 2.0 * SPACING)}
    sources = sources_of(conditions, (20, 24), stated)
    drawn = [v for v in variants_of(conditions, sources, 40) if v.source == ALL]
    ratios = np.sort([v.conditions.choices.peak_modulus_ratio for v in drawn])
    low, high = PLAUSIBLE["peak_modulus_ratio"]
    expected = low * (high / low) ** ((np.arange(40) + 0.5) / 40)
    np.testing.assert_allclose(ratios, expected, rtol=0.1)  # one in each part of equal probability
    moduli = [v.conditions.rock[0].youngs_modulus for v in drawn]
    assert 50e9 <= min(moduli) < 52e9 < 88e9 < max(moduli) <= 90e9
    steps = [v.step for v in drawn]
    assert [steps.count(step) for step in (1, 2)] == [20, 20]


def test_choices_of_the_model_that_are_not_stated_are_changed_alone():
    conditions = CONDITIONS
    sources = sources_of(conditions, (20, 24), MODULI)
    variants = list(variants_of(conditions, sources))
    drawn = [v for v in variants if v.source == ALL]
    assert {v.conditions.choices for v in drawn} == {conditions.choices}
    assert {v.step for v in drawn} == {1}
    assert {"spacing", *PLAUSIBLE} <= {v.source for v in variants}


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
            rock=(DOLERITE._replace(youngs_modulus=50e9),) * 2
        ),
    }
    for variant, conditions in alone.items():
        closed = simulate_walls(*small_joint, conditions)
        assert results[variant] == cycle_table(closed)[CLOSURE].iloc[0]
    assert budget.omitted == ("registration", "poisson_ratio", "compressive_strength")
    low, high = budget.ranges.loc[(1, CLOSURE), ["low", "high"]]
    assert low < results["", ""] < high


def test_properties_of_either_wall_are_taken_as_exact_and_two_rocks_have_no_range(
    small_joint, monkeypatch
):
    """A range of a property is refused for two rocks, so that no line may advise to state one."""
    softer = DOLERITE._replace(youngs_modulus=50e9)
    neutral = {DOLERITE: ["compressive_strength"], softer: ["youngs_modulus"]}
    monkeypatch.setattr(budget_module, "acting", neutral.get)
    conditions = CONDITIONS._replace(rock=(DOLERITE, softer))
    found = uncertainty_budget(uncertain_joint(*small_joint, conditions))
    assert found.omitted == ("registration", "youngs_modulus", "compressive_strength")
    (exact,) = (line for line in found.sentences() if line.startswith("taken as exact"))
    assert "only if both walls are of one rock" in exact
    assert "--range" not in exact
    with pytest.raises(jc.InputError, match="both walls must be of one rock"):
        sources_of(conditions, small_joint[0].shape, MODULI)


def variants_by_value(shape):
    """Variants of `CONDITIONS` by source and value."""
    sources = sources_of(CONDITIONS, shape)
    return {(v.source, v.value): v for v in variants_of(CONDITIONS, sources)}


def test_variants_of_the_spacing_thin_out_the_walls(small_joint):
    upper, lower = small_joint
    coarse = variants_by_value(upper.shape)["spacing", "every 2. cell"]
    np.testing.assert_array_equal(coarse.walls(upper, lower, None)[0], upper[::2, ::2])
    assert coarse.conditions.spacing == 2 * SPACING


def test_variants_of_the_order_copy_the_walls(small_joint):
    upper, lower = small_joint
    copied = variants_by_value(upper.shape)[ORDER, "mirrored"]
    np.testing.assert_array_equal(copied.walls(upper, lower, None)[1], lower[:, ::-1])
    assert copied.conditions == CONDITIONS


def test_elastic_joints_have_sources_of_the_grid_alone(small_joint):
    elastic = CONDITIONS._replace(effects=jc.Effects(True, True, False, False, False))
    sources = sources_of(elastic, small_joint[0].shape)
    assert set(sources) == {"spacing", "base_radius_in_cells"}


def test_errors_of_the_scans_are_drawn_anew_for_each_joint(small_joint):
    none = np.zeros(small_joint[0].shape, bool)
    covariance, middle = np.diag([1e-6, 0.01, 0.01]), np.array([12.0, 10.0])
    errors = ScanErrors(np.zeros(3), covariance, middle, (2e-6, 2e-6), none)
    joint = uncertain_joint(*small_joint, CONDITIONS, {}, errors)
    assert len(joint.variants) == 24
    drawn = [v for v in joint.variants if v.source == ALL and v.step == 1]
    walls = [v.walls(*small_joint, errors)[0] for v in drawn]
    assert len({wall.tobytes() for wall in walls}) == len(walls)
    budget = uncertainty_budget(joint)
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


def test_plausible_numbers_lie_about_the_usual_one():
    usual = jc.Choices()
    for name, ends in PLAUSIBLE.items():
        if name != "peaks":
            assert np.sqrt(ends[0] * ends[1]) == pytest.approx(getattr(usual, name), rel=5e-3)


def test_choices_that_are_changed_are_those_of_the_global_sensitivity_study():
    inputs = read_plain(ROOT / "studies/global_sensitivity/global_sensitivity.yaml")[
        "global_sensitivity"
    ]["inputs"]
    studied = {
        about["key"].removeprefix("choices."): about.get("between", about.get("values"))
        for about in inputs.values()
        if about["key"].startswith("choices.")
    }
    del studied["largest_radius_mm"]  # it has no share of the variance of a closure
    assert set(PLAUSIBLE) == set(studied)
    assert list(PLAUSIBLE["peaks"]) == studied["peaks"]


@pytest.mark.usefixtures("as_sources_make_it")
@pytest.mark.parametrize("factor", [0.5, 0.0, 1.0, 2.0, -1.0])
def test_sources_that_do_not_add_up_count_by_what_they_do_together(factor):
    """The changes of joints with random values are a multiple of the expected sums."""
    sources = {name: Source((0.0, 1.0), "range") for name in "ab"}
    positions, further = (random_positions(sources, n, 0) for n in (RANDOM_JOINTS, 10_000))
    drawn, later = ((2.0 * part - 1.0).sum(axis=1) for part in (positions, further))
    logs = [0.0, -1.0, 1.0, -1.0, 1.0, *(factor * drawn)]
    results = pd.DataFrame(
        {"cycle": 1, "source": ["", *"aabb", *[ALL] * RANDOM_JOINTS]}
        | dict.fromkeys(RANGED_RESULTS, 2.0 * np.exp(logs))
    )
    low = float(np.log(ranges_of(results, sources, positions, further).iloc[0].low / 2.0))
    slope = min(max(factor, 0.0), 1.0)
    left = (factor - slope) * drawn  # what no source explains, of a further joint
    scale = np.sqrt((RANDOM_JOINTS + 1) / RANDOM_JOINTS) * left.std(ddof=1)
    scatter = scale * scipy.stats.t.rvs(RANDOM_JOINTS - 1, size=(100, later.size), random_state=1)
    exact = np.quantile(slope * later + left.mean() + scatter, 0.05)
    assert low == pytest.approx(min(exact, 0.0), abs=0.03)


def test_only_what_is_uncertain_of_a_joint_is_a_source():
    none, hole = np.zeros((20, 24), bool), np.ones((20, 24), bool)

    def names(shape=(20, 24), errors=None, **changes):
        return set(sources_of(CONDITIONS._replace(**changes), shape, {}, errors))

    usual = names()
    assert "spacing" not in names((15, 24))
    assert "spacing" in names((16, 24))
    exact = ScanErrors(np.zeros(3), np.zeros((3, 3)), np.zeros(2), (0.0, 0.0), none)
    assert names(errors=exact) == usual
    noisy = exact._replace(noise=(0.0, 1e-6))
    moved = exact._replace(covariance=np.eye(3))
    assert names(errors=noisy) - usual == {"noise"}
    assert names(errors=exact._replace(holes=hole)) - usual == {"holes"}
    assert names(errors=moved) - usual == {"registration"}
    hard = jc.Effects(soft_peaks=False)
    assert usual - names(effects=hard) == {"peak_modulus_ratio", "peaks"}
    assert "breakage" not in names(numerics=jc.Numerics(solver="reference"))
    assert "breakage" not in names(numerics=jc.Numerics(target="interpolate"))
    for tolerance, kind in ((0.05, SHARED), (0.06, "choice")):
        numerics = jc.Numerics(breakage="resolved", tolerance=tolerance)
        assert sources_of(CONDITIONS._replace(numerics=numerics), (20, 24))["breakage"].kind == kind


def test_joints_of_a_range_are_closed_at_once_as_far_as_memory_allows():
    assert [threads_for(cells, 5) for cells in (1, 400_000, 1_000_000, 2_000_000, 10**8)] == [
        5, 5, 2, 1, 1
    ]  # fmt: skip


@pytest.mark.parametrize(("share", "stays"), [(0.004, False), (-0.004, False), (0.006, True)])
def test_what_stays_of_a_closure_is_stated_beyond_the_error_of_its_steps(share, stays):
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (20, 1000))
    values = dict.fromkeys(RANGED_RESULTS, np.full(23, 0.01))
    values["residual_closure_seated_net_mm"] = np.append(np.zeros(22), share * 0.01)
    results = pd.DataFrame({"cycle": 2, "source": ["", "a", "a", *[ALL] * 20]} | values)
    results = results.assign(value="", status=0)
    budget = Budget(results, ranges_of(results, sources, positions, further), ())
    assert (budget.text(2, "residual_closure_seated_net_mm") != "not modelled") == stays


def budget_with_lower(below):
    """A budget of 20 random joints of which some close less than the joint itself."""
    sources = {"a": Source((0.0, 1.0), "range")}
    positions, further = (random_positions(sources, n, 0) for n in (20, 1000))
    drawn = np.where(np.arange(20) < below, 0.5, 2.0)
    values = dict.fromkeys(RANGED_RESULTS, np.array([1.0, 1.0, 1.0, *drawn]))
    values["residual_closure_seated_net_mm"] = np.append(1e-13, np.zeros(22))
    results = pd.DataFrame({"cycle": 1, "source": ["", "a", "a", *[ALL] * 20]} | values)
    results = results.assign(value="", status=0)
    return Budget(results, ranges_of(results, sources, positions, further), ())


def test_each_result_at_an_end_of_its_range_is_named_without_its_unit():
    (line,) = [line for line in budget_with_lower(2).sentences() if "on one side" in line]
    assert "mean aperture at the maximum stress, cycle 1" in line
    assert "share of cells in contact at the maximum stress, cycle 1" in line


@pytest.mark.parametrize(("below", "outlying"), [(2, True), (3, False), (17, False), (18, True)])
def test_a_joint_at_the_edge_of_the_random_ones_is_reported(below, outlying):
    lines = budget_with_lower(below).sentences()
    reported = [line for line in lines if "of the results of random inputs" in line]
    assert bool(reported) == outlying
    if reported:
        assert ("smaller" in reported[0]) == (below < 10)


@pytest.mark.parametrize("below", [2, 3, 17, 18])
def test_a_range_of_no_more_than_rounding_is_not_modelled(below):
    text = budget_with_lower(below).text(1, "residual_closure_seated_net_mm")
    assert text == "not modelled"


def rows_of_steps(best, others, copies):
    """Results of a joint, of other steps, and of copies, on one cycle."""
    rows = [("", "", best), ("breakage", "tolerance 0.04", others)]
    rows += [(ORDER, f"copy {n}", value) for n, value in enumerate(copies)]
    table = pd.DataFrame(rows, columns=["source", "value", CLOSURE_NET])
    return table.assign(cycle=1, stiffness_net_MPa_per_mm=1.0)


CHANGED = [1.1, 1.12, 1.08]
"""A result by other steps, and those of copies by the same steps."""


ALONG = {CLOSURE_NET: 0.05, STIFFNESS: 0.04}
"""Differences of the first loading by another rule of steps."""


def closure_error(table, along=ALONG):
    found = numerical_errors_of(table, 0.02, along)
    return found[found.quantity == CLOSURE_NET].iloc[0]


@pytest.fixture(scope="module")
def errors_of_copies():
    return closure_error(rows_of_steps(1.0, 1.1, [1.12, 1.08]))


def test_the_error_compares_the_joint_with_other_steps(errors_of_copies):
    change = log_change(1.0, 1.1)
    assert errors_of_copies.error == numerical_error(change, 0.05, 0.02, CLOSURE_NET, 1)


def test_the_scatter_is_that_of_the_joint_and_all_copies(errors_of_copies):
    """A joint may be far from copies that agree with each other."""
    assert errors_of_copies.scatter == log_scatter([1.0, *CHANGED])


def test_no_error_is_stated_where_other_steps_failed():
    table = rows_of_steps(1.0, np.nan, [1.02, 0.98])
    assert np.isnan(closure_error(table).error)
    assert np.isnan(closure_error(rows_of_steps(1.0, 1.1, [1.0]), {}).error)


def test_the_error_is_that_of_its_cycle():
    table = rows_of_steps(1.0, 1.1, [1.12, 1.08]).assign(cycle=2)
    expected = numerical_error(log_change(1.0, 1.1), 0.05, 0.02, CLOSURE_NET, 2)
    assert closure_error(table).error == expected


def test_a_joint_whose_copies_scatter_beyond_a_fifth_is_called_not_stable():
    for spread, unstable in ((0.1, False), (0.3, True)):
        table = rows_of_steps(1.0, 1.0, [1.0 + spread, 1.0 - spread])
        numerical = numerical_errors_of(table, 0.0, ALONG)
        budget = Budget(table, pd.DataFrame(), (), numerical=numerical)
        lines = budget._numerical_error(CLOSURE_NET)
        assert "limit of the numerical error" in lines[0]
        assert any("is not stable" in line for line in lines) == unstable


@pytest.mark.parametrize(("error", "ends"), [(0.2, True), (1e-3, False)])
def test_a_range_that_ends_at_the_limit_of_the_numerical_error_says_so(error, ends):
    sources, positions, further, names, close = of_close_departures()
    results = pd.DataFrame({"cycle": 1, "source": names} | dict.fromkeys(RANGED_RESULTS, close))
    ranges = ranges_of(results, sources, positions, further, {(1, CLOSURE_NET): error})
    columns = ["cycle", "quantity", "error", "scatter", "by"]
    numerical = pd.DataFrame([(1, CLOSURE_NET, error, 0.0, "")], columns=columns)
    (line,) = Budget(results, ranges, (), numerical=numerical)._numerical_error(CLOSURE_NET)
    assert ("the range of cycle 1 ends at it" in line) == ends


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_the_error_of_a_joint_compares_its_loading_by_both_rules_of_steps(breakage):
    """A resolved joint with the paper's steps, and one by these with resolved breakage."""
    walls = jc.wall_pair(8, (16, 16), 0.5e-3, 3)
    conditions = jc.Conditions(0.5e-3, "granite", 5e6, cycles=1).checked()
    conditions = conditions._replace(numerics=FIRST[breakage])
    found = uncertainty_budget(uncertain_joint(*walls, conditions))
    joint = jc.simulate(*walls, conditions=conditions)
    change = jc.simulate(*walls, conditions=conditions._replace(numerics=SECOND[breakage]))
    rule = jc.simulate(*walls, conditions=conditions._replace(numerics=OTHER[breakage]))
    closures = [float(net_responses(of)["max_closure_seated_net"][0]) for of in (joint, change)]
    along = differences_of_loading(joint, rule)[CLOSURE_NET]
    expected = numerical_error(log_change(*closures), along, largest_jump(joint), CLOSURE_NET, 1)
    assert along > 0.0
    assert limits_of_error(found.numerical)[1, CLOSURE_NET] == pytest.approx(expected)


FIRST = {"fixed_step": jc.Numerics(), "resolved": RESOLVED}
"""Steps of a joint."""
SECOND = {
    "fixed_step": jc.Numerics(breakage="resolved"),
    "resolved": coarser(RESOLVED, 2.0),
}
"""Steps with which those of a joint are compared by its result."""
OTHER = {"fixed_step": jc.Numerics(breakage="resolved"), "resolved": jc.Numerics()}
"""Steps with which those of a joint are compared by its first loading."""


def test_the_joint_by_the_papers_steps_is_in_no_range(monkeypatch):
    """Its changes are those of another rule of steps, and not of an unknown input."""
    walls = jc.wall_pair(8, (16, 16), 0.5e-3, 3)
    conditions = jc.Conditions(0.5e-3, "granite", 5e6, cycles=1).checked()
    conditions = conditions._replace(numerics=jc.Numerics(breakage="resolved"))
    monkeypatch.setattr(budget_module, "limits_of_error", lambda numerical: {})
    joint = uncertain_joint(*walls, conditions)
    found = uncertainty_budget(joint)
    others = tuple(of for of in joint.variants if of.source != OTHER_RULE)
    assert len(others) == len(joint.variants) - 1
    without = uncertainty_budget(joint._replace(variants=others))
    pd.testing.assert_frame_equal(found.ranges, without.ranges)
    assert OTHER_RULE in set(found.results.source)


def test_a_source_that_moves_the_result_without_a_share_is_undetermined(budget):
    """The estimate of a share from few random joints may be clipped at 0."""
    row = budget.ranges.loc[1, CLOSURE]
    far = row.best + 0.5 * (row.high_with_choices - row.low_with_choices)
    results = budget.results.copy()
    results.loc[(results.source == "peaks") & (results.cycle == 1), CLOSURE] = far
    ranges = budget.ranges.copy()
    ranges.loc[(1, CLOSURE), ["peaks", "spacing"]] = 0.0
    near = results.source == "spacing"
    results.loc[near & (results.cycle == 1), CLOSURE] = 1.0001 * row.best
    clipped = budget._replace(results=results, ranges=ranges)
    assert clipped.undetermined_shares(1, CLOSURE) == ["peaks"]
    text = " ".join(clipped.sentences())
    assert "choice of soft peaks undetermined" in text
    assert "do not distinguish its share from 0" in text
    assert clipped.share_text(1, CLOSURE, "spacing") == "0 %"
    (record,) = (r for r in clipped.record() if (r["cycle"], r["quantity"]) == (1, CLOSURE))
    assert record["undetermined_shares"] == ["peaks"]
    assert record["shares"]["peaks"] == 0.0
    drawn = range_figure(clipped, "a joint")
    ticks = [label.get_text() for label in drawn.axes[0].get_yticklabels()]
    assert "choice of soft peaks (undetermined)" in ticks
    assert "grid spacing (0 %)" in ticks


def test_it_is_said_what_a_share_of_100_percent_is(budget):
    text = " ".join(budget.sentences())
    assert "100 % is the variance of the result" in text
    assert "shares may add to more than 100 %" in text
    (legend,) = range_figure(budget, "a joint").legends
    assert "100 % is the variance" in legend.get_title().get_text().replace("\n", " ")
    assert "as registered, usual values" in [part.get_text() for part in legend.get_texts()]


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"single": True, "ranges": {"peak_modulus_ratio": (0.05, 0.1)}}, "left out with single"),
        ({"ranges": {"foo": (1.0, 2.0)}}, "ranges: 'foo': must be one of youngs_modulus"),
        ({"ranges": {"peak_modulus_ratio": (0.2, 0.1)}}, "the lowest value must come first"),
        ({"spikes": "foo"}, "spikes = 'foo': must be one of"),
        ({"shift": "foo"}, "shift = 'foo': must be one of"),
        ({"orientation": "foo"}, "orientation = 'foo': must be one of"),
    ],
)
def test_arguments_are_refused_before_files_are_read(stated, words):
    with pytest.raises(jc.InputError, match=words):
        jc.close("no_upper.npz", "no_lower.npz", rock="granite", max_normal_stress=5e6, **stated)


def test_random_values_of_two_sources_with_stated_ranges_hardly_correlate():
    correlations = np.corrcoef(random_positions(VARIED, RANDOM_JOINTS, SEED).T)
    assert np.abs(correlations - np.eye(len(VARIED))).max() < 0.275
