"""Breakage, part by part; what must hold at rest is judged in the hard cases."""

import itertools
from typing import NamedTuple

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from jointclosure import oracle
from jointclosure.mechanics.contact_law import ContactLaw, contact_law
from jointclosure.mechanics.strength import is_overstressed
from jointclosure.parameters import Choices, Effects, Numerics
from jointclosure.solvers import pair_batch as pb
from jointclosure.solvers.breakage import (
    breakage_kernel,
    colour_map,
    colours_beside,
    find_peaks,
    let_due_wait,
    new_turns,
    no_cells_due,
    padded,
    padded_cells,
    set_due,
    strength_limits,
    work_space,
)
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import influence_of, influence_table
from jointclosure.solvers.joint import Joint, Outcome
from jointclosure.solvers.registry import solver_named
from tests.joints import DOLERITE, SPACING, closed, pair


def settled(walls):
    """A joint without interaction that settled at several closures by resolved breakage."""
    numerics = Numerics(
        breakage="resolved", tolerance=0.02, force_tolerance=1e-8, sweep_tolerance=1e-8
    )
    given = (DOLERITE, DOLERITE), Effects(interaction=False), Choices(), numerics
    joint, broken = Joint(*walls, SPACING, *given), 0
    for closure in np.arange(1, 9) * 12.5e-6:
        outcome = solver_named("fast").settle(joint, float(closure), 5e-6)
        assert outcome.outcome == Outcome.CONVERGED
        broken += outcome.effort.breakage_steps
    return joint, broken


@pytest.mark.parametrize("seed", [0, 2, 7])
def test_resolved_breakage_does_not_depend_on_the_direction_of_a_loop(seed):
    """Until rounding has grown, which it does by ten at every few hundred breakage steps."""
    walls = pair(24, seed)
    one, broken = settled(walls)
    assert broken > 100
    for changed in (np.fliplr, np.flipud, np.transpose):
        copy = tuple(np.ascontiguousarray(changed(wall)) for wall in walls)
        other, _ = settled(copy)
        np.testing.assert_allclose(other.upper, changed(one.upper), rtol=0.0, atol=5e-15)
        np.testing.assert_allclose(other.lower, changed(one.lower), rtol=0.0, atol=5e-15)


@pytest.mark.parametrize("seed", range(3))
def test_cells_wait_at_the_moment_they_were_last_due_at(seed):
    """Against a dictionary, in its order; so often that old entries have to be removed."""
    grid = padded(np.ones((20, 20)), 0.0)
    cells = np.flatnonzero(grid)
    short_steps = 4
    rng = np.random.default_rng(seed)
    due = no_cells_due(grid.size, short_steps)
    expected: dict[int, int] = {}
    waited = 0
    for moment in range(1, short_steps):
        for cell in rng.choice(cells, 6000).tolist():
            following = int(rng.integers(moment, short_steps + 1))
            set_due(due, cell, following)
            if following != expected.get(cell):
                expected.pop(cell, None)  # so that it becomes the last one
                if following < short_steps:
                    expected[cell] = following
        turns = new_turns(20, 20, 1)
        let_due_wait(due, moment, turns)
        now = [cell for cell in reversed(expected) if expected[cell] == moment]
        assert turns.lists[0, : turns.counts[0]].tolist() == now
        assert all(turns.waits[now] == 1)
        expected = {cell: at for cell, at in expected.items() if at != moment}
        waited += len(now)
    assert waited > 0


STEP = 150e-6
"""Step of closure [m] that ends 0.2 mm after first touch."""


def broken(joint, growth, short_steps, before=0.0):
    """Break pairs along a step in which the approach grows (y, x) [m], or at a share ``before`` its
    end; return the number of breakage steps."""
    kernel, closure = breakage_kernel(True, False, True, True), 0.2e-3
    return kernel(
        joint.upper, joint.lower, closure - joint.first_touch, before * growth, joint.peaks,
        joint.law, 5e-6, 0.04, joint.tie_tolerance, 10**9, work_space(joint.upper.shape, True),
        growth, short_steps,
    )[0]  # fmt: skip


def unbroken(seed):
    """A joint of dolerite whose approach grows unevenly in a step, and the growth (y, x) [m]."""
    walls = pair(32, seed)
    joint = Joint(*walls, SPACING, (DOLERITE, DOLERITE), Effects(), Choices(), Numerics())
    return joint, STEP * np.random.default_rng(seed).uniform(0.5, 1.0, walls[0].shape)


@pytest.mark.parametrize("seed", [0, 2, 7])
def test_cells_are_examined_in_time_along_a_step(seed):
    """Examining every cell before the last short step finds next to nothing that should break."""
    joint, growth = unbroken(seed)
    steps = broken(joint, growth, 16)
    assert steps > 200
    assert broken(joint, growth, 1, before=1.0 / 16.0) <= 0.001 * steps


