"""Every function that closes joints takes the same conditions, and refuses the same ones."""

import functools
import inspect
import re
import warnings
from unittest.mock import Mock

import numpy as np
import pytest

import jointclosure as jc
from jointclosure import parameters
from jointclosure.joint import load
from jointclosure.joint.conditions import RESOLVED, SCAN_DEFAULTS, conditions_from
from jointclosure.joint.rocks import ROCKS
from jointclosure.parameters import USUAL, check_radius, check_usual
from jointclosure.walls.gridding import Scan
from studies.frame.experiments import experiment_named
from studies.frame.rocks import ScannedWalls
from studies.frame.scanned_walls import prepared_walls
from tests.joints import DOLERITE, ELASTIC, SPACING, pair
from tests.measured.test_likelihood import GOOD


def scans_of(upper, lower, spacing):
    """Scans in one frame, z upwards, of which the upper one lies above the other."""
    above = 3.0 * np.abs(upper).max()
    return [Scan(wall, (spacing, spacing), (0.0, 0.0)) for wall in (above - upper, lower)]


def close(upper, lower, spacing=SPACING, **given):
    about = {"single": True, "orientation": "common_frame"}
    return jc.close(*scans_of(upper, lower, spacing), **about, **given).history


def choose(*walls, **given):
    return jc.choose_effects([walls], **given).closed[0].closed


CLOSE = {
    "simulate": jc.simulate,
    "simulate_ensemble": lambda *walls, **given: jc.simulate_ensemble([walls], workers=1, **given),
    "choose_effects": choose,
    "close": close,
}
"""Functions of two walls and conditions that close a joint."""
ONCE = {"spacing": SPACING, "effects": ELASTIC, "cycles": 1}


def first_closure(door, **given):
    return float(np.ravel(CLOSE[door](*pair(24), **ONCE | given).max_closure)[0])


@pytest.mark.parametrize("door", ["close", "assess"])
def test_the_signature_of_a_function_of_scans_shows_the_numerics_that_it_takes(door):
    shown = inspect.signature(getattr(jc, door)).parameters
    assert shown["numerics"].default == RESOLVED
    assert shown["spacing"].default is None


def test_the_known_word_nearest_to_an_unknown_one_is_named():
    known = {"spacing": SPACING, "max_normal_stress": 1e6}
    with pytest.raises(jc.InputError, match=r"one of dolerite, .*; did you mean granite\?"):
        jc.simulate(*pair(12), rock="granit", **known)
    with pytest.raises(jc.InputError, match=r"resolved; did you mean resolved\?"):
        jc.Numerics(breakage="resolve")
    with pytest.raises(jc.InputError, match=r"did you mean compressive_strength\?"):
        jc.close(
            "a",
            "b",
            rock="slate",
            max_normal_stress=1e6,
            ranges={"compressive_strenght": (1e8, 2e8)},
        )
    with pytest.raises(jc.InputError, match=r"; did you mean mismatch\?"):
        experiment_named("mismach")


@pytest.mark.parametrize("door", CLOSE)
def test_a_rock_is_given_by_its_name_or_its_properties(door):
    # also below the usual seating stress
    assert first_closure(door, rock="granite", max_normal_stress=27e3) > 0.0
    granite = ROCKS["granite"].intact
    given = ("granite", granite, ("Granite", granite))
    assert len({first_closure(door, rock=rock, max_normal_stress=2e6) for rock in given}) == 1
    for rock in ("marble", None, 3):
        message = f"rock = {rock!r}: must be a Rock or one of dolerite"
        with pytest.raises(jc.InputError, match=message):
            first_closure(door, rock=rock, max_normal_stress=2e6)


def as_scans_of_a_study(upper, lower, spacing, **_):
    about = ScannedWalls(upper="top", lower="bottom", units="mm")
    scans = dict(zip(("upper", "lower"), scans_of(upper, lower, spacing), strict=True))
    return prepared_walls(scans, about, spacing, "yu_vayssade_linear_0.25mm")


