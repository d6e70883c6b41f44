"""Load cycling of a joint under displacement control, with any solver of the registry.

A loading takes steps of closure up to its maximum and lands on it (`_land`), an unloading takes
steps down to its minimum. Maxima and minima are forces [N] on the whole joint. With resolved
breakage the length of each step comes from a prediction of the force after it, before anything
breaks (`StepControl.fitting`); then equilibrium and breakage of the step are solved
(`_Run.settle`).
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from jointclosure.joint.load import LoadCycle
from jointclosure.joint.status import (
    BRANCHES,
    FAILURE,
    FLAGS,
    LARGEST_UNBREAKABLE_SHARE,
    LOADING,
    OUTSIDE_MODEL_RANGE,
    TARGET_JUMPED,
    UNLOADING,
    unbreakable_share,
)
from jointclosure.joint.step_control import StepControl, must_repeat
from jointclosure.parameters import Numerics
from jointclosure.solvers.joint import Effort, Joint, Outcome, Settled, Solver

*_FAILURES, _NOT_REACHED, _TOO_MANY_STEPS = (flag for flag in FLAGS if flag >= FAILURE)
FLAG_OF_OUTCOME = dict(zip(list(Outcome)[1:], _FAILURES, strict=True))
Observer = Callable[[Joint, "Step"], None]
"""Called with the joint at every step of the history, in order; must not change the joint."""
StepReport = Callable[[int, str, float], None]
"""Called at every accepted step with its cycle, branch, and force over the maximum of its cycle."""

_SMALLEST_STEP = 1e-6
"""Step over the configured one, below which a target counts as jumped over. Of a loading whose
closure is less than the configured step, it is over this closure."""
_FEWEST_CONTACTS = 1000
"""Number of cells that carry the largest force at a pressure equal to the compressive strength,
from which the interaction may be left out at first. With 300 to 600 such cells means of second
cycles moved by up to 12 %."""
_MOST_CRUSHED = 0.4
"""Largest share of the grid that these cells may make up if the interaction is left out: above it
breakage takes nearly all of the time."""
_MOST_SECANTS = 2
"""Trials above the target in a row that are followed by a secant through the last two of them."""
_MOST_BELOW = 3
"""Trials below the target in a row after which the force at the closure above it is computed anew.
A longer step from an earlier state may have broken other contacts, and left a higher force."""


class Step(NamedTuple):
    """Accepted state of a joint in its history, with its cycle and branch.

    ``mean_height`` [m] is the mean of the sum of both walls' heights, which falls only if material
    vanishes.
    """

    cycle: int
    branch: str
    settled: Settled
    mean_height: float


class StepRecord(NamedTuple):
    """History of a joint: all accepted steps in order, status bits (`STATUSES`), and total effort.

    ``replayed`` is the number of cycles that were not simulated, but repeat the steps of the cycle
    before. ``idle_steps`` is the number of accepted steps that were settled without interaction. In
    none of them would the interaction have displaced a contact by more than ``idle_displacement``
    times the closure.
    """

    steps: list[Step]
    status: int
    effort: Effort
    replayed: int = 0
    idle_steps: int = 0
    idle_displacement: float = 0.0


class _Run:
    """State of `run_cycles` between its steps: the joint, its record so far, and the target.

    Its methods change the joint and this state in place.
    """

    def __init__(self, joint, solver, cycles, seating_force, report, observers):
        self.joint: Joint = joint
        self.solver: Solver = solver
        self.numerics: Numerics = joint.numerics
        self.seating_force = seating_force
        self.report = report
        self.observers = observers
        self.target_force = cycles[0].maximum  # of the current cycle
        self.closure = self.total_force = self.cycle_start = 0.0
        self.steps: list[Step] = []
        self.forces: list[np.ndarray] = []  # since the last maximum, for observers
        self.status = 0
        self.effort = Effort()
        largest = max(cycle.maximum for cycle in cycles)
        self.closure_limit = closure_limit(joint, largest)
        self.idle_steps = 0
        self.idle_displacement = 0.0
        may_be_idle = joint.interaction_acts and self.numerics.idle_interaction > 0.0
        # leaving it out pays if neither few nor most cells carry the largest force at the strength
        cells = largest / (joint.compressive_strength * joint.law.spacing**2)
        few_enough = _FEWEST_CONTACTS <= cells <= _MOST_CRUSHED * joint.upper.size
        self.leaves_interaction_out = may_be_idle and few_enough
        if self.leaves_interaction_out:
            joint.interaction_acts = False

    @property
    def failed(self) -> bool:
        return self.status >= FAILURE

    def settle(self, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m]; return the state, which is not accepted yet.

        ``breakage_step`` [m] is that of fixed steps. The effort is added up, and a failure is
        recorded in `status`, also if too many steps were taken in all.
        """
        settled = self.solver.settle(self.joint, closure, breakage_step)
        self.effort = self.effort.plus(settled.effort)
        if settled.outcome != Outcome.CONVERGED:
            self.status |= FLAG_OF_OUTCOME[settled.outcome]
        elif self.effort.breakage_steps > self.numerics.most_breakage_steps * self.joint.upper.size:
            self.status |= FLAG_OF_OUTCOME[Outcome.NOT_AT_REST]
        elif self.effort.settled > self.numerics.most_steps:
            self.status |= _TOO_MANY_STEPS
        return settled

    def predict(self, step: float, residual: float) -> float:
        """Predict the force [N] after a step [m] without breakage, see `Solver.predict`.

        The effort is added up.
        """
        assert self.solver.predict is not None
        force, effort = self.solver.predict(self.joint, self.closure + step, residual)
        self.effort = self.effort.plus(effort)
        return force

    def control(self, step: float, former: float) -> StepControl | None:
        """Return the `StepControl` of a branch, or None with fixed steps of breakage.

        ``step`` [m] is the configured one, ``former`` [N] the largest earlier maximum, infinite for
        an unloading.
        """
        if self.numerics.breakage != "resolved":
            return None
        return StepControl(self.numerics, step, self.target_force, former, self.seating_force)

    def displacement_left_out(self, settled: Settled) -> float | None:
        """Return by how much the interaction would displace a contact, over the closure.

        It is the largest such displacement in a state that was settled without interaction. It is
        None if the interaction may not be left out of this state: if the displacement exceeds
        `Numerics.idle_interaction`, or the force has reached the target.
        """
        displaced = self.joint.interaction_left_out() / settled.closure
        if settled.total_force >= self.target_force or displaced > self.numerics.idle_interaction:
            return None
        return displaced

    def accept(
        self, cycle: int, branch: str, settled: Settled, left_out: float | None = None
    ) -> None:
        """Append a state to the steps, and show it to the observers and to the report.

        The next step starts from its closure and force. ``left_out`` is the value of
        `displacement_left_out`, None if the interaction was not left out.
        """
        if left_out is not None:
            self.idle_steps += 1
            self.idle_displacement = max(left_out, self.idle_displacement)
        self.closure = settled.closure
        self.total_force = settled.total_force
        self.steps.append(Step(cycle, branch, settled, _mean_height(self.joint)))
        if self.observers:
            if branch == LOADING:
                self.forces.clear()
            self.forces.append(self.joint.force.copy())
        for observe in self.observers:
            observe(self.joint, self.steps[-1])
        if self.report:
            self.report(cycle, branch, settled.total_force / self.target_force)


