"""Regions of constants hold those of known joints, and nothing for impossible curves."""

import re

import numpy as np
import pandas as pd
import pytest
import scipy.stats

import jointclosure as jc
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.history import history_of
from jointclosure.joint.simulation import simulate_walls
from jointclosure.measured import simulated_joints
from jointclosure.measured.compared_quantities import (
    about_share,
    compared_quantities,
    prediction_intervals,
)
from jointclosure.measured.curves import MeasuredCurve, parsed_curve
from jointclosure.measured.joint_arguments import WallRecipe
from jointclosure.measured.likelihood import Readings, readings_of_curve
from jointclosure.measured.simulated_joints import ABOUT_RANGES, CHECKED, FINER, LaterLoading
from jointclosure.measured.validation import NEITHER, NUMERICS, STRENGTHS, validate
from jointclosure.plotting.measured import region_figure
from jointclosure.statistics.randomness import generator
from jointclosure.uncertainty import expected_cost
from jointclosure.uncertainty.sources import coarser
from jointclosure.walls.gridding import Scan
from jointclosure.walls.registration import registered
from tests.joints import COARSE, ELASTIC, SPACING

ROCK = jc.Rock(11e9, 0.25, 90e6)
STRESS, SEATING, STRENGTH, SHIFT, CELLS = 3e6, 0.5e6, 90e6, 2, 16
WEAKER, ANEW = "weaker crushed rock", "walls seated anew"


def scanned_pair(cells):
    """Scanned walls of a square joint."""
    upper, lower = jc.wall_pair(10.0, (cells, cells), SPACING, 3, mismatch_wavelength=3e-3)
    scans = [Scan(wall, (SPACING, SPACING)) for wall in (-upper, lower)]
    return registered(*scans, orientation="common_frame", spikes="keep", unusual_values=True)


@pytest.fixture(scope="module")
def pair():
    return scanned_pair(CELLS)


def measured_curve(pair, shift=0, ratio=1.0, strength=STRENGTH, walls=None):
    """Two loadings of a joint whose walls are shifted, or weaker, in between, as a laboratory's."""
    rock = ROCK._replace(compressive_strength=strength)
    given = Conditions(SPACING, rock, STRESS, 1, SEATING, numerics=NUMERICS)
    walls = walls or (pair.upper, pair.lower)
    once = simulate_walls(*walls, given.checked())
    crushed = once.upper_final.values, once.lower_final.values
    width = crushed[0].shape[1] - shift
    seated, pristine = ((upper[:, shift:], lower[:, :width]) for upper, lower in (crushed, walls))
    weaker = given._replace(choices=jc.Choices(crushed_strength_ratio=ratio))
    again = simulate_walls(*seated, weaker.checked(), pristine=pristine)
    stresses, parts = np.linspace(SEATING, STRESS, 13), []
    for cycle, joint in enumerate((once, again), start=1):
        loading, unloading = history_of(joint).net.at(stresses)[0]
        closure = np.concatenate([loading, unloading[::-1]]) - loading[0]
        stress = np.concatenate([stresses, stresses[::-1]])
        parts.append((stress, closure, np.full(stress.size, cycle)))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return MeasuredCurve(*columns, np.arange(columns[0].size))


@pytest.fixture(scope="module")
def asked(pair, tmp_path_factory):
    cache = tmp_path_factory.mktemp("joints")
    constants = {"shifts": (SHIFT,), "crushed_strength_ratios": (0.7,), "strengths": (60e6, 135e6)}
    given = {"rock": ROCK, "pair": pair, "seating_stress": SEATING, "cache": cache}
    return {"surfaces": 9, "workers": 1} | given | constants


@pytest.fixture(scope="module")
def curves(pair):
    """Curves of a joint whose walls stay, and of one whose walls are shifted."""
    return measured_curve(pair), measured_curve(pair, SHIFT)


@pytest.fixture(scope="module")
def region(asked, curves):
    return validate(curves[1], **asked)


def constants(region, mechanism):
    rows = region.table()
    return rows[rows.mechanism == mechanism].set_index("constant")


def test_the_constants_that_a_curve_was_made_with_lie_in_the_region(region):
    assert region.compatible(ANEW)
    strength, shift = constants(region, ANEW).loc[["strength", "shift of reseating"]].itertuples()
    assert strength.low <= 1e-6 * STRENGTH <= strength.high
    assert shift.low <= SHIFT <= shift.high
    assert shift.low > 0
    assert region_figure(region, "a joint").axes