DOORS = CLOSE | {
    "equilibrium": lambda *walls, max_normal_stress, **given: jc.equilibrium(
        *walls, closure=1e-6, **given
    ),
    "study": as_scans_of_a_study,
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("what", ["heights", "spacing"])
@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_a_unit_a_thousand_times_off_is_refused_or_warned_of(door, what, factor):
    walls = np.array(jc.wall_pair(8.0, (32, 32), SPACING, 7, correlation=0.9))
    walls = walls * (factor if what == "heights" else 1.0)
    spacing = SPACING * (factor if what == "spacing" else 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # so that nothing is computed
        with pytest.raises((jc.InputError, UserWarning)):
            DOORS[door](*walls, spacing=spacing, rock=DOLERITE, max_normal_stress=1e6)


NUMERICS, CHOICES = jc.Numerics(), jc.Choices()
# changed by _replace, which checks nothing
SETTINGS = [
    (CHOICES, {"base_radius_in_cells": 1.5}, "base_radius_in_cells = 1.5: must lie in (0, 1]"),
    (CHOICES, {"peak_modulus_ratio": 0.0}, "peak_modulus_ratio = 0.0: must lie in (0, 1]"),
    (CHOICES, {"tie_tolerance": 1e-3}, "tie_tolerance = 0.001: must lie in (0, 0.001)"),
    (CHOICES, {"largest_radius": 1e-4}, "largest_radius = 0.0001 m: must be at least the grid"),
    (CHOICES, {"peaks": "some"}, "peaks = 'some'"),
    (CHOICES, {"peaks": "current", "crushed_strength_ratio": 0.8}, "must be 1 with peaks"),
    (NUMERICS, {"breakage_step": 12.5e-6}, "breakage_step = 1.25e-05"),
    (NUMERICS, {"later_breakage_step": 7e-6}, "later_breakage_step = 7e-06"),
    (NUMERICS, {"breakage": "some"}, "breakage = 'some'"),
    (NUMERICS, {"breakage": "resolved", "solver": "reference"}, "not with solver = 'reference'"),
    (NUMERICS, {"breakage": "resolved", "target": "interpolate"}, "interpolate"),
    *(
        (NUMERICS, {name: value}, f"{name} = {value!r}")
        for name, values in {
            "idle_interaction": (-0.1, np.nan, 1.0),
            "tolerance": (0.0, 0.11),
            "curve_points": (0, 2.5, True),
            "most_steps": (0, -1.0, np.nan, "x"),
            "force_tolerance": (1e-18, 1.0),
        }.items()
        for value in values
    ),
]
SOFT = DOLERITE._replace(youngs_modulus=78, compressive_strength=165)
REFUSED = [
    ({"effects": jc.Effects(substrate=False)}, "substrate = False needs interaction = False"),
    ({"effects": {"gouge": False}}, "must be an Effects"),
    ({"seating_stress": 9e6}, "seating_stress"),
    ({"seating_stress": 0.5}, "seating_stress = 0.5 Pa: not usual"),
    ({"rock": jc.Rock(55.0, 0.2, 165e6)}, "youngs_modulus = 55.0 Pa: not usual"),
    ({"rock": DOLERITE._replace(youngs_modulus=-1.0)}, "youngs_modulus = -1.0"),
    ({"rock": DOLERITE._replace(poisson_ratio="a")}, "poisson_ratio = 'a': must be a number"),
    ({"spacing": 0.25}, "spacing = 0.25 m: not usual"),
    ({"spacing": "x"}, "spacing = 'x'"),
    ({"cycles": True}, "cycles = True"),
    ({"max_normal_stress": [5e6, 1e6, 6e6], "cycles": 3}, "cycles = 3"),
    ({"max_normal_stress": 1e6, "rock": SOFT, "unusual_values": True}, "must be below the rock's"),
    *(
        ({"max_normal_stress": load}, printed)
        for load, printed in (
            (5, "is 5 MPa meant, 5e+06 Pa?"),
            (5e12, "is 5e+06 Pa meant?"),
            ([5e6, 0.0, 8], "max_normal_stress = 8 Pa: not usual"),
            ([], "needs a maximum"),
            ([5e6, 6e6], "minimum 6 MPa must be"),
            ([5e6, -1e6], "minimum -1 MPa must be"),
            ([0.0, 0.0], "must be positive and finite"),
            (True, "must be a number"),
        )
    ),
    ({"numerics": jc.Numerics(displacement_step=12.5)}, "displacement_step = 12.5 m: not"),
    ({"choices": jc.Choices(largest_radius=20.0)}, "largest_radius = 20.0 m: not usual"),
    *(
        ({type(settings).__name__.lower(): settings._replace(**change)}, named)
        for settings, change, named in SETTINGS
    ),
]
OTHERWISE = {"close": {"spacing"}, "fit": {"max_normal_stress", "cycles"}}
"""Conditions that a function reads of its scans, or of its curve."""


def fitted(*walls, curve, max_normal_stress, seating_stress, **given):
    seating = seating_stress or 0.2e6
    return jc.fit(curve, jrc=8.0, shape=(8, 8), seating_stress=seating, **given)


@pytest.mark.parametrize("door", [*CLOSE, "fit"])
def test_conditions_that_cannot_be_are_refused_before_a_joint_is_closed(
    door, tmp_path, monkeypatch
):
    monkeypatch.setattr("jointclosure.joint.cycling.run_cycles", None)
    curve, walls = tmp_path / "lab.csv", pair(24 if door == "close" else 6)
    curve.write_text(GOOD)
    doors = CLOSE | {"fit": functools.partial(fitted, curve=curve)}
    usual = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "seating_stress": 0.0}
    for change, printed in REFUSED:
        if OTHERWISE.get(door, set()) & change.keys():
            continue
        with pytest.raises(jc.InputError) as refused:
            doors[door](*walls, **usual | change)
        assert printed in str(refused.value), change
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("settings", "change", "named"), SETTINGS)
def test_settings_are_refused_when_they_are_made(settings, change, named):
    if "largest_radius" not in change:  # whose bound is the spacing
        with pytest.raises(jc.InputError, match=re.escape(named)):
            type(settings)(**settings._asdict() | change)