def run_cycles(
    joint: Joint,
    solver: Solver,
    cycles: Sequence[LoadCycle],
    seating_force: float = 0.0,
    report: StepReport | None = None,
    observers: Sequence[Observer] = (),
) -> StepRecord:
    """Load a joint to the maximum of each cycle and unload it to its minimum, both in N.

    Return the record of the steps. It ends early if a step fails (`StepRecord.status`). A minimum
    of 0 is last contact. The joint is changed in place, and is left in its last state. Net closures
    are read at the ``seating_force`` [N]: elastic histories have a state there, and elastic
    branches of joints whose breakage is resolved have one near it. ``observers`` and ``report`` are
    called at every accepted step; ``report`` is not called in elastic histories.
    """
    if not joint.effects.breakage and solver.elastic_curve is not None:
        history = _elastic_cycles(joint, solver, cycles, seating_force)
        _show_elastic(joint, solver, history, observers)
        return history
    run = _Run(joint, solver, cycles, seating_force, report, observers)
    numerics = joint.numerics
    run.accept(1, LOADING, _untouched(joint))
    elastic = False
    replayed = 0
    for cycle, load in enumerate(cycles, start=1):
        run.target_force = load.maximum
        if cycle > 1 and joint.weaken_crushed():
            elastic = False
            joint.held_to = -np.inf
        if elastic and numerics.replay and load == cycles[cycle - 2]:
            _repeat_elastic(run, cycle)
            replayed += 1
            continue
        former = max((earlier.maximum for earlier in cycles[: cycle - 1]), default=0.0)
        if cycle == 1:
            steps = numerics.displacement_step, numerics.breakage_step
        else:
            steps = numerics.later_displacement_step, numerics.later_breakage_step
        _load(run, cycle, former, *steps)
        if run.failed:
            break
        if (last := run.steps[-1]).cycle < cycle:  # breakage jumped over the maximum at once
            run.accept(cycle, LOADING, last.settled._replace(effort=Effort()))
        unbreakable = unbreakable_share(run.steps[-1].settled)
        if joint.effects.breakage and unbreakable > LARGEST_UNBREAKABLE_SHARE:
            run.status |= OUTSIDE_MODEL_RANGE
        broken = run.effort.breakage_steps
        maximum = run.closure
        _unload(run, cycle, load.minimum)
        if run.failed:
            break
        at_rest = numerics.target == "equilibrate" and not run.status & TARGET_JUMPED
        elastic = at_rest and run.effort.breakage_steps == broken  # on the way from the maximum
        intact = not any(s.settled.effort.breakage_steps for s in run.steps if s.cycle == cycle)
        # up to here the joint is elastic
        joint.held_to = max(maximum, joint.held_to if intact else -np.inf) if elastic else -np.inf
    idle = run.idle_steps, run.idle_displacement
    return StepRecord(run.steps, run.status, run.effort, replayed, *idle)


