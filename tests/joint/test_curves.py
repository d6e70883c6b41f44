"""Curves of a closed joint and their stiffness, held against what they must be."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.exports.porepy import porepy_files
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.history import GROSS, NET, history_of, round_levels
from jointclosure.joint.interpolation import cubic_over
from jointclosure.joint.laws import (
    law_curves,
)
from jointclosure.joint.result_tables import curve_table, cycle_table, stress_table
from tests import joints
from tests.joint.test_laws import LARGEST, SEATING, TRUE, following
from tests.joints import COARSE, SPACING, on_softer_half_spaces, pair


def joint(**stated):
    return joints.closed(pair((20, 24)), 5e6, **{"seating_stress": 0.5e6} | stated)


@pytest.fixture(scope="module")
def closed():
    return joint(flow=True)


def on(table, cycle, branch):
    return table[(table.cycle == cycle) & (table.branch == branch)]


@pytest.mark.parametrize("unknown", [[2], [0], [4], [1, 3], [0, 1, 2, 3]])
def test_a_curve_is_not_known_beside_a_step_whose_value_is_not_known(unknown):
    stress, values = np.arange(5.0), np.arange(5.0) ** 2
    values[unknown] = np.nan
    levels = np.linspace(0.0, 4.0, 17)
    read = cubic_over(stress, values)(levels)
    sides = np.floor(levels).astype(int), np.ceil(levels).astype(int)
    known = np.isfinite(values[sides[0]]) & np.isfinite(values[sides[1]])
    np.testing.assert_array_equal(np.isfinite(read), known)
    at_steps = np.isin(levels, stress) & known
    np.testing.assert_allclose(read[at_steps], levels[at_steps] ** 2)


def test_the_stiffness_of_a_hyperbola_is_that_of_bandis():
    """kn = kni (1 + (sigma - s)/(Vm kni))^2: Bandis et al. 1983, Eq. 8."""
    kni, vm = TRUE["hyperbolic"]
    table = stress_table(following("hyperbolic", kni, vm))
    above = table.normal_stress_MPa - SEATING
    exact = kni * (1.0 + above / (vm * kni)) ** 2
    np.testing.assert_allclose(table.normal_stiffness_net_MPa_per_mm, exact, rtol=0.02)


def test_stresses_of_a_table_are_round_up_to_the_stated_maximum():
    """Steps meet the maximum within a tolerance only."""
    history = following("hyperbolic", *TRUE["hyperbolic"])
    for miss in (1.0006, 0.9995):
        of_steps = history.normal_stress / history.normal_stress.max() * 1e6 * LARGEST * miss
        table = stress_table(history.assign(normal_stress=of_steps))
        levels = on(table, 1, "loading").normal_stress_MPa
        assert levels.tolist() == [0.5 * number for number in range(1, 21)]
        assert table.closure_net_since_seating_mm.notna().all()


def test_stresses_of_the_table_of_a_halted_joint_end_where_it_halted():
    history = following("hyperbolic", *TRUE["hyperbolic"])
    halted = history.assign(normal_stress=0.5 * history.normal_stress)
    assert 1e-6 * history_of(halted).table_levels()[-1] == 0.5 * LARGEST


@pytest.mark.parametrize(("seating", "largest"), [(0.0, 7e6), (0.37e6, 12.3e6), (20.0, 450.0)])
def test_stresses_of_a_table_lie_on_one_round_interval(seating, largest):
    levels = round_levels(seating, largest)
    assert levels[-1] == largest
    assert (levels[0] == seating) == (seating > 0.0)
    interval = np.diff(levels)[2]
    assert f"{interval:.1e}"[:3] in ("1.0", "2.0", "2.5", "5.0")
    inner = levels[1:-1] / interval
    np.testing.assert_allclose(inner, np.round(inner), rtol=1e-12)
    assert 8 <= levels.size <= 22


def test_the_stiffness_at_a_stress_does_not_depend_on_others_that_are_read(closed):
    name = "normal_stiffness_net_MPa_per_mm"
    usual = stress_table(closed).set_index(["cycle", "branch", "normal_stress_MPa"])[name]
    named = history_of(closed).table_levels([2e6, 2.3e6])
    for levels in (np.array([2e6]), np.array([2e6, 4e6]), named):
        table = stress_table(closed, levels).set_index(usual.index.names)[name]
        both = usual.index.intersection(table.index)
        assert {2.0} <= set(both.get_level_values(2))
        pd.testing.assert_series_equal(table.loc[both], usual.loc[both], check_exact=True)
    assert {2.0, 2.3} <= set(1e-6 * named)


def test_steps_before_the_maximum_in_which_nothing_breaks_are_not_its_stiffness():
    """The closure over the last percent of the stress is flat; no later step corrects it."""
    kni, vm = TRUE["hyperbolic"]
    history = following("hyperbolic", kni, vm)
    flat = history.closure.copy()
    flat[-404:-399] = flat[-404]
    last = [
        on(stress_table(each), 1, "loading").normal_stiffness_net_MPa_per_mm.iloc[-1]
        for each in (history, history.assign(closure=flat))
    ]
    assert last[1] == pytest.approx(last[0], rel=0.3)


def test_stiffness_rises_with_stress_however_the_closure_was_reached(closed):
    """Breakage makes its chords a saw; they keep their mean, and end where a landing begins."""
    for history in (closed, joint(cycles=1, breakage="resolved")):
        table = stress_table(history, history_of(history).stress_levels(60))
        for _, rows in table.groupby(["cycle", "branch"]):
            known = rows.dropna()
            stiffness, stress = known.normal_stiffness_net_MPa_per_mm, known.normal_stress_MPa
            assert stiffness.iloc[0] > 0.0
            assert (np.diff(stiffness) >= 0.0).all()
            rise = np.diff(known.closure_net_since_seating_mm.iloc[[0, -1]])[0]
            assert np.trapezoid(1.0 / stiffness, stress) == pytest.approx(rise, rel=0.1)
    first, end = (
        on(stress_table(closed), 1, "loading"),
        1e-6 * history_of(closed).landing_stresses[0],
    )
    landed = first.normal_stiffness_net_MPa_per_mm.isna()
    assert (first.normal_stress_MPa[landed] > 0.98 * end).all()
    assert landed.any()
    assert not on(stress_table(closed), 2, "loading").normal_stiffness_net_MPa_per_mm.isna().any()


def test_a_loading_beyond_the_former_maximum_is_read_on_both_sides_of_it():
    walls, load = pair((20, 24)), {"seating_stress": 0.5e6, "numerics": COARSE}
    whole, once = (joints.closed(walls, stress, **load) for stress in ([4e6, 0, 8e6], [4e6]))
    stiffness, alone = (net_responses(each)["stiffness_net"] for each in (whole, once))
    assert stiffness[0] == alone[0]  # from half of the maximum of its cycle, not of the joint
    at = history_of(whole).net.at(np.array([4e6, 8e6]))[1, 0]
    assert stiffness[1] == pytest.approx(4e6 / (at[1] - at[0]), rel=0.02)
    again = on(stress_table(whole), 2, "loading").set_index("normal_stress_MPa")
    kn = again.normal_stiffness_net_MPa_per_mm
    assert kn[kn.index < 4.0].is_monotonic_increasing
    assert kn[kn.index > 4.0].is_monotonic_increasing
    assert kn[kn.index < 4.0].iloc[-1] > 2.0 * kn[kn.index > 4.0].iloc[0]
    assert {(1, "loading"), (2, "unloading")} <= law_curves(whole).keys()
    assert (2, "loading") not in law_curves(whole)
    with pytest.raises(jc.InputError, match=r"beyond its former maximum, 4 MPa"):
        porepy_files(whole, stress_table(whole), 2)
    straight = following("power", 0.01, 1.02)
    with pytest.raises(jc.InputError, match=r"cycle 1 hardly bends"):
        porepy_files(straight, stress_table(straight))


@pytest.mark.parametrize("reading", [GROSS, NET])
def test_a_secant_ends_where_the_landing_begins(closed, reading):
    """Net of bulk indentation no step is a whole one: the landing is that of the closure."""
    end = history_of(closed).landing_stresses[0]
    closures = history_of(closed).curve(reading).at(np.array([2e6, end, 5e6]))[:, 0]
    first = (end - 2e6) / (closures[0, 1] - closures[0, 0])
    assert history_of(closed).curve(reading).secant_stiffness(1, 2e6, 5e6) == pytest.approx(first)
    assert first < (5e6 - 2e6) / (closures[0, 2] - closures[0, 0])
    second = (5e6 - 2e6) / (closures[1, 2] - closures[1, 0])
    assert history_of(closed).curve(reading).secant_stiffness(2, 2e6, 5e6) == pytest.approx(second)
    assert np.isnan(history_of(closed).curve(reading).secant_stiffness(1, end, 5e6))


def test_curves_agree_with_the_history(closed):
    table = curve_table(closed)
    first = on(table, 1, "loading")
    assert first.closure_gross_mm.iloc[-1] == pytest.approx(1e3 * float(closed.max_closure[0]))
    assert history_of(closed).area == pytest.approx(20 * 24 * SPACING**2)
    stays = 1e3 * closed.residual_closure_seated.values
    np.testing.assert_allclose(cycle_table(closed).residual_closure_seated_mm, stays)
    unloading = on(table, 1, "unloading")
    back = np.interp(
        SEATING, *unloading[["normal_stress_MPa", "closure_gross_since_seating_mm"]].values[::-1].T
    )
    assert stays[0] == pytest.approx(back)
    # void volume falls by the area times the closure, less what half-spaces and contacts give way
    lost = first.void_volume_mm3.iloc[0] - first.void_volume_mm3.iloc[-1]
    area, overlap = 1e6 * history_of(closed).area, 1e3 * closed.mean_overlap.values
    closes = (
        first.closure_net_mm.iloc[-1] - overlap[history_of(closed).branch(1, "loading").steps[-1]]
    )
    assert lost == pytest.approx(area * closes, rel=1e-9)


def test_softer_half_spaces_change_gross_columns_alone(closed):
    """The joint's own closure knows nothing of how far the intact rock gives way."""
    linear = '{"breakage": "fixed_step", "target": "interpolate"}'
    closed = closed.assign_attrs(numerics=linear)  # no landing, whose steps are gross
    softer = on_softer_half_spaces(closed)
    for table in (curve_table, cycle_table, stress_table):
        one, other = table(closed), table(softer)
        net = [name for name in one if "_net" in name]
        gross = [name.replace("_net", "" if table is cycle_table else "_gross") for name in net]
        for name in gross:  # at one stress the half-spaces are where they were
            same = np.allclose(one[name], other[name], rtol=1e-9, equal_nan=True)
            assert same == name.startswith("residual_closure")
        pd.testing.assert_frame_equal(
            one.drop(columns=gross), other.drop(columns=gross), rtol=1e-5, atol=1e-9
        )
    curves = law_curves(softer)
    for key, (stress, closure) in law_curves(closed).items():
        np.testing.assert_array_equal(curves[key][0], stress)
        np.testing.assert_allclose(curves[key][1], closure, rtol=1e-6, atol=1e-9)
    for cycle in (1, 2):
        stiffness = history_of(closed).net.secant_stiffness(cycle, 2e6, 4e6)
        assert history_of(softer).net.secant_stiffness(cycle, 2e6, 4e6) == pytest.approx(stiffness)


def test_chords_before_a_landing_know_nothing_of_it(closed):
    """A cubic through all steps would bring the stiffness of the landing into the chord before."""
    end = history_of(closed).landing_stresses[0]
    first = history_of(closed).branch(1, "loading").steps
    kept = first[closed.normal_stress.values[first] <= end]
    levels = np.linspace(0.9 * end, end, 4)
    without = history_of(closed.isel(step=kept).assign_attrs(numerics="{}")).net.at(levels)
    np.testing.assert_array_equal(history_of(closed).net.at(levels)[0, 0], without[0, 0])


def test_bulk_indentation_and_laws_end_at_the_same_landing(closed):
    end = np.array([history_of(closed).landing_stresses[0]])
    bulk = history_of(closed).gross.at(end) - history_of(closed).net.at(end)
    at_end = np.flatnonzero(closed.normal_stress.values == end)[0]
    assert bulk[0, 0, 0] == pytest.approx(closed.bulk_indentation.values[at_end])
    stress, fitted = law_curves(closed)[1, "loading"]
    closures = history_of(closed).net.at(1e6 * stress[[0, -1]])[0, 0]
    assert fitted[-1] == pytest.approx(1e3 * np.diff(closures)[0])
