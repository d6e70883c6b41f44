"""Settings that have no effect with the others are refused, and others are not."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.joint.simulation import simulate_walls
from jointclosure.parameters import check_effective, check_numerics, well_posed_scenes
from tests.joints import DOLERITE, ELASTIC, SPACING, pair

REFERENCE = jc.Numerics(solver="reference")
WITHOUT_PEAKS = jc.Effects(soft_peaks=False)
ALONE = jc.Effects(False, False, False, False, True)
IDLE = [
    # effects, usual numerics, what is changed, what is said
    (jc.Effects(), jc.Numerics(), {"tolerance": 0.005}, "on fixed steps of breakage"),
    (jc.Effects(), RESOLVED, {"breakage_step": 5e-7}, "on resolved breakage"),
    (jc.Effects(), RESOLVED, {"later_breakage_step": 5e-7}, "on resolved breakage"),
    (jc.Effects(), jc.Numerics(), {"sweep_tolerance": 1e-3}, "on solver = 'fast'"),
    (jc.Effects(), REFERENCE, {"force_tolerance": 1e-6}, "on solver = 'reference'"),
    (jc.Effects(), jc.Numerics(), {"curve_points": 40}, "with steps"),
    (ELASTIC, REFERENCE, {"curve_points": 40}, "with steps"),
    (ELASTIC, RESOLVED, {"tolerance": 0.005}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"displacement_step": 6e-6}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"later_displacement_step": 6e-6}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"breakage_step": 5e-7}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"target": "interpolate"}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"most_breakage_steps": 1e3}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"replay": False}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"idle_interaction": 0.02}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"crushed_strength_ratio": 0.8}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"tie_tolerance": 1e-6}, "without breakage"),
    (ELASTIC, jc.Numerics(), {"peaks": "current"}, "without breakage"),
    (WITHOUT_PEAKS, jc.Numerics(), {"peaks": "current"}, "without soft_peaks"),
    (WITHOUT_PEAKS, jc.Numerics(), {"peak_modulus_ratio": 0.1}, "without soft_peaks"),
    (jc.Effects(interaction=False), jc.Numerics(), {"idle_interaction": 0.02}, "without inter"),
    (ALONE, jc.Numerics(), {"base_radius_in_cells": 0.6}, "without substrate"),
]


def changed(numerics, change):
    """Numerics and choices with changed fields; those of the numerics are not checked."""
    of_choices = {name: value for name, value in change.items() if name in jc.Choices._fields}
    of_numerics = {name: value for name, value in change.items() if name not in of_choices}
    return jc.Choices(**of_choices), numerics._replace(**of_numerics)


def closed(effects, choices, numerics):
    """A joint in two cycles whose settings are not examined."""
    load = Conditions(SPACING, DOLERITE, 8e6, 2, 0.5e6).checked()
    return simulate_walls(
        *pair(12), load._replace(effects=effects, choices=choices, numerics=numerics)
    )


@pytest.mark.parametrize(("effects", "usual", "change", "said"), IDLE)
def test_a_changed_setting_without_effect_is_refused_by_name(effects, usual, change, said):
    choices, numerics = changed(usual, change)
    load = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6}
    ((name, value),) = change.items()
    with pytest.raises(jc.InputError) as refused:
        jc.simulate(*pair(6), **load, effects=effects, choices=choices, numerics=numerics)
    assert str(refused.value).startswith(f"{name} = {value!r}: has no effect {said}")


@pytest.mark.parametrize(("effects", "usual", "change", "said"), IDLE)
def test_a_setting_that_is_refused_as_without_effect_changes_no_bit(effects, usual, change, said):
    as_usual = closed(effects, jc.Choices(), usual)
    other = closed(effects, *changed(usual, change))
    for name in ("closure", "normal_stress", "mean_aperture", "contact_fraction"):
        assert np.array_equal(as_usual[name], other[name]), name


@pytest.mark.parametrize("numerics", [jc.Numerics(), RESOLVED])
def test_usual_settings_are_accepted_with_any_effects(numerics):
    for scene in well_posed_scenes():
        for bound in ("base", "none"):
            check_effective(scene, jc.Choices(strength_bound=bound), numerics)


def test_settings_are_accepted_where_they_act():
    check_effective(jc.Effects(), jc.Choices(), RESOLVED._replace(tolerance=0.005))
    check_effective(jc.Effects(), jc.Choices(), jc.Numerics(breakage_step=1e-6))
    check_effective(ELASTIC, jc.Choices(), jc.Numerics(curve_points=40))
    check_effective(jc.Effects(), jc.Choices(), REFERENCE._replace(sweep_tolerance=1e-4))
    check_effective(
        jc.Effects(), jc.Choices(peak_modulus_ratio=0.1, crushed_strength_ratio=0.8),
        jc.Numerics(idle_interaction=0.02, target="interpolate", replay=False),
    )  # fmt: skip


def test_a_setting_that_acts_without_an_effect_is_accepted_where_effects_are_left_out():
    points = jc.Numerics(curve_points=40)
    check_effective(jc.Effects(), jc.Choices(), points, varied=True)
    with pytest.raises(jc.InputError, match=r"tolerance = 0\.005: has no effect on fixed"):
        check_effective(jc.Effects(), jc.Choices(), jc.Numerics(tolerance=0.005), varied=True)


def test_breakage_steps_need_not_be_shorter_than_the_others_where_they_are_not_used():
    check_numerics(jc.Numerics(breakage="resolved", displacement_step=1e-6))
    with pytest.raises(jc.InputError, match="breakage_step = 5e-06 m: must be smaller"):
        jc.Numerics(displacement_step=1e-6)


def test_every_function_that_closes_joints_refuses_a_tolerance_of_fixed_steps(small_joint):
    load = {"rock": DOLERITE, "max_normal_stress": 1e6, "numerics": jc.Numerics(tolerance=0.005)}
    doors = {
        "simulate": lambda: jc.simulate(*small_joint, spacing=SPACING, **load),
        "ensemble": lambda: jc.simulate_ensemble([small_joint], spacing=SPACING, **load),
        "effects": lambda: jc.choose_effects([small_joint], spacing=SPACING, **load),
        "assess": lambda: jc.assess(small_joint, spacing=SPACING, **load),
        "close": lambda: jc.close("no_file.xyz", "no_file.xyz", **load),
    }
    for close in doors.values():
        with pytest.raises(jc.InputError, match=r"tolerance = 0\.005: has no effect on fixed"):
            close()
    still = {"spacing": SPACING, "rock": DOLERITE, "closure": 1e-6}
    with pytest.raises(jc.InputError, match=r"tolerance = 0\.005: has no effect without breakage"):
        jc.equilibrium(*small_joint, **still, numerics=load["numerics"])
