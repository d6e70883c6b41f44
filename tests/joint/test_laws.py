"""Laws of closure: fitted to a joint, and that of Barton and Bandis for its length."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.laws import (
    CYCLES,
    LAWS,
    barton_bandis,
    check_joint_lengths,
    fit_law,
    fitted_laws,
    laws_of_joint,
    loading_hyperbolas,
    scaled_to,
)

SEATING = 0.5


LARGEST = 10.0


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


@pytest.mark.parametrize("law", LAWS)
def test_a_joint_that_follows_a_law_gives_its_parameters_back(law):
    fits = fitted_laws(following(law, *TRUE[law]))
    of_loading = fits[(fits.law == law) & (fits.branch == "loading") & (fits.cycle == 1)]
    assert of_loading.parameter.tolist() == list(LAWS[law].parameters)
    assert of_loading.value.tolist() == pytest.approx(TRUE[law], rel=2e-3)
    own = fits[(fits.law == law) & (fits.branch == "loading")].iloc[0]
    assert own.r_squared > 0.9999
    assert (own.holds_from_MPa, own.holds_to_MPa) == pytest.approx((SEATING, LARGEST), rel=1e-6)


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


def test_the_initial_stiffness_of_a_curve_that_begins_flat_is_undetermined():
    """All closure is there at once, so that any small kni fits as well: it is not 0."""
    stress = np.linspace(0.5, 10.0, 60)
    closure = np.where(stress > 0.5, 0.02, 0.0)
    (kni, _), errors, _ = fit_law(LAWS["hyperbolic"], stress, closure, 0.5)
    assert np.isnan([kni, errors[0]]).all()


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
    kni, vm = loading_hyperbolas(following("power", 0.01, 1.0), [1]).loc[1]
    assert np.isnan(vm)
    assert kni == pytest.approx(100.0, rel=0.01)


def test_the_hyperbola_of_a_loading_that_was_not_fitted_is_unknown():
    known, unknown = loading_hyperbolas(following("hyperbolic", *TRUE["hyperbolic"]), [1, 7]).values
    np.testing.assert_allclose(known, TRUE["hyperbolic"], rtol=2e-3)
    assert np.isnan(unknown).all()


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