def _elastic_cycles(joint, solver, cycles, seating_force) -> StepRecord:
    """Solve the cycles of a joint without breakage: one curve, loaded and unloaded.

    The record ends with the last state that converged. The joint gets the forces of the last step,
    unless a solution failed.
    """
    start = _untouched(joint)
    height = _mean_height(joint)
    forces = _elastic_forces(joint.numerics.curve_points, cycles, seating_force)
    curve = solver.elastic_curve(joint, forces[1:])
    failed = curve[-1].outcome != Outcome.CONVERGED
    status = FLAG_OF_OUTCOME[curve[-1].outcome] if failed else 0
    known = [start, *(curve[:-1] if failed else curve)]
    steps = [Step(1, LOADING, start, height)]
    turns = [int(np.abs(forces - force).argmin()) for cycle in cycles for force in cycle]
    for turn, (at, to) in enumerate(pairwise([0, *turns])):
        way = range(at - 1, to - 1, -1) if turn % 2 else range(at + 1, to + 1)
        place = turn // 2 + 1, BRANCHES[turn % 2]
        steps += [Step(*place, known[i], height) for i in way if i < len(known)]
        if to >= len(known):  # the solution failed at a smaller force
            break
    if not failed:
        joint.force[:] = 0.0
        if turns[-1]:
            solver.elastic_curve(joint, forces[turns[-1] :][:1])
    counts = zip(*(settled.effort for settled in curve), strict=True)
    return StepRecord(steps, status, Effort(*map(sum, counts)))


