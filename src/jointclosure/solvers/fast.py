"""Fast solver: alternates breakage until rest and equilibrium.

A joint is brought to rest at a closure in *rounds*: with the interaction held, pairs break until
all are within their strength; with the walls held, forces and their interaction are solved for.
Rounds are repeated until an equilibrium breaks nothing. An approximate solution determines what
breaks next, so that the residual is reduced in *stages*: first `PROVISIONAL_TOLERANCES`, then the
required one.

Without breakage there is one round, an equilibrium. With fixed steps the first round extrapolates
forces and interaction, breaks pairs at the extrapolated interaction, and solves for the forces,
provisionally if a pair broke. Where no breakage is expected, because the joint opens or is closed
no further than its contacts hold (`Joint.held_to`), pairs are first checked at the solved forces.

With resolved breakage the step is first walked through in `SHORT_STEPS` short steps in which only
breakage acts, with the interaction extrapolated by its rate: breakage is local and needs short
steps, interaction is smooth and does not (docs/decisions.md#0010-resolved-breakage). The
equilibrium that follows, in which no contact exceeds its strength, corrects the extrapolation; the
difference of its force to that at rest measures the error of the step.
"""

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.solvers.breakage import breakage_kernel, strength_limits
from jointclosure.solvers.contacts import Contacts, start_forces
from jointclosure.solvers.elastic import elastic_curve
from jointclosure.solvers.equilibrium import Equilibrium, solve_equilibrium
from jointclosure.solvers.interaction_operator import add_changes_of_force, interaction_field
from jointclosure.solvers.joint import Effort, Joint, Outcome, Settled
from jointclosure.solvers.newton import ROUNDING

PROVISIONAL_TOLERANCES = (1e-2,)
"""Residuals that are sufficient to determine what breaks next, stage by stage."""
BAND = 2.8
"""Width of the band about its strength in which a contact is at rest, over `Numerics.tolerance`."""
SHORT_STEPS = 8
"""Short steps of breakage in a step of closure with resolved breakage."""
MOST_ROUNDS = 1000  # equilibria of one closure after which a joint counts as not at rest; chosen
_NO_GROWTH = np.zeros((0, 0))  # of the approach, where breakage is not walked through
_CLEAR_OF_STRENGTH = 0.98
"""Share of its strength below which a contact with an approximate force is assumed to hold."""