def test_the_numerical_error_is_that_of_nearest_joints_by_a_finer_tolerance(region, asked, pair):
    _, _, j = region.place(max(region.mechanisms, key=region.p_value))
    strength = np.geomspace(*asked["strengths"], STRENGTHS)[j]
    rock = ROCK._replace(compressive_strength=strength)
    walls = WallRecipe((0.0, 0.0), pair.upper.shape, SPACING, 1, 0.8, None, digest="scans")
    closures, ends = [], np.array([SEATING, STRESS])
    for factor in (1.0, 1.0 / FINER):
        numerics = coarser(NUMERICS, factor)
        given = Conditions(SPACING, rock, STRESS, 1, SEATING, numerics=numerics).checked()
        scans = np.ascontiguousarray(pair.upper), np.ascontiguousarray(pair.lower)
        joints = [walls.pair(1 + STRENGTHS * k + j, 1.0, scans) for k in range(CHECKED)]
        net = [history_of(simulate_walls(*joint, given)).net.at(ends) for joint in joints]
        closures.append(np.array([joint[0, 0, 1] - joint[0, 0, 0] for joint in net]))
    ratios = closures[0] / closures[1] - 1.0
    error = ratios.std(ddof=1) / np.sqrt(CHECKED)
    assert region.numerical["closure of cycle 1"] == pytest.approx((ratios.mean(), error), rel=1e-6)
    stiffnesses = [name for name in region.numerical if name.startswith("stiffness")]
    assert len(stiffnesses) == 3  # of both cycles, and later over first
    lines = region.sentences()
    (numerical,) = (line for line in lines if line.startswith("numerical error, 4 nearest"))
    assert "(mean ± its standard error): " in numerical
    assert ABOUT_RANGES in lines
    assert any(line.startswith("a constant is compatible from low to high") for line in lines)


def test_a_mechanism_that_leaves_less_closure_is_not_compatible(region):
    assert not region.compatible(NEITHER)
    assert np.isnan(constants(region, NEITHER).loc["strength"].low)


def test_what_a_mechanism_misses_is_stated(region):
    (sentence,) = (line for line in region.sentences() if line.startswith("no mechanism"))
    assert "not compatible" in sentence
    assert "share of the closure of cycle 2 that stays" in sentence
    assert "farther from the mean of the simulated joints that come nearest to it than" in sentence


@pytest.fixture(scope="module")
def plain(asked, curves, region):
    """The region of a joint whose walls stay, after that of another, and what was reported."""
    lines = []
    return validate(curves[0], **asked, report=lines.append), lines


def test_joints_that_were_closed_are_kept(plain, region):
    found, lines = plain
    closed = [line for line in lines if "closed: " in line]
    assert all(f"of {CHECKED}" in line for line in closed)  # the nearest, by a finer tolerance
    np.testing.assert_array_equal(found.closures, region.closures)


def test_each_joint_is_kept_as_soon_as_it_is_simulated(region, asked):
    """A run that is stopped loses no more than the joints that it was at."""
    kept = sorted(asked["cache"].glob("wavelength_0_strength_*_surface_*_0.05.nc"))
    assert len(kept) == STRENGTHS * asked["surfaces"]


def test_the_time_of_all_joints_is_estimated_before_they_are_simulated(pair, curves, tmp_path):
    lines = []

    def stop(line):
        lines.append(line)
        if "take about" in line:
            raise InterruptedError

    about = {"rock": ROCK, "pair": pair, "seating_stress": SEATING, "surfaces": 9, "workers": 1}
    with pytest.raises(InterruptedError):
        validate(curves[0], **about, cache=tmp_path, report=stop)
    assert "all 36 joints take about" in lines[-1]
    assert "in 1 process, or longer if other work uses their processors" in lines[-1]
    assert "finished joints are kept" in lines[-1]
    assert not list(tmp_path.glob("*.nc"))


NONE_SLOWER: dict[float, float] = {}