def _elastic_forces(count, cycles, seating_force) -> np.ndarray:
    """Return the total forces [N] at which an elastic curve is solved, ascending from 0.

    They are ``count`` + 1 evenly spaced forces up to the largest maximum, with the seating force
    and the maxima and minima of the cycles.
    """
    largest = max(cycle.maximum for cycle in cycles)
    forces = largest * np.arange(count + 1) / count
    # a turn or seating equal to one of these up to rounding is left out: its step has no length
    turns = {force for cycle in [*cycles, [seating_force]] for force in cycle if force <= largest}
    apart = [turn for turn in turns if np.abs(forces - turn).min() > 1e-12 * largest]
    return np.union1d(forces, apart) if apart else forces


def _show_elastic(joint, solver, history: StepRecord, observers: Sequence[Observer]) -> None:
    """Show every step of an elastic history to the observers, with the forces of that step.

    The joint has its last forces again afterwards.
    """
    ended = joint.force.copy()
    forces = {0.0: np.zeros(joint.force.shape)}
    for step in history.steps if observers else ():
        total = step.settled.total_force
        if total not in forces:
            solver.elastic_curve(joint, np.array([total]))
            forces[total] = joint.force.copy()
        joint.force[:] = forces[total]
        for observe in observers:
            observe(joint, step)
    joint.force[:] = ended


def _load(
    run: _Run, cycle: int, former: float, displacement_step: float, breakage_step: float
) -> None:
    """Load the joint by steps [m] until the force passes the target, then land on it.

    ``former`` is the largest earlier maximum [N]. A failure is recorded in `status`, also if the
    target is not reached at the limit of closure.
    """
    held = run.joint.held_to
    near = run.numerics.stress_tolerance * run.target_force
    control = run.control(displacement_step, former)
    step = displacement_step
    run.cycle_start = run.closure
    while True:
        if run.closure > run.closure_limit:
            run.status |= _NOT_REACHED
            return
        before = run.joint.snapshot()
        if control:
            step = control.fitting(step, run.total_force, run.predict)
        taken = step
        closure = run.closure + step
        if run.closure < held <= closure:  # only this step is shortened
            taken = held - run.closure
            closure = held
        settled = run.settle(closure, breakage_step)
        if run.failed:
            return
        left_out = run.displacement_left_out(settled) if run.leaves_interaction_out else None
        if run.leaves_interaction_out and left_out is None:
            run.joint.restore(before)
            run.joint.resume_interaction()
            run.leaves_interaction_out = False
            continue
        landed = abs(settled.total_force - run.target_force) <= near
        if landed and (control or closure == held):
            run.accept(cycle, LOADING, settled, left_out)
            return
        if control:
            step = control.following(taken, run.total_force, settled)
            if must_repeat(taken, step):
                run.joint.restore(before, rates=False)
                continue
        if settled.total_force < run.target_force:
            run.accept(cycle, LOADING, settled, left_out)
        elif run.numerics.target == "interpolate":
            _interpolate(run, cycle, LOADING, run.target_force, before, settled)
            return
        elif _land(run, cycle, before, settled, displacement_step, breakage_step):
            return