class FastSolver:
    """Default solver; see the module and `Solver`."""

    elastic_curve = staticmethod(elastic_curve)

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m], in place, and return the state reached.

        Its walls, forces, interaction, closure and their rates are changed. Fixed steps of breakage
        lower a pair of cells by ``breakage_step`` [m].
        """
        asked = finest = joint.numerics.force_tolerance
        before = joint.interaction.copy(), joint.force.copy()
        step = closure - float(joint.closure)
        path = _PathToRest(joint, closure, breakage_step)
        predicted = np.nan
        try:
            if not joint.effects.breakage:
                path.solve(asked)
            elif _is_resolved(joint):
                predicted = path.begin_within_strength(step, asked)
                path.alternate(asked)
            else:
                path.begin_extrapolated(step, asked)
                path.alternate(asked)
            settled = path.described(Outcome.CONVERGED)
            while not settled.residual <= asked:
                finest *= 0.5 * asked / settled.residual
                path.tighten(finest)
                settled = path.described(Outcome.CONVERGED)
        except _GivenUp as given_up:
            settled = path.described(given_up.outcome)
        if step != 0.0:
            _store_rates(joint, before, step)
        joint.closure[...] = closure
        if settled.effort.breakage_steps > 0 and _is_resolved(joint):
            settled = settled._replace(correction=abs(settled.total_force - predicted))
        return settled

    def predict(self, joint: Joint, closure: float, residual: float) -> tuple[float, Effort]:
        """Return the total force [N] at a closure [m] before anything breaks, and the effort.

        The equilibrium is solved to this ``residual``, but to no smaller one than the required one.
        The force is infinite if none was found. With resolved breakage no contact exceeds its
        strength. Walls, forces and interaction of the joint stay as they are. Its rates of force
        and interaction become those of the predicted step, and the memory of the solver changes.
        """
        path = _PathToRest(joint, closure, np.nan)
        before = joint.interaction.copy(), joint.force.copy()
        step = closure - float(joint.closure)
        try:
            finest = joint.numerics.force_tolerance
            path.extrapolate(step)
            force = float(path.solve(max(residual, finest)).force.sum())
            _store_rates(joint, before, step)
        except _GivenUp:
            force = np.inf
        joint.interaction[:], joint.force[:] = before
        return force, Effort(0, path.rounds, path.newton_steps, path.products)


class _GivenUp(Exception):
    """Raised if a joint does not come to rest; ``outcome`` is the reason."""

    def __init__(self, outcome: Outcome):
        self.outcome = outcome


class _PathToRest:
    """Joint on its way to rest at a closure [m], with the effort so far.

    All methods change the joint in place. Those that break pairs or solve for forces raise
    `_GivenUp` if this does not succeed.
    """

    def __init__(self, joint: Joint, closure: float, breakage_step: float):
        self.joint = joint
        self.closure = closure
        self.breakage_step = breakage_step
        self.locked = np.zeros(joint.upper.shape, dtype=bool)
        self.solved_to = np.inf  # residual of the present forces
        self.rounds = self.newton_steps = self.products = self.breakage_steps = 0
        self._interaction_known = True  # whether the joint's interaction is that of its forces
        # valid until breakage changes the walls
        self._overlapping: tuple | None = None
        self._may_carry: Contacts | None = None

    def described(self, outcome: Outcome) -> Settled:
        """Return the present state of the joint with an outcome, as `Joint.describe` does."""
        effort = Effort(1, self.rounds, self.newton_steps, self.products, self.breakage_steps)
        if self._overlapping is None:
            self._overlapping = self.joint.overlapping(self.closure)
        return self.joint.describe(self.closure, outcome, self.locked, effort, self._overlapping)

    def begin_extrapolated(self, step: float, asked: float) -> None:
        """Do the first round with fixed breakage steps, ``step`` [m] after the last closure.

        ``asked`` is the required residual. If nothing breaks before the forces are solved for, they
        are solved to it, else to the first one of the stages.
        """
        # the interaction of the step before is too small on closing, and too much would break
        self.extrapolate(step)
        # otherwise breakage is checked after the forces are solved
        may_break = step > 0.0 and self.closure > self.joint.held_to
        self.solve(_stage_tolerances(asked)[0] if may_break and self.break_to_rest() > 0 else asked)

    def begin_within_strength(self, step: float, asked: float) -> float:
        """Do the first round of resolved breakage along a ``step`` [m]; return the total force [N].

        ``asked`` is the required residual, used if nothing can break, or else the first one of the
        stages.
        """
        self.extrapolate(step)
        may_break = step > 0.0 and self.closure > self.joint.held_to
        if may_break:
            self.break_in_short_steps(step)
        return float(self.solve(_stage_tolerances(asked)[0] if may_break else asked).force.sum())

    def extrapolate(self, step: float) -> None:
        """Extrapolate the joint's forces and interaction by their rates, over a ``step`` [m]."""
        joint = self.joint
        follow_rates(joint.interaction, joint.interaction_rate, joint.force, joint.force_rate, step)
        self._interaction_known = False

    def alternate(self, asked: float) -> None:
        """Break pairs and solve for forces in turn, until an equilibrium breaks nothing.

        Its residual is at most ``asked``.
        """
        stages = _stage_tolerances(asked)
        stage = 0
        while True:
            if self.break_to_rest() == 0:
                if self.solved_to <= asked:
                    return
                stage = len(stages) - 1 if self._is_clear_of_strength() else stage + 1
            self.solve(stages[stage])

    def tighten(self, finer: float) -> None:
        """Solve to a smaller residual ``finer`` than before, and break what exceeds its strength.

        Raise `_GivenUp` if the residual is below what rounding allows.
        """
        if not finer >= ROUNDING:
            raise _GivenUp(Outcome.NOT_CONVERGED)
        self.solve(finer)
        if self.joint.effects.breakage:
            self.alternate(finer)

    def break_to_rest(self) -> int:
        """Break pairs at the present interaction until rest; return the number of steps."""
        return self._break(_NO_GROWTH, 1)

    def break_in_short_steps(self, step: float) -> None:
        """Break pairs along a ``step`` [m] that ends at the closure of the path, in `SHORT_STEPS`.

        The joint's interaction is extrapolated to the end of the step, and grows by its rate.
        """
        self._break(step * (1.0 - self.joint.interaction_rate), SHORT_STEPS)

    def _break(self, growth: np.ndarray, short_steps: int) -> int:
        """Break pairs while the approach grows by ``growth`` (y, x) [m] in a number of short steps.

        Return the number of breakage steps. With one short step the growth is not used, and may be
        empty. Raise `_GivenUp` after `Numerics.most_breakage_steps`.
        """
        joint = self.joint
        choices = joint.choices
        most = int(min(joint.numerics.most_breakage_steps * joint.upper.size, 2.0**62))
        kernel = breakage_kernel(
            joint.effects.gouge,
            choices.peaks == "current",
            _is_resolved(joint),
            choices.strength_bound == "base",
        )
        steps, self.locked = kernel(
            joint.upper,
            joint.lower,
            float(self.closure - joint.first_touch),
            joint.interaction,
            joint.peaks,
            joint.law,
            float(self.breakage_step),
            _strength_band(joint),
            joint.tie_tolerance,
            most,
            joint.breakage_space,
            growth,
            short_steps,
        )
        self.breakage_steps += steps
        if steps > 0:
            self._overlapping = self._may_carry = None
        if self.breakage_steps >= most:
            raise _GivenUp(Outcome.NOT_AT_REST)
        return steps

    def solve(self, tolerance: float) -> Equilibrium:
        """Solve the equilibrium at the present walls to a residual, and set forces and interaction.

        The interaction is set at the contacts, and at all cells if breakage is resolved or if the
        equilibrium was solved by a convolution. Raise `_GivenUp` if the residual is not reached, or
        after `MOST_ROUNDS`.
        """
        if self.rounds >= MOST_ROUNDS:
            raise _GivenUp(Outcome.NOT_AT_REST)
        joint = self.joint
        contacts, matrix = joint.with_matrix(self._contacts())
        cells = contacts.cells
        known = self._interaction_known and joint.influence is not None and matrix is None
        start = start_forces(joint.force, cells, contacts.overlap)
        if known:
            add_changes_of_force(joint.influence, cells, start, joint.force, joint.interaction)
        answer = solve_equilibrium(
            joint.influence, contacts, start, np.nan, tolerance, matrix,
            field=joint.interaction if known else None, space=joint.space_for(cells.size),
        )  # fmt: skip
        joint.coarse_space = answer.space
        joint.force[:] = 0.0
        joint.force.ravel()[cells] = answer.force
        if answer.field.size > 0:
            joint.interaction[:] = answer.field
        elif joint.influence is not None:
            if _is_resolved(joint):  # with fixed steps other cells follow at rest
                joint.interaction[:] = interaction_field(joint.influence, joint.force)
            joint.interaction.ravel()[cells] = answer.interaction
        self._interaction_known = answer.field.size > 0
        self.rounds += 1
        self.newton_steps += answer.newton_steps
        self.products += answer.products
        if not answer.residual <= tolerance:
            raise _GivenUp(
                Outcome.RIGID_CONTACT if answer.residual == np.inf else Outcome.NOT_CONVERGED
            )
        self.solved_to = tolerance
        return answer

    def _is_clear_of_strength(self) -> bool:
        """Return whether no contact is near its strength, so that a finer solution breaks nothing.

        With fixed steps, whose contacts have no limit, it is always False.
        """
        if not _is_resolved(self.joint):
            return False
        contacts = self._contacts()
        force = self.joint.force.ravel()[contacts.cells]
        return not bool((force > _CLEAR_OF_STRENGTH * contacts.limit).any())

    def _contacts(self) -> Contacts:
        """Return the contacts at the present walls; they are kept until breakage changes the walls.

        With resolved breakage their forces are limited by their strength.
        """
        joint = self.joint
        if self._may_carry is None:
            self._overlapping = joint.overlapping(self.closure)
            cells, overlap, curvature, compliance = self._overlapping
            self._may_carry = joint.contacts(cells, overlap, compliance)
            if joint.effects.breakage and _is_resolved(joint):
                limit = strength_limits(
                    joint.upper,
                    joint.lower,
                    cells,
                    curvature,
                    compliance,
                    joint.peaks,
                    joint.law,
                    joint.effects.gouge,
                    joint.tie_tolerance,
                    _strength_band(joint),
                )
                self._may_carry = self._may_carry._replace(limit=limit)
        return self._may_carry


