"""Curves, stiffness and laws of a closed joint, held against what they must be."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.cli.exports import porepy_files
from jointclosure.joint.curves import (
    closures_at,
    round_levels,
    secant_stiffness,
    stress_levels,
    table_levels,
)
from jointclosure.joint.cycles import net_responses
from jointclosure.joint.history import GROSS, NET, history_of
from jointclosure.joint.interpolation import cubic_over
from jointclosure.joint.laws import (
    CYCLES,
    LAWS,
    barton_bandis,
    check_joint_lengths,
    fit_law,
    fitted_laws,
    law_curves,
    laws_of_joint,
    parameter,
    scaled_to,
)
from jointclosure.joint.tables import curve_table, cycle_table, stress_table
from tests import joints
from tests.joints import COARSE, SPACING, on_softer_half_spaces, pair

SEATING, LARGEST = 0.5, 10.0


def joint(**stated):
    return joints.closed(pair((20, 24)), 5e6, **{"seating_stress": 0.5e6} | stated)


@pytest.fixture(scope="module")
def closed():
    return joint(flow=True)


def on(table, cycle, branch):
    return table[(table.cycle == cycle) & (table.branch == branch)]


def following(law, *parameters):
    """A joint of one loading, and back, that follows a law in MPa and mm."""
    stress = np.linspace(SEATING, LARGEST, 400)
    closure = LAWS[law].closure(stress, SEATING, *parameters)
    closure = np.concatenate([[closure[0] - 0.01], closure]) - closure[0] + 0.01
    stress = np.concatenate([[0.0], stress])
    up, down = stress.size, stress.size - 1
    there = np.concatenate([np.arange(up), np.arange(down)[::-1]])
    return xr.Dataset(
        {
            "closure": ("step", 1e-3 * closure[there]),
            "bulk_indentation": ("step", 0.0 * there),
            "normal_stress": ("step", 1e6 * stress[there]),
            "mean_aperture": ("step", 1e-3 * (1.0 - closure[there])),
            "contact_fraction": ("step", stress[there] / 100.0),
        },
        coords={
            "load_cycle": ("step", np.ones(there.size, int)),
            "branch": ("step", np.repeat(["loading", "unloading"], [up, down])),
            "y": np.arange(3) * 1e-3,
            "x": np.arange(5) * 1e-3,
        },
        attrs={"seating_stress_Pa": 1e6 * SEATING, "max_normal_stress_Pa": 1e6 * LARGEST},
    )


TRUE = {
    "hyperbolic": (12.0, 0.3),
    "semi_logarithmic": (-0.301029995663981, 6.0),
    "power": (0.09, 0.4),
}


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


@pytest.mark.parametrize("law", LAWS)
def test_a_joint_that_follows_a_law_gives_its_parameters_back(law):
    fits = fitted_laws(following(law, *TRUE[law]))
    for name, value in zip(LAWS[law].parameters, TRUE[law], strict=True):
        assert parameter(fits, 1, "loading", name) == pytest.approx(value, rel=2e-3)
    own = fits[(fits.law == law) & (fits.branch == "loading")].iloc[0]
    assert own.r_squared > 0.9999
    assert (own.holds_from_MPa, own.holds_to_MPa) == pytest.approx((SEATING, LARGEST), rel=1e-6)


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
    assert 1e-6 * table_levels(halted)[-1] == 0.5 * LARGEST


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


def test_the_stiffness_at_a_stress_does_not_depend_on_the_other_stresses_that_are_read(closed):
    name = "normal_stiffness_net_MPa_per_mm"
    usual = stress_table(closed).set_index(["cycle", "branch", "normal_stress_MPa"])[name]
    named = table_levels(closed, [2e6, 2.3e6])
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
        table = stress_table(history, stress_levels(history, 60))
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
    at = closures_at(whole, np.array([4e6, 8e6]))[1, 0]
    assert stiffness[1] == pytest.approx(4e6 / (at[1] - at[0]), rel=0.02)
    again = on(stress_table(whole), 2, "loading").set_index("normal_stress_MPa")
    kn = again.normal_stiffness_net_MPa_per_mm
    assert kn[kn.index < 4.0].is_monotonic_increasing
    assert kn[kn.index > 4.0].is_monotonic_increasing
    assert kn[kn.index < 4.0].iloc[-1] > 2.0 * kn[kn.index > 4.0].iloc[0]
    assert {(1, "loading"), (2, "unloading")} <= law_curves(whole).keys()
    assert (2, "loading") not in law_curves(whole)
    with pytest.raises(jc.InputError, match=r"beyond its former maximum, 4 MPa"):
        porepy_files(whole, stress_table(whole))
    straight = following("power", 0.01, 1.02)
    with pytest.raises(jc.InputError, match=r"cycle 1 hardly bends"):
        porepy_files(straight, stress_table(straight))


@pytest.mark.parametrize("reading", [GROSS, NET])
def test_a_secant_ends_where_the_landing_begins(closed, reading):
    """Net of bulk indentation no step is a whole one: the landing is that of the closure."""
    end = history_of(closed).landing_stresses[0]
    closures = closures_at(closed, np.array([2e6, end, 5e6]), reading)[:, 0]
    first = (end - 2e6) / (closures[0, 1] - closures[0, 0])
    assert secant_stiffness(closed, 1, 2e6, 5e6, reading) == pytest.approx(first)
    assert first < (5e6 - 2e6) / (closures[0, 2] - closures[0, 0])
    second = (5e6 - 2e6) / (closures[1, 2] - closures[1, 0])
    assert secant_stiffness(closed, 2, 2e6, 5e6, reading) == pytest.approx(second)
    assert np.isnan(secant_stiffness(closed, 1, end, 5e6, reading))


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
        stiffness = secant_stiffness(closed, cycle, 2e6, 4e6)
        assert secant_stiffness(softer, cycle, 2e6, 4e6) == pytest.approx(stiffness)


def test_the_barton_bandis_law_since_seating_is_the_same_curve():
    laws = laws_of_joint(9.0, 150e6, 0.5e6, 5)
    assert set(laws.by_cycle) == set(CYCLES)
    for cycle, since in laws.by_cycle.items():
        law, stress = barton_bandis(9.0, 150e6, 1.0, cycle), np.linspace(0.5e6, 20e6, 9)
        closed = law.closure(stress) - law.closure(0.5e6)
        np.testing.assert_allclose(since.closure(stress - 0.5e6), closed, atol=1e-15)


@pytest.mark.parametrize("jrc", [float("nan"), 4.0, 19.0])
def test_barton_bandis_laws_are_left_out_for_a_jrc_outside_of_their_range(jrc):
    left_out = laws_of_joint(jrc, 150e6, 0.5e6, 2)
    assert not left_out.by_cycle
    assert "left out" in left_out.sentence()


@pytest.mark.parametrize("power", [2.0, 1.0, 1.0 - 1e-9, 0.98])
def test_the_largest_closure_of_a_curve_that_does_not_bend_is_undetermined(power):
    stress, part = np.linspace(0.5, 10.0, 60), np.linspace(0.0, 1.0, 60)
    (kni, vm), errors, fit = fit_law(LAWS["hyperbolic"], stress, 0.0187 * part**power, 0.5)
    assert np.isnan(vm)
    assert np.isnan(errors[1])
    assert kni == pytest.approx(9.5 / 0.0187, rel=0.35)
    assert fit["rms_mm"] < 0.0187


@pytest.mark.parametrize(("ratio", "determined"), [(1.2, True), (9.5, True), (10.5, False)])
def test_the_largest_closure_is_determined_up_to_ten_times_the_measured_one(ratio, determined):
    stress = np.linspace(0.5, 10.0, 60)
    vm = 0.1 * ratio
    kni = 9.5 * (1.0 / 0.1 - 1.0 / vm)  # so that the closure at 10 MPa is 0.1 mm
    closure = LAWS["hyperbolic"].closure(stress, 0.5, kni, vm)
    fitted = fit_law(LAWS["hyperbolic"], stress, closure, 0.5)[0]
    assert fitted[0] == pytest.approx(kni, rel=1e-6)
    assert fitted[1] == pytest.approx(vm if determined else np.nan, rel=1e-6, nan_ok=True)


def test_the_laws_of_a_straight_loading_have_a_stiffness_alone():
    fits = fitted_laws(following("power", 0.01, 1.0))
    assert np.isnan(parameter(fits, 1, "loading", "vm_mm"))
    assert parameter(fits, 1, "loading", "kni_MPa_per_mm") == pytest.approx(100.0, rel=0.01)


def test_chords_before_a_landing_know_nothing_of_it(closed):
    """A cubic through all steps would bring the stiffness of the landing into the chord before."""
    end = history_of(closed).landing_stresses[0]
    first = history_of(closed).branch(1, "loading").steps
    kept = first[closed.normal_stress.values[first] <= end]
    levels = np.linspace(0.9 * end, end, 4)
    without = closures_at(closed.isel(step=kept).assign_attrs(numerics="{}"), levels)
    np.testing.assert_array_equal(closures_at(closed, levels)[0, 0], without[0, 0])


def test_bulk_indentation_and_laws_end_at_the_same_landing(closed):
    end = np.array([history_of(closed).landing_stresses[0]])
    bulk = closures_at(closed, end, GROSS) - closures_at(closed, end, NET)
    at_end = np.flatnonzero(closed.normal_stress.values == end)[0]
    assert bulk[0, 0, 0] == pytest.approx(closed.bulk_indentation.values[at_end])
    stress, fitted = law_curves(closed)[1, "loading"]
    closures = closures_at(closed, 1e6 * stress[[0, -1]], NET)[0, 0]
    assert fitted[-1] == pytest.approx(1e3 * np.diff(closures)[0])


def test_errors_of_a_laws_parameters_are_their_scatter():
    stress, random = np.linspace(SEATING, LARGEST, 60), np.random.default_rng(1)
    law = LAWS["power"]
    exact = law.closure(stress, SEATING, *TRUE["power"])
    fits = [
        fit_law(law, stress, exact + 1e-3 * random.standard_normal(60), SEATING)[:2]
        for _ in range(200)
    ]
    values, errors = np.array(fits).swapaxes(0, 1)
    np.testing.assert_allclose(errors.mean(axis=0), values.std(axis=0), rtol=0.2)


def test_a_law_holds_in_the_range_of_small_misses():
    stress, law = np.linspace(SEATING, LARGEST, 60), LAWS["power"]
    exact = law.closure(stress, SEATING, *TRUE["power"])
    # a jump at two thirds of the stresses that no law follows
    jumped = exact + 0.4 * exact.max() * (stress > 7.0)
    values, _, fit = fit_law(law, stress, jumped, SEATING)
    miss = np.abs(law.closure(stress, SEATING, *values) - jumped) / jumped.max()
    inside = (stress >= fit["holds_from_MPa"]) & (stress <= fit["holds_to_MPa"])
    assert miss[inside].max() <= 0.05 < miss.max()
    assert 10 < inside.sum() < 50


def test_barton_bandis_laws_are_left_out_where_a_constant_is_not_above_zero():
    for strength, cycles in ((100e6, [1, 2, 3]), (3e9, [])):
        laws = laws_of_joint(5.0, strength, 0.5e6, 5).by_cycle
        assert list(laws) == cycles
        assert all(min(law) > 0.0 for law in laws.values())


def test_longer_joints_have_smaller_constants():
    """Barton & Bandis 1982: JRC 10 and 100 MPa of 100 mm at 400 mm, by hand."""
    assert scaled_to(0.4, 10.0, 100e6) == pytest.approx((10.0 * 4.0**-0.2, 100e6 * 4.0**-0.3))
    assert scaled_to(0.1, 10.0, 100e6) == (10.0, 100e6)


def test_laws_of_longer_joints_are_those_of_their_scaled_constants():
    lab, field = (laws_of_joint(10.0, 150e6, 0.5e6, 2, length) for length in (None, 1.0))
    assert field.scaled == scaled_to(1.0, 10.0, 150e6)
    expected = barton_bandis(field.scaled[0], 150e6, 150e6 / field.scaled[1], 1)
    assert field.by_cycle[1] == expected.since(0.5e6)
    assert laws_of_joint(10.0, 150e6, 0.5e6, 2, 0.1).by_cycle == lab.by_cycle


def test_laws_of_longer_joints_state_the_constants_of_both_lengths():
    field = laws_of_joint(10.0, 150e6, 0.5e6, 2, 1.0)
    for value in ("JRC 6.3 at 1000 mm", "JRC is 10", "JCS 75.2 MPa", "JCS 150 MPa"):
        assert value in field.sentence()
    record = field.record()
    assert (record["lab_jrc"], record["joint_length_mm"]) == (10.0, 1000.0)
    assert record["jrc"] == field.scaled[0]


def test_a_law_is_left_out_by_the_jrc_of_its_length():
    laws = laws_of_joint(6.0, 150e6, 0.5e6, 2, 10.0)
    assert not laws.by_cycle
    assert "not for 3.5 at 10000 mm, scaled from 6 at 100 mm" in laws.sentence()


@pytest.mark.parametrize(
    ("joint_length", "lab_length", "message"),
    [
        (0.05, 0.1, r"joint_length = 50 mm: must be at least lab_length = 100 mm"),
        (-1.0, 0.1, r"joint_length = -1.0 m: must be positive"),
        (None, 0.0, r"lab_length = 0.0 m: must be positive"),
    ],
)
def test_lengths_that_scale_no_joint_are_refused(joint_length, lab_length, message):
    with pytest.raises(jc.InputError, match=message):
        check_joint_lengths(joint_length, lab_length)
