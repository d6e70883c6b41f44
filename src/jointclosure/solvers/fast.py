"""The fast solver: breakage to rest and equilibrium in turn.

The paper returns to the detection of contacts after every single breakage.
Here all breakage at a given interaction runs to rest, then equilibrium is
solved anew, until neither changes anything. The interaction to begin with is
extrapolated from the steps before (fixed breakage steps), or that of an
equilibrium in which no contact carries more than its strength (resolved
breakage): docs/decisions/0010-resolved-breakage.md.
"""

import numpy as np

from jointclosure.solvers.breakage import breakage_kernel, strength_limits
from jointclosure.solvers.elastic import elastic_curve
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import (
    CONVERGED,
    NOT_AT_REST,
    NOT_CONVERGED,
    RIGID_CONTACT,
    Joint,
    Settled,
)

PROVISIONAL_TOLERANCES = (1e-2, 1e-4)
"""Residuals that suffice to find what breaks next; where nothing does, the next of them, and at
last the one that is asked for."""
BAND = 10.0
"""Width of the band about its strength in which a contact rests, over `Numerics.tolerance`."""
MISJUDGED = 1e-6
"""Recomputed residual beyond which a solution is none, whatever the solver believes."""
MOST_ROUNDS = 1000
MOST_BREAKAGE_STEPS = 1_000_000_000


class FastSolver:
    """Solver of production; see the module's text and `Solver`."""

    elastic_curve = staticmethod(elastic_curve)

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m]; breakage in steps [m]."""
        final = joint.numerics.force_tolerance
        breakage = joint.effects.breakage
        tolerances = [each for each in PROVISIONAL_TOLERANCES if breakage and each > final]
        tolerances.append(final)
        confined = np.zeros(joint.upper.shape, dtype=bool)
        broken = iterations = 0
        outcome, solved_to, predicted = NOT_AT_REST, np.inf, 0.0
        predict = not breakage or _resolved(joint)
        before = joint.interaction.copy(), joint.force.copy()
        step = closure - float(joint.closure)
        if not predict:
            # that of the step before is too low while the joint closes, and too much breaks
            joint.interaction += step * joint.interaction_rate
        for round_ in range(MOST_ROUNDS):
            steps = 0
            begins = round_ == 0
            if breakage and not (predict and begins):
                steps, confined = self._break_to_rest(joint, closure, breakage_step)
                broken += steps
            if steps == 0 and solved_to <= final:
                outcome = CONVERGED
                break
            if broken >= MOST_BREAKAGE_STEPS:
                break
            if steps == 0 and solved_to <= tolerances[0]:
                del tolerances[0]
            elastic = begins and steps == 0 and not predict
            if elastic:
                np.maximum(joint.force + step * joint.force_rate, 0.0, out=joint.force)
            tolerance = final if elastic else tolerances[0]
            answer = self._equilibrate(joint, closure, tolerance)
            iterations += answer.products
            if not answer.residual <= tolerance:
                outcome = RIGID_CONTACT if answer.residual == np.inf else NOT_CONVERGED
                break
            solved_to = tolerance
            if predict and begins:
                predicted = float(answer.force.sum())
        if step != 0.0:
            _note_rates(joint, before, step)
        joint.closure[...] = closure
        settled = joint.describe(closure, outcome, broken, confined, iterations)
        if outcome == CONVERGED and not settled.residual <= max(100.0 * final, MISJUDGED):
            settled = settled._replace(outcome=NOT_CONVERGED)
        if predict and broken > 0:
            settled = settled._replace(correction=abs(settled.total_force - predicted))
        return settled

    @staticmethod
    def _break_to_rest(joint: Joint, closure: float, breakage_step: float):
        kernel = breakage_kernel(
            joint.effects.gouge, joint.choices.peaks == "current", _resolved(joint)
        )
        return kernel(
            joint.upper,
            joint.lower,
            float(closure - joint.first_touch),
            joint.interaction,
            joint.peaks,
            joint.law,
            float(breakage_step),
            _band(joint),
            joint.tie_tolerance,
            MOST_BREAKAGE_STEPS,
        )

    @staticmethod
    def _equilibrate(joint: Joint, closure: float, tolerance: float):
        cells, overlap, curvature, compliance = joint.overlapping(closure)
        contacts = joint.contacts(cells, overlap, compliance)
        if joint.effects.breakage and _resolved(joint):
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
                _band(joint),
            )
            contacts = contacts._replace(limit=limit)
        # the interaction of those forces, or what it is expected to become
        pushed = joint.interaction.ravel()[cells]
        answer = solve_equilibrium(
            joint.influence,
            contacts,
            joint.force.ravel()[cells],
            np.nan,
            tolerance,
            pushed=pushed,
        )
        joint.force[:] = 0.0
        joint.force.ravel()[cells] = answer.force
        if joint.influence is not None:
            known = answer.field.size > 0
            field = answer.field if known else interaction_field(joint.influence, joint.force)
            joint.interaction[:] = field
            joint.interaction.ravel()[cells] = answer.interaction
        return answer


def _note_rates(joint: Joint, before: tuple[np.ndarray, np.ndarray], step: float) -> None:
    """Rates of interaction and force, per closure, to extrapolate the next step by.

    Where much broke in a small step the quotient of the interaction says
    nothing; the elastic rate lies within the bounds.
    """
    interaction, force = before
    np.clip((joint.interaction - interaction) / step, 0.0, 1.0, out=joint.interaction_rate)
    np.divide(joint.force - force, step, out=joint.force_rate)


def _resolved(joint: Joint) -> bool:
    """Whether contacts lose what brings them back to their strength, not a fixed step."""
    return joint.numerics.breakage == "resolved"


def _band(joint: Joint) -> float:
    """Width of the band about its strength in which a contact rests."""
    return float(BAND * joint.numerics.tolerance)