def test_what_is_no_effects_is_refused_at_a_closure_too():
    with pytest.raises(jc.InputError, match="effects = 3: must be an Effects"):
        jc.equilibrium(*pair(6), spacing=SPACING, rock=DOLERITE, closure=1e-6, effects=3)


LIMITS = {
    # last value that is refused, first and last one that are taken, first one that is refused
    "base_radius_in_cells": (0.0, 1e-9, 1.0, 1.0 + 1e-9),
    "peak_modulus_ratio": (0.0, 1e-9, 1.0, 1.0 + 1e-9),
    "crushed_strength_ratio": (0.0, 1e-9, 1.0, 1.0 + 1e-9),
    "tie_tolerance": (0.0, 1e-30, 0.000999, 0.001),
    "stress_tolerance": (0.99e-14, 1e-14, 0.999, 1.0),
    "force_tolerance": (0.99e-14, 1e-14, 0.999, 1.0),
    "sweep_tolerance": (0.99e-14, 1e-14, 0.999, 1.0),
    "curve_points": (0, 1, 100_000, 100_001),
    "tolerance": (0.0, 1e-9, 0.1, 0.1001),
    "most_steps": (0.99, 1.0, np.inf, np.nan),
    "most_breakage_steps": (0.99, 1.0, np.inf, np.nan),
    "idle_interaction": (-1e-9, 0.0, 0.999, 1.0),
    "breakage_step": (0.0, 1e-15, 12.4e-6, 12.5e-6),
    "later_breakage_step": (0.0, 1e-15, 6.2e-6, 6.25e-6),
    "displacement_step": (5e-6, 5.1e-6, 1e3, np.inf),
    "later_displacement_step": (2.5e-6, 2.6e-6, 1e3, np.inf),
    "largest_radius": (0.0, 1e-15, 1e15, 1.01e15),
    "poisson_ratio": (-1e-9, 0.0, 0.5, 0.5 + 1e-9),
    "youngs_modulus": (0.0, 1e-9, 1e30, np.inf),
    "compressive_strength": (0.0, 1e-9, np.inf, np.nan),
}


@pytest.mark.parametrize("name", LIMITS)
def test_settings_are_taken_no_further_than_their_limits(name):
    (settings,) = (one for one in (NUMERICS, CHOICES, DOLERITE) if name in one._fields)
    below, first, last, above = LIMITS[name]
    for value in (first, last):
        assert getattr(type(settings)(**settings._asdict() | {name: value}), name) == value
    for value in (below, above):
        with pytest.raises(jc.InputError, match=name):
            type(settings)(**settings._asdict() | {name: value})