def forecast_of(monkeypatch, pair, curves, times, slower=NONE_SLOWER, share=1.0, **kinds):
    """Return seconds of the forecast, as if joints of each strength [Pa] took so long [s].

    Later loadings take as long, or ``slower`` times as long by the ratio of crushed strength. The
    window in which they are compared has a ``share`` of the cells.
    """
    spent = {round(strength): seconds for strength, seconds in times.items()}

    def timed(upper, lower, size, conditions):
        return spent[round(conditions.rock[0].compressive_strength)], upper.size

    def timed_loadings(walls, size, conditions, cycles, strength, laters):
        each = [slower.get(later.crushed_strength_ratio, 1.0) for later in laters]
        return spent[round(strength)] * (1.0 + (cycles - 1) * sum(each))

    def compared(upper, *words):
        return timed(upper, *words)[0], share * upper.size

    monkeypatch.setattr(expected_cost, "time_of_window", timed)
    monkeypatch.setattr(simulated_joints, "time_of_window", compared)
    monkeypatch.setattr(simulated_joints, "time_of_loadings", timed_loadings)
    monkeypatch.setattr(simulated_joints, "rough_time", lambda seconds: f"<{seconds:.6g}>")

    def stop(line):
        if "take about" in line:
            raise InterruptedError(line)

    about = {"rock": ROCK, "pair": pair, "seating_stress": SEATING, "surfaces": 9, "workers": 1}
    with pytest.raises(InterruptedError) as stopped:
        validate(curves[0], **about, strengths=(min(times), max(times)), report=stop, **kinds)
    return np.array([float(number) for number in re.findall("<(.*?)>", str(stopped.value))])


def test_the_forecast_counts_that_joints_of_weak_rock_take_longer(monkeypatch, pair, curves):
    strengths = np.geomspace(30e6, 180e6, STRENGTHS)
    alike = forecast_of(monkeypatch, pair, curves, dict.fromkeys(strengths, 2.0))
    weak = dict(zip(strengths, (22.0, 2.0, 2.0, 2.0), strict=True))
    np.testing.assert_allclose(forecast_of(monkeypatch, pair, curves, weak), 3.5 * alike, rtol=1e-5)


def test_the_forecast_counts_that_weaker_crushed_rock_takes_longer(monkeypatch, pair, curves):
    times = dict.fromkeys(np.geomspace(30e6, 180e6, STRENGTHS), 2.0)
    about = {"shifts": None, "crushed_strength_ratios": (0.9, 0.6)}
    alike = forecast_of(monkeypatch, pair, curves, times, **about)
    slow = forecast_of(monkeypatch, pair, curves, times, {0.6: 5.0}, **about)
    np.testing.assert_allclose(slow, 2.0 * alike, rtol=1e-5)  # 1 + 1 + 1 + 5 over 4


def test_the_longest_time_grows_faster_with_the_cells_than_a_first_loading(
    monkeypatch, pair, curves
):
    times = dict.fromkeys(np.geomspace(30e6, 180e6, STRENGTHS), 2.0)
    whole = forecast_of(monkeypatch, pair, curves, times)
    quarter = forecast_of(monkeypatch, pair, curves, times, share=0.25)
    least, most = expected_cost.EXPONENTS
    np.testing.assert_allclose(quarter, whole * [1.0, 4.0 ** (most - least)], rtol=1e-5)


def test_the_loadings_of_a_window_are_timed_with_all_changes(monkeypatch, pair):
    seen = []
    simulate = simulated_joints.simulate_walls

    def counted(upper, lower, conditions, **about):
        ratio = conditions.choices.crushed_strength_ratio
        seen.append((upper.shape, conditions.cycle_count, ratio))
        return simulate(upper, lower, conditions, **about)

    monkeypatch.setattr(simulated_joints, "simulate_walls", counted)
    laters = LaterLoading(), LaterLoading(shift=1), LaterLoading(crushed_strength_ratio=0.6)
    first = jc.Conditions(pair.spacing, ROCK, 1e6, 1, effects=ELASTIC)
    walls = pair.upper, pair.lower
    assert simulated_joints.time_of_loadings(walls, 9, first, 3, 50e6, laters) > 0.0
    assert seen == [((9, 9), 1, 1.0), ((9, 9), 2, 1.0), ((9, 8), 2, 1.0), ((9, 9), 2, 0.6)]


def test_no_mechanism_is_compatible_with_a_curve_of_walls_that_stay(plain):
    assert plain[0].compatible(NEITHER)


