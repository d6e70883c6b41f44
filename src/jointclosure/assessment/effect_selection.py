"""Selection of the effects that a scene needs, which loses little time if all matter.

1. A pair of walls is simulated with all effects. It shows which effects need no test
   (`Pilot.screened`).
2. Its final walls, where nothing breaks (frozen walls), are simulated with and without interaction.
   The change is the prior mean, with the scatter of `PRIORS`. Other effects have no prior.
3. Pairs simulated with and without an effect update the change (normal prior and data), if they
   cost less than a part of what they may save (`PART`), and if no more than `LOSS` is expected to
   be lost should the effect act. One pair confirms the result of frozen walls at any cost.

Effects are left out if, with a probability of `ENOUGH`, this changes the mean of no `JUDGED`
closure by more than the tolerance. The other quantities are reported.
"""

import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Unpack

import numpy as np
import pandas as pd
import scipy

from jointclosure.assessment.assess import DROPS, checked_pairs
from jointclosure.assessment.assessed_results import ASSESSED, CLOSURE, JUDGED
from jointclosure.assessment.effect_names import without
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.ensembles.simulation import read_joint, simulated_joint
from jointclosure.inputs import check_below, check_count
from jointclosure.joint.checked_conditions import CheckedConditions, on_grid
from jointclosure.joint.conditions import (
    Changes,
    Conditions,
    conditions_from,
    takes_conditions,
)
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.wall_checks import warn_of_doubts
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.parameters import AUTO_TOLERANCE, Effects
from jointclosure.statistics.number_texts import percent
from jointclosure.walls import Walls

PRIORS = {
    "max_closure": (0.0, 0.094, 0.08),
    CLOSURE: (0.021, 0.35, 0.0),
    "stiffness_net": (0.028, 0.46, 0.0),
    "mean_aperture_at_max": (0.0, 0.21, 0.0),
}
"""Standard deviation of the true change about that on frozen walls [1], the root of the sum of
three squares: of a number; of a share of the largest change of a closure; and of a number over the
root of the number of broken cells, because few contacts break by chance. The values are the most
likely ones at random conditions other than those of `benchmarks/effects_auto.py`."""
SCATTER = 0.1
"""Standard deviation of the change in a joint [1] that is expected before joints show it."""
WEIGHT = 2.0
"""Number of joints that this expectation counts for."""
ENOUGH = 0.6  # probability of changes within the tolerance from which effects are left out
LIMIT = 2.5  # limit of a change, in deviations; its tails are longer than normal
PART = 0.1
"""Part that a pair may cost of the time that may be saved, which is weighted by the probability of
the less likely decision."""
LOSS = 0.02  # largest share of the time of all joints that tests may lose if all effects act
SAVED = {"breakage": 0.9, "interaction": 0.5}
"""Share of time that is expected to be saved, before a joint was simulated without the effect. Soft
peaks are always kept: without them most joints take as long or longer, as more cells break."""
LONGER = 4.0
"""Breakage steps after which a joint without an effect is given up, over those with all effects:
without interaction a mated joint took 16 times as long."""
WORTH = 0.1  # least share of time that leaving out effects must save
FEWEST_PAIRS = {"breakage": 10, "interaction": 1}
"""Fewest pairs without an effect. Frozen walls do not show breakage, and where few asperities carry
the load, only few joints break, but these break much. Frozen walls show the effect of interaction,
but not its cost."""
MOST_PAIRS = 20  # pairs of walls that are simulated at most
_POINTS = 4  # of elastic curves
_ROWS = [list(ASSESSED).index(name) for name in JUDGED]
# stiffnesses are read as their inverse, because their mean over joints is harmonic
_READ = ["compliance_net" if name == "stiffness_net" else name for name in ASSESSED]


def scene_without(scene: Effects, names: tuple[str, ...]) -> Effects | None:
    """Return a scene without some effects; None if this saves no time."""
    if names[0] not in SAVED or not getattr(scene, names[0]):
        return None
    return scene._replace(**dict.fromkeys(names, False))


def possible_scenes(effects: Effects, chosen: bool = True) -> list[Effects]:
    """Return the scenes that may be ``chosen`` from these effects, with all of them first."""
    scenes = [effects]
    for scene in scenes if chosen else ():
        fewer = [scene_without(scene, names) for names in DROPS]
        scenes += [one for one in fewer if one is not None and one not in scenes]
    return scenes