def _stage_tolerances(asked: float) -> tuple[float, ...]:
    """Return the residuals of the stages of a solution; the last is ``asked``, the required one."""
    return (*(rough for rough in PROVISIONAL_TOLERANCES if rough > asked), asked)


def _store_rates(joint: Joint, before: tuple[np.ndarray, np.ndarray], step: float) -> None:
    """Store in the joint the rates of interaction and force per closure over a ``step`` [m].

    ``before`` are interaction (y, x) [m] and forces (y, x) [N] before the step. They serve to
    extrapolate the next step; rates of interaction are cut to the range from 0 to 1.
    """
    interaction, force = before
    set_rates(joint.interaction_rate, joint.interaction, interaction, step)
    np.clip(joint.interaction_rate, 0.0, 1.0, out=joint.interaction_rate)
    set_rates(joint.force_rate, joint.force, force, step)


@kernel
def set_rates(rate, field, former, step):
    """Set ``rate`` (y, x) to the change of a field (y, x) over a ``step`` [m] of closure.

    ``former`` (y, x) are the values of the field before the step.
    """
    for y in range(field.shape[0]):
        for x in range(field.shape[1]):
            rate[y, x] = (field[y, x] - former[y, x]) / step


@kernel
def follow_rates(interaction, interaction_rate, force, force_rate, step):
    """Extrapolate interaction [m] and forces [N] (y, x) over a step [m] of closure, in place.

    Rates are per closure [1, N/m]. No force becomes negative.
    """
    for y in range(force.shape[0]):
        for x in range(force.shape[1]):
            interaction[y, x] += step * interaction_rate[y, x]
            force[y, x] = max(force[y, x] + step * force_rate[y, x], 0.0)


def _is_resolved(joint: Joint) -> bool:
    """Return whether the joint has resolved breakage, not fixed breakage steps."""
    return joint.numerics.breakage == "resolved"


def _strength_band(joint: Joint) -> float:
    """Return the width of the band of overlap ratios, about 1, in which a contact is at rest.

    It applies to resolved breakage.
    """
    return float(BAND * joint.numerics.tolerance)