def test_a_curve_of_impossible_physics_is_compatible_with_none(asked, curves):
    softer = np.where(curves[0].cycle == 2, 20.0, 1.0) * curves[0].closure
    none = validate(curves[0]._replace(closure=softer), **asked)
    assert not any(map(none.compatible, none.mechanisms))
    assert "none is compatible with all loadings of this curve" in none.sentences()[0]
    assert none.table().low.isna().all()
    region_figure(none, "impossible")


@pytest.fixture(scope="module")
def seated_anew(region):
    """Quantities of the curve beside those of the nearest joints whose walls are shifted."""
    rows = region.quantities()
    return rows[rows.mechanism == ANEW].set_index("quantity")


def test_quantities_are_those_of_the_curve(seated_anew, curves):
    _, curve = curves
    # at the end of loading; unloading starts a little deeper where loading passed the maximum
    whole = curve.closure[curve.cycle == 1][curve.stress[curve.cycle == 1].argmax()]
    measured = seated_anew.measured
    assert measured["closure of cycle 1"] == pytest.approx(1e3 * whole, rel=1e-6)
    first, later = (
        measured[measured.index.str.startswith(f"stiffness of cycle {n},")].iloc[0] for n in (1, 2)
    )
    assert measured["stiffness of cycle 2 over the first"] == pytest.approx(later / first)


def test_quantities_of_the_nearest_joints_contain_those_of_the_curve(seated_anew):
    low, measured, high = (seated_anew[name] for name in ("low", "measured", "high"))
    assert ((low <= measured) & (measured <= high)).all()


@pytest.fixture(scope="module")
def one_loading(tmp_path_factory):
    """The region of the single loading of a joint with walls of a JRC."""
    stresses = np.linspace(SEATING, 1.5e6, 8)
    joint = simulate_walls(
        *jc.wall_pair(10.0, (12, 12), SPACING, 5, mismatch_wavelength=1e-3, roll_off=None),
        Conditions(SPACING, ROCK, 1.5e6, 1, SEATING, numerics=COARSE).checked(),
    )
    loading = 1e3 * history_of(joint).net.at(stresses)[0, 0]
    path = tmp_path_factory.mktemp("one") / "curve.csv"
    table = {"stress_MPa": 1e-6 * stresses, "closure_mm": loading}
    pd.DataFrame(table).to_csv(path, index=False)
    about = {"jrc": 10.0, "shape": (12, 12), "surfaces": 4, "workers": 1, "numerics": COARSE}
    return validate(path, rock=ROCK, **about, seating_stress=SEATING)


def test_one_loading_has_no_mechanism(one_loading):
    assert one_loading.mechanisms == [NEITHER]
    assert one_loading.compatible(NEITHER)


def test_walls_of_a_jrc_have_a_mismatch_wavelength(one_loading):
    assert one_loading.closures.shape[:4] == (1, 6, 4, 4)
    assert list(constants(one_loading, NEITHER).index) == ["strength", "mismatch wavelength"]


def test_the_region_of_one_loading_is_drawn(one_loading):
    assert region_figure(one_loading, "one loading").axes


@pytest.mark.slow
def test_regions_contain_the_constants_of_nineteen_in_twenty_joints(asked, tmp_path):
    """Of unknown position, strength and mechanism; in most that one acted is seen."""
    tried = {"shifts": (1, 2), "crushed_strength_ratios": (0.8, 0.6), "strengths": (45e6, 180e6)}
    pair = scanned_pair(24)
    tried |= {"cache": tmp_path, "surfaces": 12, "pair": pair, "workers": None}
    laters = [
        LaterLoading(),
        LaterLoading(1),
        LaterLoading(2),
        LaterLoading(0, 0.8),
        LaterLoading(0, 0.6),
    ]
    rng, inside, seen = np.random.default_rng(11), [], []
    for number in range(24):
        strength, later = float(np.exp(rng.uniform(*np.log([55e6, 150e6])))), laters[number % 5]
        placed = WallRecipe((0.0, 0.0), pair.upper.shape, SPACING, 999, 0.8, None, "scanned")
        walls = placed.pair(number, 0.0, (pair.upper, pair.lower))
        curve = measured_curve(pair, *later, strength, walls)
        region = validate(curve, **asked | tried)
        joints = region.compared[later]
        place = np.abs(np.log(joints.strengths / strength)).argmin()
        inside.append(joints.p_values[:, place].max() >= 0.05)
        if later != LaterLoading():
            seen.append(not region.compatible(NEITHER))
    assert sum(inside) >= 20  # 95 % of 24 are 22.8, with a standard deviation of 1.1
    assert np.mean(seen) > 0.8  # where little was crushed, its strength matters little


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"shifts": (30,)}, "shifts = 30: must be whole numbers of cells from 1 to"),
        ({"crushed_strength_ratios": (1.0,)}, "crushed_strength_ratios = 1.0: must lie between"),
        ({"strengths": (9e7, 6e7)}, "the lower one must come first"),
        ({"surfaces": 4}, "surfaces = 4: must be at least 9 for this curve"),
    ],
)
def test_what_is_wrong_is_named_before_anything_is_closed(asked, curves, wrong, message):
    with pytest.raises(jc.InputError, match=re.escape(message)):
        validate(curves[0], **asked | wrong)