class Change(NamedTuple):
    """Relative change of mean results `ASSESSED` (quantity, cycle) [1], and its deviation."""

    mean: np.ndarray
    deviation: np.ndarray

    def updated(self, changes: np.ndarray) -> "Change":
        """Return the change updated by ``changes`` of pairs of joints (pair, quantity, cycle).

        NaN are left out.
        """
        count = np.isfinite(changes).sum(axis=0)
        mean = np.nan_to_num(_mean(changes))
        squares = WEIGHT * SCATTER**2 + np.nansum((changes - mean) ** 2, axis=0)
        new = count * (WEIGHT + count - 1) / squares
        old = self.deviation**-2.0
        with np.errstate(divide="ignore", invalid="ignore"):
            posterior = (new * mean + old * np.nan_to_num(self.mean)) / (new + old)
            return Change(posterior, (new + old) ** -0.5)

    def within(self, tolerance: float) -> float:
        """Return the least probability of a judged closure to change by at most a tolerance."""
        of = scipy.stats.norm(self.mean[_ROWS], self.deviation[_ROWS])
        return float(np.nanmin(of.cdf(tolerance) - of.cdf(-tolerance)))

    @property
    def most(self) -> np.ndarray:
        """Limits (quantity, cycle) of the sizes of the changes."""
        return np.abs(self.mean) + LIMIT * self.deviation

    def largest(self) -> tuple[str, float, float]:
        """Return the judged result with the largest limit: its name, its size, and this limit."""
        most = np.where(np.isfinite(self.mean), self.most, -np.inf)[_ROWS]
        row, cycle = np.unravel_index(np.argmax(most), most.shape)
        name = f"{ASSESSED[JUDGED[row]]} of cycle {cycle + 1}"
        return name, float(np.abs(self.mean[_ROWS][row, cycle])), float(most[row, cycle])