USUAL_ENDS = {
    "youngs_modulus": (1e8, 3e11),
    "compressive_strength": (2.5e5, 1e9),
    "max_normal_stress": (1e3, 1e9),
    "seating_stress": (10.0, 1e9),
    "snapshots": (1e3, 1e9),
    "spacing": (1e-6, 0.1),
    "side_of_scan": (5e-3, 10.0),
    "displacement_step": (1e-9, 1e-3),
    "later_displacement_step": (1e-9, 1e-3),
    "breakage_step": (1e-10, 1e-3),
    "later_breakage_step": (1e-10, 1e-3),
    "largest_radius": (1e-6, 1.0),
    "roll_off": (1e-5, 0.5),
    "mismatch_wavelength": (1e-5, 0.5),
}


def test_usual_ends_are_those_of_all_usual_values():
    assert USUAL_ENDS.keys() == USUAL.keys()


@pytest.mark.parametrize("name", USUAL_ENDS)
def test_values_a_unit_away_from_usual_ones_are_refused(name):
    low, high = USUAL_ENDS[name]
    for value in (low, high):
        check_usual((), **{name: value})
    for value in (0.99 * low, 1.01 * high):
        with pytest.raises(jc.InputError, match=f"{name} = .*not usual"):
            check_usual((), **{name: value})


@pytest.mark.parametrize("name", USUAL_ENDS)
@pytest.mark.parametrize("value", [0.0, np.inf, None])
def test_zero_or_infinity_is_not_refused_as_a_slip_of_units(name, value):
    check_usual((), **{name: value})


def test_seating_is_at_most_nine_tenths_of_the_smallest_maximum():
    load = {"max_normal_stress": (10e6, 0.0, 2e6), "rock": DOLERITE, "spacing": SPACING}
    for seating in (0.0, 1.8e6):
        checked = jc.Conditions(**load, seating_stress=seating).checked()
        assert checked.seating_stress == seating
    for seating in (-1.0, 1.81e6, np.nan):
        with pytest.raises(jc.InputError, match="seating_stress"):
            jc.Conditions(**load, seating_stress=seating).checked()


def test_an_asperity_is_no_flatter_than_a_cell_is_wide():
    check_radius(CHOICES._replace(largest_radius=SPACING), SPACING)
    with pytest.raises(jc.InputError, match="must be at least the grid spacing"):
        check_radius(CHOICES._replace(largest_radius=0.99 * SPACING), SPACING)


@pytest.mark.parametrize(("name", "switch"), [("replay", NUMERICS), ("gouge", jc.Effects())])
@pytest.mark.parametrize("value", [1, None, "yes"])
def test_a_switch_is_no_number(name, switch, value):
    with pytest.raises(jc.InputError, match=f"{name} = .*must be True or False"):
        jc.Conditions(
            SPACING, DOLERITE, 1e6,
            **{type(switch).__name__.lower(): switch._replace(**{name: value})},
        ).checked()  # fmt: skip


def test_conditions_keep_their_numerics_where_scans_resolve_breakage_by_default():
    stated = {"rock": "granite", "max_normal_stress": 1e6}
    given = jc.Conditions(None, **stated)
    fine = RESOLVED._replace(tolerance=0.01)
    cases = [
        (None, stated, RESOLVED), (None, stated | {"numerics": fine}, fine),
        (given, {}, jc.Numerics()), (given, {"numerics": fine}, fine),
    ]  # fmt: skip
    for conditions, changes, numerics in cases:
        made = conditions_from(conditions, changes, "close", defaults=SCAN_DEFAULTS)
        assert made.numerics == numerics


@pytest.mark.parametrize("door", CLOSE)
def test_what_a_user_states_is_checked_and_parsed_once_in_a_call(door, monkeypatch):
    checks = [
        (parameters, "check_scene"), (parameters, "check_choices"), (parameters, "check_numerics"),
        (load, "parsed_load"),
    ]  # fmt: skip
    stated = {"rock": DOLERITE, "max_normal_stress": [3e6, 1e6, 2e6], "spacing": SPACING}
    CLOSE[door](*pair(24), **stated)  # prepares the kernels, by a joint with conditions of its own
    counted = [Mock(wraps=getattr(module, name)) for module, name in checks]
    for (module, name), count in zip(checks, counted, strict=True):
        monkeypatch.setattr(module, name, count)
    CLOSE[door](*pair(24), **stated)
    assert [count.call_count for count in counted] == [1, 1, 1, 1]