def readings(values=()):
    """Readings of two cycles, of which the first was unloaded."""
    levels = np.array([1e6, 2e6, 4e6])
    read = ((0, 1, 2), (1, 2))
    return Readings(2, (1,), levels, 0.5e6, np.asarray(values), read)


def test_errors_of_quantities_are_their_scatter_by_measured_closures():
    """First order; the closure that stays is that of the recovered one, whose error it has."""
    random, error = generator(1), 0.01
    exact = np.array([0.10, 0.15, 0.20, 0.05, 0.11, 0.13])
    drawn = exact * (1.0 + error * random.standard_normal((20_000, exact.size)))
    measured = compared_quantities(exact, readings(), error)
    scattered = compared_quantities(drawn, readings())
    assert [one.first_loading for one in measured].count(True) == 2
    for one, other in zip(measured, scattered, strict=True):
        assert float(one.error) == pytest.approx(other.values.std(), rel=0.05), one.name
        assert float(one.values) == pytest.approx(np.median(other.values), rel=0.02)


def test_the_interval_of_one_more_joint_is_students_with_the_measuring_error():
    """About the mean of n joints: t s sqrt(1 + 1/n), in logarithms, of those that did not fail."""
    joints = np.exp(generator(3).normal(-9.0, 0.2, (1, 6, 6)))
    joints[0, 0] = np.nan
    curve = readings([0.10, 0.15, 0.20, 0.05, 0.11, 0.13])
    logs = np.log(1e3 * joints[0, 1:, 2])  # closure of cycle 1 [mm]
    for error in (0.0, 0.1, 1.0):
        _, low, high = next(prediction_intervals(curve, joints, error))
        spread = np.sqrt(logs.var(ddof=1) * (1.0 + 1.0 / 5.0) + error**2)
        half = scipy.stats.t.ppf(0.975, 4) * spread
        np.testing.assert_allclose(
            np.log([low[0], high[0]]), logs.mean() + half * np.array([-1, 1])
        )
    # joints of neighbouring constants tell of the scatter, but not of the mean, and failed ones not
    several = np.concatenate([joints, 2.0 * joints, np.nan * joints])
    _, low, high = next(prediction_intervals(curve, several, 0.0))
    alone = next(prediction_intervals(curve, joints, 0.0))
    assert alone[1][0] < low[0] < high[0] < alone[2][0]
    assert low[1] == pytest.approx(2.0 * low[0])
    assert np.isnan([low[2], high[2]]).all()


def test_readings_of_a_cycle_loaded_as_far_as_the_first_are_taken_to_two_percent():
    rows = "0.5,0,1\n2.75,0.08,1\n5,0.1,1\n0.5,0.05,1\n0.5,0.05,2\n2.75,0.08,2\n{},0.1,2\n"
    for largest, taken in ((4.91, True), (5.09, True), (4.89, False), (5.11, False)):
        curve = parsed_curve("stress_MPa,closure_mm,cycle\n" + rows.format(largest), "lab.csv")
        if taken:
            found = readings_of_curve(curve, 0.5e6)
            assert found.levels[-1] == pytest.approx(min(5.0, largest) * 1e6)  # that both reach
        else:
            with pytest.raises(jc.InputError, match="must be the same"):
                readings_of_curve(curve, 0.5e6)


def test_a_negative_share_of_closure_is_explained():
    assert "the joint opens beyond the start" in about_share("%", -6.0)
    assert about_share("%", 5.0) == about_share("mm", -1.0) == ""