class Pilot:
    """Pairs of walls simulated at most once with each set of effects, before ``joints`` are."""

    longer = LONGER

    def __init__(self, pairs: Sequence[Walls], conditions: CheckedConditions, joints: int):
        self.conditions = conditions
        self.effects = conditions.effects
        self.joints = joints
        self.closed: dict[Effects, list[SimulatedJoint]] = {}
        self.frozen_seconds = 0.0
        self._pairs = pairs

    def values(self, effects: Effects, count: int) -> np.ndarray:
        """Simulate the first ``count`` pairs, or all; return values (pair, quantity, cycle)."""
        closed = self.closed.setdefault(effects, [])
        for pair in self._pairs[len(closed) : count]:
            closed.append(self.close(pair, effects))
        return np.array([self.read(joint) for joint in closed[:count]])

    def read(self, joint: SimulatedJoint) -> np.ndarray:
        """Read `_READ` (quantity, cycle) of a joint, NaN if it failed."""
        row = read_joint(joint, _READ)
        failed = np.full(self.conditions.cycle_count, np.nan)
        return np.array([row.get(name, failed) for name in _READ])

    def close(self, walls: Walls, effects: Effects, **changes: Any) -> SimulatedJoint:
        """Simulate a pair of walls with some effects, as the next one of `values`.

        It is given up after `longer` times the breakage steps of this pair with all effects.
        """
        stated = self.conditions._replace(effects=effects, **changes)
        if full := self.closed.get(self.effects, [])[len(self.closed.get(effects, [])) :]:
            steps = self.longer * float(full[0].closed.breakage_steps) / walls[0].size
            most = max(1.0, min(steps, stated.numerics.most_breakage_steps))
            stated = stated._replace(numerics=stated.numerics._replace(most_breakage_steps=most))
        prepare_kernels([stated.model])  # no part of the time of the first joint
        return simulated_joint(walls, stated)

    def predicted(self, fewer: Effects) -> Change:
        """Return the change without interaction, on the final walls of the first joint."""
        first = self.closed[self.effects][0]
        scenes = [scene._replace(breakage=False, gouge=False) for scene in (self.effects, fewer)]
        few = {"flow": False, "numerics": self.conditions.numerics._replace(curve_points=_POINTS)}
        frozen = [self.close(first.final, scene, **few) for scene in scenes]
        self.frozen_seconds += sum(joint.seconds for joint in frozen)
        with_it, without_it = map(self.read, frozen)
        mean = (without_it - with_it) / self.read(first)
        parts = np.array([PRIORS[name] for name in ASSESSED])
        parts *= [1.0, np.nanmax(np.abs(mean[_ROWS])), 1.0 / np.sqrt(max(1, self.broken()))]
        deviation = np.linalg.norm(parts, axis=1)[:, None]
        return Change(mean, np.where(np.isfinite(mean), deviation, np.inf))

    def broken(self) -> int:
        """Return the number of broken cells of both walls of the first joint."""
        first = self.closed[self.effects][0]
        share = read_joint(first, ["broken_share"])["broken_share"]
        return round(2 * first.walls[0].size * share)

    def changes(self, effects: Effects, count: int) -> np.ndarray:
        """Return changes of the first pairs (pair, quantity, cycle) from all effects [1]."""
        full = self.values(self.effects, count)
        fewer = self.values(effects, len(full))
        return (fewer - full) / _mean(full)

    def seconds(self, effects: Effects) -> float:
        """Return the mean time [s] of a joint with some effects."""
        return float(np.mean([joint.seconds for joint in self.closed[effects]]))

    def lost(self, selected: Effects) -> float:
        """Return the time [s] of all simulations but those with the selected effects."""
        others = (joints for effects, joints in self.closed.items() if effects != selected)
        return self.frozen_seconds + sum(joint.seconds for joints in others for joint in joints)

    def screened(self, names: tuple[str, ...], tolerance: float) -> str:
        """Return why the first joint shows that effects are kept without a test; "" if not."""
        net = self.values(self.effects, 1)[0, list(ASSESSED).index(CLOSURE)]
        if not np.isfinite(net).any():
            return "cannot be computed"
        # whatever the one closure of an elastic joint is, it is off by as much in some cycle
        least = np.ptp(net) / (net.max() + net.min())
        alike = len(set(self.conditions.load.load_cycles)) == 1
        if "breakage" in names and alike and least > tolerance:
            words = "or more (net closure), as all cycles would be alike"
            return f"of a cycle changes by {percent(least)} {words}"
        return ""

    def test(
        self, names: tuple[str, ...], before: Effects, tolerance: float
    ) -> tuple[bool, Change, str]:
        """Test whether effects can be left out of the scene ``before`` within a tolerance [1].

        Return whether they can, the change of mean closures without them, and the reason in words.
        """
        fewer = before._replace(**dict.fromkeys(names, False))
        full = self.effects
        first = self.values(full, 1)[0]
        bound = LOSS * self.joints * self.seconds(full)
        frozen = "interaction" in names and full.breakage and before == full
        unknown = Change(np.zeros(first.shape), np.full(first.shape, np.inf))
        prior = change = self.predicted(fewer) if frozen else unknown
        pairs = 0
        required = FEWEST_PAIRS[names[0]]
        saved = SAVED[names[0]]
        while True:
            inside = change.within(tolerance) if frozen or pairs else 0.5
            gain = saved * self.joints * min(inside, 1.0 - inside)  # in joints with all effects
            cost = 1.0 - saved + (len(self.closed[full]) <= pairs)
            lacking = pairs < required and inside >= ENOUGH
            further = max(required - pairs, 1) * (1.0 - saved) * self.seconds(full)
            dear = self.lost(full) + further > bound and not (frozen and lacking)
            if dear or not (lacking or cost <= PART * gain):
                break
            changes = self.changes(fewer, pairs + 1)
            if len(changes) == pairs:
                break
            pairs += 1
            if np.isnan(changes[-1][_ROWS])[np.isfinite(first[_ROWS])].any():
                return False, change, "fails, or takes too many breakage steps"
            saved = 1.0 - self.seconds(fewer) / self.seconds(before)
            change = prior.updated(changes)
        if not (frozen or pairs):
            return False, change, "is not tested, as this costs more than it may save"
        basis = ["frozen walls"] * frozen
        basis += [f"pairs: {pairs}", f"{percent(saved)} less time"] * (pairs > 0)
        result, mean, most = change.largest()
        reason = (
            f"changes by {percent(mean)}, at most {percent(most)} ({result}; {', '.join(basis)})"
        )
        return inside >= ENOUGH and pairs >= required and saved >= WORTH, change, reason


def _mean(values: np.ndarray) -> np.ndarray:
    """Return the mean along the first axis, without NaN."""
    with np.errstate(invalid="ignore"):
        return np.nansum(values, axis=0) / np.isfinite(values).sum(axis=0)


