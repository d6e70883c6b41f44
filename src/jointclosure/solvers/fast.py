"""The fast solver: breakage to rest and equilibrium in turn.

The paper returns to the detection of contacts after every single breakage.
Here all breakage at a given interaction runs to rest first (a work queue),
then equilibrium is solved anew, until neither changes anything.
"""

import numpy as np

from jointclosure.solvers.breakage import breakage_kernel
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

PROVISIONAL_TOLERANCE = 1e-2
"""Residual that suffices to find what breaks next; what rests is solved on."""
MOST_ROUNDS = 1000
MOST_BREAKAGE_STEPS = 1_000_000_000


class FastSolver:
    """Solver of production; see the module's text and `Solver`."""

    elastic_curve = staticmethod(elastic_curve)

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m]; breakage in steps [m]."""
        final = joint.numerics.force_tolerance
        confined = np.zeros(joint.upper.shape, dtype=bool)
        broken = iterations = 0
        outcome, tolerance = NOT_AT_REST, max(final, PROVISIONAL_TOLERANCE)
        if not joint.effects.breakage:
            tolerance = final
        for round_ in range(MOST_ROUNDS):
            if joint.effects.breakage:
                steps, confined = self._break_to_rest(joint, closure, breakage_step)
                broken += steps
                if steps == 0 and round_ > 0:
                    if tolerance == final:
                        outcome = CONVERGED
                        break
                    tolerance = final
                elif broken >= MOST_BREAKAGE_STEPS:
                    break
            answer = self._equilibrate(joint, closure, tolerance)
            iterations += answer.products
            if not answer.residual <= tolerance:
                outcome = RIGID_CONTACT if answer.residual == np.inf else NOT_CONVERGED
                break
            if not joint.effects.breakage:
                outcome = CONVERGED
                break
        return joint.describe(closure, outcome, broken, confined, iterations)

    @staticmethod
    def _break_to_rest(joint: Joint, closure: float, breakage_step: float):
        kernel = breakage_kernel(joint.effects.gouge, joint.choices.peaks == "current")
        return kernel(
            joint.upper,
            joint.lower,
            float(closure - joint.first_touch),
            joint.interaction,
            joint.peaks,
            joint.law,
            float(breakage_step),
            joint.tie_tolerance,
            MOST_BREAKAGE_STEPS,
        )

    @staticmethod
    def _equilibrate(joint: Joint, closure: float, tolerance: float):
        cells, overlap, _, compliance = joint.overlapping(closure)
        answer = solve_equilibrium(
            joint.influence,
            joint.contacts(cells, overlap, compliance),
            joint.force.ravel()[cells],
            np.nan,
            tolerance,
        )
        joint.force[:] = 0.0
        joint.force.ravel()[cells] = answer.force
        if joint.influence is not None:
            joint.interaction[:] = interaction_field(joint.influence, joint.force)
            joint.interaction.ravel()[cells] = answer.interaction
        return answer