def test_a_pair_that_is_known_to_hold_holds():
    """Whatever was broken or put back before, a new work space finds nothing more to break."""
    joint, growth = unbroken(4)
    kernel = breakage_kernel(True, False, False, True)
    space, before = work_space(joint.upper.shape, False), joint.snapshot()

    def breaks(closure, space):
        return kernel(
            joint.upper, joint.lower, closure - joint.first_touch, 0.0 * growth, joint.peaks,
            joint.law, 5e-6, 0.0, joint.tie_tolerance, 10**9, space, growth[:0], 1,
        )[0]  # fmt: skip

    for closure in (60e-6, 80e-6, 200e-6, 190e-6, 60e-6, 230e-6):
        if closure == 60e-6:
            joint.restore(before)
        broken = breaks(closure, space)
        assert broken > 0 or closure == 190e-6
        assert breaks(closure, work_space(joint.upper.shape, False)) == 0


def test_peaks_of_a_batch_are_those_of_the_map_of_peaks(small_joint):
    """Of which wall a peak is matters where the two walls are of different rock."""
    expected = peak_map(*small_joint)
    assert {0, 1, 2} <= set(expected.ravel())
    cells = padded_cells(*small_joint, np.zeros(expected.shape), expected)
    inside = np.flatnonzero(np.isfinite(cells.upper))
    memory, found = pb.batch_memory(), np.full_like(cells.kind, -1)
    for some in np.array_split(inside, -(-inside.size // pb.BATCH)):
        walls = cells.upper, cells.lower, cells.approach
        pb.gather(memory[0], some.size, some, *walls, cells.approach, 0.0, cells.stride, True)
        find_peaks(memory[0], some.size, some, found)
    np.testing.assert_array_equal(found[inside], cells.kind[inside])


def test_nothing_overlaps_at_last_touch_whatever_was_broken():
    """A difference of heights, of which a rounding must not leave an overlap."""
    random, left = np.random.default_rng(1), []
    for _ in range(300):
        walls = 1e-3 * random.normal(size=(2, 4, 4))
        joint = Joint(*walls, SPACING, (DOLERITE, DOLERITE), Effects(), Choices(), Numerics())
        joint.upper -= random.uniform(0.0, 3e-3, (4, 4))
        left.append(joint.overlapping(joint.last_touch)[0].size)
        highest = (joint.upper + joint.lower).max()
        assert joint.last_touch == pytest.approx(walls.sum(axis=0).max() - highest, rel=1e-14)
    assert sum(left) == 0


def test_solvers_agree_in_the_mean_within_the_spread_of_the_order_of_breakage():
    """Equal in the mean over surfaces: see docs/decisions.md#0006-order-of-breakage."""
    fast, reference = (
        np.array([closed(pair(16, seed), 3e6, solver=name).max_closure for seed in range(12)])
        for name in ("fast", "reference")
    )
    difference = (fast - reference).mean(axis=0)
    error = (fast - reference).std(axis=0, ddof=1) / np.sqrt(len(fast))
    # three standard errors of the paired difference
    assert np.all(np.abs(difference) <= 3.0 * error + 1e-9)
    assert np.all(np.abs(difference) <= 0.1 * reference.mean(axis=0))


LAW = contact_law(SPACING, (DOLERITE, DOLERITE), Effects(), Choices())
heights = st.floats(-2e-4, 0.0)


@hypothesis.settings(max_examples=25)
@hypothesis.given(
    st.lists(heights, min_size=16, max_size=16),
    st.floats(1e-8, 1e-4),
    st.sampled_from([0.02, 0.1, 0.4]),
    st.booleans(),
    st.sampled_from([0.0, 1e2, 1e4]),
)
def test_the_returning_loss_brings_a_pair_back_to_its_strength_or_is_all_there_is(
    around, overlap, band, gouge, filling
):
    memory, tie = pb.batch_memory(), 1e-12
    rules = pb.Rules(tie, 0.0, 1.0, SPACING, gouge, filling > 0.0)
    batch = memory[0]
    heights = batch.heights
    for k in range(9):
        if k != pb.CENTRE:
            heights[pb.UPPER, k, 0] = around[k - (k > pb.CENTRE)]
            heights[pb.LOWER, k, 0] = around[8 + k - (k > pb.CENTRE)]
    batch.approach[0] = overlap
    batch.critical_indentation[0] = LAW.critical_indentation[0]
    batch.substrate_strength[0] = LAW.substrate * LAW.breaking_force[0]
    batch.filling[0] = filling

    def measured():
        pb.assess(batch, 1, 1.0 + 0.5 * band, rules)
        pb.measure_drops(batch, 1, pb.UPPER, tie)
        pb.measure_drops(batch, 1, pb.LOWER, tie)
        ratio, kappa = batch.overlap_ratio[0], batch.curvature[:, 0].sum()
        strength = LAW.critical_indentation[0], LAW.breaking_force[0], LAW.substrate
        overstressed = is_overstressed(batch.overlap[0], kappa, *strength, filling)
        assert overstressed == (ratio > 1.0) or abs(ratio - 1.0) < 1e-9
        return ratio

    hypothesis.assume(1.0 + 0.5 * band < measured() < 1e12)
    pb.share_losses(batch, 1, gouge)
    hypothesis.assume(batch.breaks[0] == 1.0)
    volume = heights[:, :, 0].sum()
    pb.returning_losses(batch, 1, band, rules)
    lost = batch.loss[:, 0].sum()
    most = batch.most[0]
    assert 0.0 < lost <= overlap * (1.0 + 1e-12)
    pb.shed_losses(batch, 1, pb.UPPER, tie, gouge)
    pb.shed_losses(batch, 1, pb.LOWER, tie, gouge)
    if gouge:
        assert abs(heights[:, :, 0].sum() - volume) <= 1e-18
    after = measured()
    assert 1.0 - 0.751 * band <= after <= 1.0 - 0.249 * band or lost >= most * (1.0 - 1e-9)


class LimitedContacts(NamedTuple):
    """Contacts whose forces are limited, beside the same joint as the oracle has it."""

    contacts: Contacts
    state: oracle.State
    joint: oracle.PristineJoint
    locked: np.ndarray
    curvature: np.ndarray
    law: ContactLaw


def limited_contacts(upper, lower, bound):
    """Contacts of walls of which some hold, and some do not; all carry what they can."""
    rock = DOLERITE._replace(compressive_strength=2e9)
    choices = Choices(strength_bound=bound)
    law = contact_law(SPACING, (rock, rock), Effects(), choices)
    peaks = peak_map(upper, lower)
    cells, overlap, curvature, compliance = overlapping_cells(
        upper, lower, 3e-4 - (upper + lower).max(), peaks, law
    )
    walls = upper, lower, cells, curvature, compliance, peaks
    limit = strength_limits(*walls, law, True, 1e-12, 0.0)
    load = np.zeros(upper.size)
    load[cells] = np.where(np.isinf(limit), 0.0, limit)
    return LimitedContacts(
        Contacts(cells, overlap, compliance, limit, law.substrate),
        oracle.State(upper, lower, load.reshape(upper.shape), 3e-4, load.sum()),
        oracle.PristineJoint(upper, lower, SPACING, rock, Effects(), choices),
        oracle.locked(upper, lower).ravel()[cells],
        curvature,
        law,
    )


@pytest.mark.parametrize("bound", ["none", "base"])
def test_a_contact_is_limited_to_the_force_at_its_strength(small_joint, bound):
    made = limited_contacts(*small_joint, bound)
    limit = made.contacts.limit
    np.testing.assert_array_equal(
        np.isinf(limit), made.locked | ((made.curvature == 0.0) & (bound == "none"))
    )
    pressure = oracle.pressures_over_limit(made.joint, made.state).ravel()[made.contacts.cells]
    np.testing.assert_allclose(pressure[np.isfinite(limit)], 1.0, rtol=1e-9)


@pytest.mark.parametrize("bound", ["none", "base"])
def test_limited_forces_are_complementary(small_joint, bound):
    contacts, state, joint, _, _, law = limited_contacts(*small_joint, bound)
    table = influence_table(
        *small_joint[0].shape, law.base_radius, law.substrate_modulus, law.spacing
    )
    found = solve_equilibrium(influence_of(table), contacts, 0.0 * contacts.overlap, np.nan, 1e-11)
    load = state.force.ravel()  # a view: the oracle's state has the forces that were found
    load[contacts.cells] = found.force
    _, left = oracle.overlaps_of(joint, state, oracle.law_of(joint, state))
    own = law.substrate * found.force + contacts.compliance * np.cbrt(found.force) ** 2
    gap = left - own
    at_limit = found.force >= contacts.limit
    assert 0 < at_limit.sum() < at_limit.size
    assert np.all(gap[at_limit] >= -1e-12)  # would carry more, were it stronger
    inside = (found.force > 0.0) & ~at_limit
    np.testing.assert_allclose(gap[inside], 0.0, atol=1e-13)
    assert np.all(gap[found.force == 0.0] <= 1e-13)


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
@pytest.mark.parametrize("height", [5e-324, 1e-310])
def test_walls_whose_heights_differ_by_denormal_numbers_close_as_flat_ones(height, breakage):
    """Their contacts are locked: no share of such a drop is a number with any digits."""
    weak = {"rock": DOLERITE._replace(compressive_strength=3e6), "breakage": breakage}
    weak |= {"seating_stress": 0.0, "cycles": 1, "unusual_values": True}
    heights = height * np.random.default_rng(1).integers(0, 2, (6, 6))
    rough, flat = (
        closed((upper, 0.0 * heights), 2e6, **weak) for upper in (heights, 0.0 * heights)
    )
    assert float(rough.breakage_steps) == 0.0
    np.testing.assert_array_equal(rough.max_closure, flat.max_closure)


def test_the_colours_beside_a_cell_are_those_of_its_neighbours():
    """Otherwise neighbours that break would wait in the list of another colour."""
    colours, beside = colour_map(5, 5, 3), colours_beside(3)
    for y, x in itertools.product(range(1, 4), repeat=2):
        around = colours[y - 1 : y + 2, x - 1 : x + 2].ravel()
        np.testing.assert_array_equal(beside[colours[y, x]], np.delete(around, 4))