def _largest(values: np.ndarray) -> float:
    """Return the largest size of judged values of (quantity, cycle)."""
    return float(np.nanmax(np.abs(values[_ROWS])))


class Selection(NamedTuple):
    """Effects selected for a scene, and what is known of the changes by leaving others out.

    ``error`` is the limit of the relative change of the mean of a `JUDGED` closure, the largest of
    all cycles; 0 if all effects act. ``changes`` has a row per quantity of `ASSESSED` and cycle:
    the ``change`` (of the net stiffness: of its inverse) and its limit ``at_most`` [1]. ``reasons``
    has a sentence for every group of effects that was tried. ``closed`` contains the first pairs of
    walls, simulated with the selected effects. ``lost_seconds`` is the time of all other
    simulations.
    """

    effects: Effects
    error: float
    changes: pd.DataFrame
    reasons: tuple[str, ...]
    closed: tuple[SimulatedJoint, ...]
    lost_seconds: float

    def __str__(self) -> str:
        return "\n".join(self.reasons)


@takes_conditions
def choose_effects(
    walls: Any,
    *,
    conditions: Conditions | CheckedConditions | None = None,
    tolerance: float = AUTO_TOLERANCE,
    joints: int = 20,
    report: Callable[[str], None] = lambda line: None,
    **changes: Unpack[Changes],
) -> Selection:
    """Select the effects that a joint needs, for a tolerance of its mean closure.

    How effects are selected, and how well, is described in docs/effects.md.

    Parameters
    ----------
    walls : (upper, lower), or iterable of such pairs
        As for `jointclosure.assess`. Only as many pairs as necessary are simulated.
    conditions, **changes
        As for `jointclosure.simulate`. ``effects`` are the effects from which is selected, and
        with which others are compared.
    tolerance : float
        Relative change of the mean closure of a cycle, gross or net since seating, in (0, 1), below
        which an effect does not matter.
    joints : int
        Number of joints that will be simulated with the selected effects, at least 1. The
        selection may take more time for more joints.
    report : callable
        Receives a line for each decision.

    Returns
    -------
    Selection

    Raises
    ------
    InputError
        If the tolerance or the number of joints is out of range, there are no walls, or
        `jointclosure.simulate` refuses an argument.
    """
    given = checked_as_stated(conditions_from(conditions, changes, "choose_effects"), varied=True)
    check_below("tolerance", tolerance, 1.0)
    check_count("joints", joints, 1, 100_000)
    pairs, spacing = checked_pairs(list(itertools.islice(walls, MOST_PAIRS)), given)
    if not given.unusual_values:
        for upper, lower in pairs:
            warn_of_doubts(upper, lower, spacing)
    return choose_among(Pilot(pairs, on_grid(given, spacing), joints), tolerance, report)


def choose_among(
    pilot: Pilot, tolerance: float, report: Callable[[str], None] = lambda line: None
) -> Selection:
    """Select, as `choose_effects`, among the effects of a pilot."""
    chosen = pilot.effects
    reasons = []
    shape = pilot.values(chosen, 1)[0].shape
    change = Change(np.zeros(shape), np.zeros(shape))
    for names in DROPS:
        fewer = scene_without(chosen, names)
        if fewer is None:
            continue
        left_out = False
        reason = pilot.screened(names, tolerance)
        if not reason:
            left_out, tested, reason = pilot.test(names, chosen, tolerance)
            chosen, change = (fewer, tested) if left_out else (chosen, change)
        verdict = "left out" if left_out else "kept"
        verdict += f" (tolerance {percent(tolerance)})"
        reasons.append(f"{without(names)} the mean closure {reason}: {verdict}")
        report(reasons[-1])
    if chosen == pilot.effects:
        report("all effects act")
    index = pd.MultiIndex.from_product([ASSESSED, range(1, shape[1] + 1)])
    table = index.to_frame(index=False, name=["quantity", "cycle"])
    table = table.assign(change=change.mean.ravel(), at_most=change.most.ravel())
    pilot.values(chosen, 1)  # one realisation at least, whose time is known
    closed = tuple(pilot.closed[chosen])
    lost = pilot.lost(chosen)
    return Selection(chosen, _largest(change.most), table, (*reasons,), closed, lost)