def _land(run, cycle, before, passed, displacement_step, breakage_step) -> bool:
    """Repeat the step that passed the target with smaller steps, until the force is in tolerance.

    ``before`` is the snapshot before that step, ``passed`` the state after it. Trials below the
    target are accepted, and may break contacts. From the last of them the force may no longer reach
    the target where it was passed before. Loading then has to go on, and False is returned;
    otherwise True, also if a step fails. If the force jumps over the target, the last state below
    it is the maximum, and this is recorded in `status`.
    """
    near = run.numerics.stress_tolerance * run.target_force
    above = passed  # the last state above the target
    further = passed  # the state above the target before that one
    passed_again = 0  # trials above the target in a row
    below_again = 0  # trials below the target in a row
    by_fixed_steps = run.numerics.breakage == "fixed_step"
    while True:
        if above.total_force - run.target_force <= near:
            run.accept(cycle, LOADING, above)
            return True
        if run.target_force - run.total_force <= near:
            run.joint.restore(before)
            return True
        exhausted = _is_exhausted(run, above.closure, displacement_step)
        anew = below_again >= (1 if exhausted else _MOST_BELOW)
        if exhausted and not anew:
            break
        run.joint.restore(before, rates=by_fixed_steps)
        if anew:
            trial = run.settle(above.closure, breakage_step)
        else:
            part = _part_to_target(run, above, further, passed_again, below_again)
            trial = run.settle(run.closure + part * (above.closure - run.closure), breakage_step)
        if run.failed:
            return True
        if trial.total_force > run.target_force:
            further = trial if anew else above
            above = trial
            passed_again = passed_again + 1
            below_again = 0
            continue
        run.accept(cycle, LOADING, trial)
        before = run.joint.snapshot()
        if anew:
            return False
        passed_again = 0
        below_again = below_again + 1
    run.joint.restore(before)
    # if even the first force exceeds the target, no state below the target carries force
    run.status |= TARGET_JUMPED if run.total_force > 0.0 else _NOT_REACHED
    return True


def _is_exhausted(run: _Run, closure_above: float, displacement_step: float) -> bool:
    """Return whether a closure [m] above the target is too near the present one for a trial.

    That is so if the difference is too small a share of the step, or below the rounding of heights.
    """
    room = closure_above - run.closure
    reached = closure_above - run.cycle_start
    resolved = float(np.spacing(abs(run.joint.first_touch) + closure_above))
    return room < _SMALLEST_STEP * min(displacement_step, reached) or room <= resolved


def _part_to_target(run: _Run, above, further, passed_again, below_again) -> float:
    """Return the share of the way to try between the states below and above the target.

    The way is that of the closure, from the last state below the target to the last one ``above``
    it; ``further`` is the state above the target before. After the first trials in a row above the
    target the share is that of a secant through the last two of them, otherwise that of false
    position, with forces halved as in the Illinois method.
    """
    missing = run.target_force - run.total_force
    beyond = above.total_force - run.target_force
    room = above.closure - run.closure
    if 0 < passed_again <= _MOST_SECANTS and further.total_force > above.total_force:
        slope = (further.total_force - above.total_force) / (further.closure - above.closure)
        part = 1.0 - beyond / (slope * room)
        if part > 0.02:
            return part
    missing *= 0.5 ** max(passed_again - 1, 0)
    beyond *= 0.5 ** max(below_again - 1, 0)
    return min(max(missing / (missing + beyond), 0.02), 0.98)


def _interpolate(run: _Run, cycle, branch, force: float, before: tuple, passed: Settled) -> None:
    """Accept a state at a force [N], linear between the last two states, as in the paper.

    ``before`` is the snapshot of the last accepted state, ``passed`` the state that passed the
    force. Walls, forces, interaction and closure of the joint are changed to the interpolated ones.
    """
    part = (force - run.total_force) / (passed.total_force - run.total_force)
    joint = run.joint
    upper, lower, _, *carried = before  # the states of the pairs are those of ``passed``
    fields = joint.upper, joint.lower, joint.force, joint.interaction
    for field, earlier in zip(fields, (upper, lower, *carried[:2]), strict=True):
        field[:] = earlier + part * (field - earlier)
    last = run.steps[-1].settled
    values = {
        name: getattr(last, name) + part * (getattr(passed, name) - getattr(last, name))
        for name in ("closure", "mean_interaction", "mean_overlap", "locked_share", "flat_share")
    }
    joint.closure[...] = values["closure"]  # start of the next step
    run.accept(cycle, branch, passed._replace(total_force=force, **values))


