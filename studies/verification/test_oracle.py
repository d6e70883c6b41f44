"""The oracle notices whatever is made wrong in a sound state."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure import oracle
from jointclosure.ensembles.oracle_limits import largest_ratio
from jointclosure.solvers.joint import Joint
from jointclosure.solvers.registry import solver_named
from studies.verification.judged_solver import Judge
from tests.joints import DOLERITE, SPACING

NUMERICS = jc.Numerics(force_tolerance=1e-8)
TOLERANCES = {"residual": 1e-8, "strength": 0.0, "target": 1e-3}


def at_rest(choices):
    """Return the pristine joint, and its state at rest after breakage."""
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)
    effects = jc.Effects()
    joint = Joint(*walls, SPACING, (DOLERITE, DOLERITE), effects, choices, NUMERICS)
    for closure in np.arange(1, 21) * 12.5e-6:
        answer = solver_named("fast").settle(joint, float(closure), 5e-6)
    given = oracle.PristineJoint(*walls, SPACING, DOLERITE, effects, choices)
    state = oracle.State(joint.upper, joint.lower, joint.force, answer.closure, answer.total_force)
    return given, state


@pytest.fixture(scope="module")
def settled():
    return at_rest(jc.Choices())


def complaints(given, state):
    judge = Judge(given, TOLERANCES)
    judge(state)
    return {name for name, limit in judge.limits.items() if not judge.worst[name] <= limit}


def changed(field, index, by):
    field = field.copy()
    field[index] += by
    return field


def test_a_sound_state_passes(settled):
    assert complaints(*settled) == set()


@pytest.fixture(scope="module")
def with_flat_valleys():
    return at_rest(jc.Choices(concave="flat", largest_radius=20e-3))


def test_a_state_with_flat_valleys_is_sound_where_it_is_judged_so(with_flat_valleys):
    given, state = with_flat_valleys
    assert complaints(given, state) == set()
    assert np.abs(state.upper - given.upper).max() > 1e-6  # it broke


def test_a_state_with_flat_valleys_is_not_sound_as_one_of_peaks(with_flat_valleys):
    given, state = with_flat_valleys
    as_peaks = given._replace(choices=jc.Choices(largest_radius=20e-3))
    assert "residual" in complaints(as_peaks, state)


@pytest.mark.parametrize(
    ("cell", "share", "named"),
    [
        ("loaded", 1e-6, {"residual", "load"}),  # a force a millionth too large
        ("apart", 1e-6, {"without_overlap"}),  # a force that was never there
        ("loaded", None, {"without_force"}),  # a contact left out
        ("loaded", "pulls", {"negative_force"}),
    ],
)
def test_a_wrong_force_is_noticed(settled, cell, share, named):
    given, state = settled
    flat = state.force.argmax() if cell == "loaded" else (state.upper + state.lower).argmin()
    at = np.unravel_index(flat, state.force.shape)
    by = {None: -1.0, "pulls": -1.001}.get(share)
    change = share * state.force.sum() if by is None else by * state.force[at]
    force = changed(state.force, at, change)
    assert complaints(given, state._replace(force=force)) >= named


@pytest.mark.parametrize("wall", ["upper", "lower"])
def test_a_volume_that_is_lost_is_noticed(settled, wall):
    given, state = settled
    at = np.unravel_index((state.upper + state.lower).argmin(), state.force.shape)
    volume = np.abs(getattr(given, wall) - getattr(given, wall).min()).sum()
    lower = changed(getattr(state, wall), at, -1e-11 * volume)
    assert complaints(given, state._replace(**{wall: lower})) == {"volume"}


def test_a_wrong_total_is_noticed(settled):
    given, state = settled
    wrong = state._replace(total_force=state.total_force * (1 + 1e-9))
    assert complaints(given, wrong) == {"load"}


def test_a_number_that_is_none_is_noticed(settled):
    given, state = settled
    assert complaints(given, state._replace(force=changed(state.force, (3, 3), np.nan)))


def test_a_peak_that_grew_is_noticed(settled):
    given, state = settled
    at = np.unravel_index(given.upper.argmax(), given.upper.shape)
    grown = changed(state.upper, at, np.ptp(given.upper))
    assert "raised" in complaints(given, state._replace(upper=grown))


WEAKER = DOLERITE._replace(compressive_strength=0.9 * DOLERITE.compressive_strength)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"effects": jc.Effects(interaction=False)}, "residual"),
        ({"effects": jc.Effects(substrate=False, interaction=False)}, "residual"),
        ({"effects": jc.Effects(soft_peaks=False)}, "residual"),
        ({"choices": jc.Choices(base_radius_in_cells=0.51)}, "residual"),
        ({"choices": jc.Choices(peak_modulus_ratio=0.06)}, "residual"),
        ({"spacing": 1.01 * SPACING}, "residual"),
        ({"rock": DOLERITE._replace(youngs_modulus=78.001e9)}, "residual"),
        ({"rock": WEAKER}, "strength"),
        ({"rock": (DOLERITE, WEAKER)}, "strength"),
    ],
    ids=str,
)
def test_a_state_of_another_model_is_noticed(settled, change, named):
    given, state = settled
    assert named in complaints(given._replace(**change), state)


def test_a_number_that_is_only_reported_hides_no_other_beyond_its_limit():
    numbers = {"rounding": np.inf, "load": 1e-12, "raised": 0.0}
    limits = {"rounding": np.inf, "load": 2e-12}
    assert largest_ratio(numbers, limits) == 0.5
    assert largest_ratio(numbers | {"raised": 1e-9}, limits) == np.inf


ZETA = np.arange(1.0, 40.0)


@pytest.fixture(scope="module")
def influence():
    """Influence on cells in a row, by their distance ZETA."""
    return oracle.influence((3, 40), 1.0, 0.5, 1.0)[0, 1:]


def test_influence_agrees_with_the_printed_form(influence):
    r = 0.5
    bracket = (2 * r**2 - ZETA**2) * np.arcsin(r / ZETA) + r * np.sqrt(ZETA**2 - r**2)
    np.testing.assert_allclose(influence, 3 / (4 * np.pi * r**3) * bracket, rtol=1e-9)


def test_influence_agrees_near_as_far_with_the_expansion(influence):
    expanded = (1 + 0.1 * (0.5 / ZETA) ** 2) / (np.pi * ZETA)
    np.testing.assert_allclose(influence, expanded, rtol=3e-3)


def test_strength_is_judged_by_the_force_that_an_overlap_takes(settled):
    """The error of the reported force of one contact counts as residual alone."""
    given, state = settled
    load = np.where(oracle.locked(state.upper, state.lower), 0.0, 1.0)
    load *= oracle.pressures_over_limit(given, state)
    at = np.unravel_index(load.argmax(), load.shape)
    assert 0.9 < load[at] <= 1.0 + 1e-6
    force = changed(state.force, at, 0.5 * state.force[at])
    found = complaints(given, state._replace(force=force, total_force=float(force.sum())))
    assert "residual" in found
    assert "strength" not in found