def _unload(run: _Run, cycle: int, minimum: float) -> None:
    """Unload the joint by steps, and end at the minimum force [N], or at last contact if it is 0.

    The step that would fall below the minimum is shortened or interpolated. A failure is recorded
    in `status`.
    """
    step = run.numerics.later_displacement_step
    control = run.control(step, np.inf)
    while True:
        before = run.joint.snapshot() if minimum or control else ()
        end = run.joint.last_touch
        settled = run.settle(max(run.closure - step, end), run.numerics.later_breakage_step)
        if run.failed:
            return
        if control:
            left = settled.total_force
            taken = step
            step = control.after(step, left, run.total_force - left)
            seating = control.step_to_seating(taken, run.total_force, left)
            if seating < taken:
                step = min(step, seating)
            if seating < taken or must_repeat(taken, step):
                run.joint.restore(before, rates=False)
                continue
        if settled.total_force < minimum:
            break
        run.accept(cycle, UNLOADING, settled)
        if settled.total_force == minimum or settled.closure <= run.joint.last_touch:
            return
    if run.numerics.target == "interpolate":
        _interpolate(run, cycle, UNLOADING, minimum, before, settled)
    else:
        _land_below(run, cycle, minimum, before, settled)


def _land_below(run: _Run, cycle: int, minimum: float, before: tuple, passed: Settled) -> None:
    """Repeat the step that fell below the minimum with shorter steps, until it is in tolerance.

    ``before`` is the snapshot before that step, ``passed`` the state after it. Only the last state
    is accepted. If the force jumps over the minimum, it is the state below, and this is recorded in
    `status`.
    """
    near = run.numerics.stress_tolerance * minimum
    high = run.closure
    high_force = run.total_force
    low = passed
    while abs(low.total_force - minimum) > near:
        room = high - low.closure
        if room < _SMALLEST_STEP * run.numerics.later_displacement_step:
            run.status |= TARGET_JUMPED
            run.joint.restore(before)
            low = run.settle(low.closure, run.numerics.later_breakage_step)
            break
        part = (high_force - minimum) / (high_force - low.total_force)
        run.joint.restore(before)
        closure = high - min(max(part, 0.1), 0.9) * room
        trial = run.settle(closure, run.numerics.later_breakage_step)
        if run.failed:
            return
        if abs(trial.total_force - minimum) <= near or trial.total_force < minimum:
            low = trial
        else:
            high = trial.closure
            high_force = trial.total_force
    run.accept(cycle, UNLOADING, low)


def _repeat_elastic(run: _Run, cycle: int) -> None:
    """Append a cycle equal to the one before, whose unloading broke nothing, without solving it.

    Its loading has the steps of that unloading in reverse, its unloading the same steps. Observers
    see the forces of each step.
    """
    opened = sum(step[:2] == (cycle - 1, UNLOADING) for step in run.steps)
    loop = [step.settled._replace(effort=Effort()) for step in run.steps[-opened - 1 :]]
    forces = tuple(run.forces)
    for branch, order in zip(BRANCHES, (range(opened)[::-1], range(1, opened + 1)), strict=True):
        for i in order:
            if forces:
                run.joint.force[:] = forces[i]
            run.accept(cycle, branch, loop[i])


def _untouched(joint: Joint) -> Settled:
    nowhere = np.zeros(joint.upper.shape, dtype=bool)
    return joint.describe(0.0, Outcome.CONVERGED, nowhere, Effort())


def _mean_height(joint: Joint) -> float:
    return float(joint.upper.mean() + joint.lower.mean())


def closure_limit(joint: Joint, target_force: float) -> float:
    """Return an upper bound of the closure [m] at which the joint carries a target force [N].

    It is by a formula: twice the sum of the range of the summed heights and of the displacements by
    the force, if all cells carried it evenly. A joint that carries less at this closure never
    carries the force.
    """
    summed = joint.upper + joint.lower
    per_cell = target_force / summed.size
    cells, _, _, compliance = joint.overlapping(float(np.ptp(summed)) + joint.first_touch)
    elastic = joint.law.substrate * per_cell
    if cells.size:
        elastic += float(compliance.max()) * float(np.cbrt(per_cell)) ** 2
    if joint.effects.interaction:
        elastic += 4.0 * per_cell * float(joint.influence_table.sum())
    return 2.0 * (float(np.ptp(summed)) + elastic)
