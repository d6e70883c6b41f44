"""Closure at given forces, where nothing breaks.

Without breakage a joint has no history: each force has one closure, the
solution of one convex problem, and loading and unloading are one curve. No
displacement steps are taken.
"""

import numpy as np

from jointclosure.solvers.contacts import Contacts, separate_equilibrium, separate_shift
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import (
    dense_influence,
    dense_limit,
    influence_matrix,
)
from jointclosure.solvers.joint import (
    CONVERGED,
    NOT_CONVERGED,
    RIGID_CONTACT,
    Effort,
    Joint,
    Settled,
)
from jointclosure.solvers.newton import Equilibrium

ELASTIC_TOLERANCE = 1e-10
"""Relative residual of the forces, also where `Numerics.force_tolerance` asks for less."""
_FIRST_CANDIDATES = 48


class _Candidates:
    """The cells that may touch up to some closure, and their influence on each other."""

    def __init__(self, joint: Joint, reach: float):
        self.joint, self.reach = joint, reach
        self.tolerance = min(joint.numerics.force_tolerance, ELASTIC_TOLERANCE)
        cells, overlap, self.curvature, compliance = joint.overlapping(reach)
        # overlaps at closure 0, none of them positive
        self.contacts = joint.contacts(cells, overlap - reach, compliance)
        self.influence, self.matrix = None, None
        if joint.effects.interaction:
            table = joint.influence_table
            dense = cells.size <= dense_limit(table.shape)
            self.influence = dense_influence(table) if dense else joint.influence
            self.matrix = influence_matrix(table, cells[: cells.size if dense else 0])

    def solve(self, force: np.ndarray, closure: float, target: float) -> Equilibrium:
        """Equilibrium at a total force [N] from a guess of forces (n,) and closure."""
        start = self.contacts._replace(overlap=self.contacts.overlap + closure)
        found = solve_equilibrium(self.influence, start, force, target, self.tolerance, self.matrix)
        return found._replace(shift=found.shift + closure)


def elastic_curve(joint: Joint, targets: np.ndarray) -> list[Settled]:
    """Close an elastic joint to each of some total forces.

    Parameters
    ----------
    joint : Joint
        In a scene without breakage; its forces are left at the last target.
    targets : array (t,)
        Total forces [N], positive and ascending.

    Returns
    -------
    list of Settled
        One for each target; shorter where a target failed, which the last
        entry's outcome then says.
    """
    candidates = _Candidates(joint, _reach_of(joint, _FIRST_CANDIDATES))
    solved: list[tuple[np.ndarray, float, float]] = []  # force field, closure, target
    settled = []
    for target in targets:
        while True:
            force, closure = _predicted(solved, target, candidates.contacts)
            found = candidates.solve(force, min(closure, candidates.reach), target)
            if not found.shift > candidates.reach or not np.isfinite(found.shift):
                break
            candidates = _Candidates(joint, 1.3 * found.shift)
        field = np.zeros(joint.upper.size)
        field[candidates.contacts.cells] = found.force
        solved = [*solved[-1:], (field, found.shift, target)]
        joint.force[:] = field.reshape(joint.force.shape)
        settled.append(_settled(joint, candidates, found))
        if settled[-1].outcome != CONVERGED:
            break
    return settled


def _reach_of(joint: Joint, count: int) -> float:
    """Closure [m] at which about so many cells overlap, and one at least."""
    summed = (joint.upper + joint.lower).ravel()
    rank = max(summed.size - count, 0)
    reach = joint.first_touch - float(np.partition(summed, rank)[rank])
    return reach + 4.0 * float(np.spacing(abs(joint.first_touch)))


def _predicted(solved: list, target: float, contacts: Contacts) -> tuple[np.ndarray, float]:
    """Forces and closure to start from: extrapolated, or those without interaction."""
    if not solved:
        closure = separate_shift(contacts, target)
        return np.nan_to_num(separate_equilibrium(contacts, closure), posinf=target), closure
    cells = contacts.cells
    field, closure, reached = solved[-1]
    if len(solved) == 1:
        return field[cells] * (target / reached), closure * (target / reached) ** 0.5
    earlier, closure_before, reached_before = solved[0]
    ahead = (target - reached) / (reached - reached_before)
    force = field[cells] + ahead * (field[cells] - earlier[cells])
    return np.maximum(force, 0.0), closure + ahead * (closure - closure_before)


def _settled(joint: Joint, candidates: _Candidates, found: Equilibrium) -> Settled:
    total = float(found.force.sum())
    outcome = CONVERGED if found.residual <= candidates.tolerance else NOT_CONVERGED
    if found.residual == np.inf:
        outcome = RIGID_CONTACT
    flat = joint.force_on_flats(candidates.curvature, found.force)
    return Settled(
        outcome=outcome,
        closure=found.shift,
        total_force=total,
        least_force=float(found.force.min()),
        contacts=int(np.count_nonzero(found.force)),
        mean_interaction=joint.mean_interaction(),
        residual=found.residual,
        locked_contacts=0,
        locked_share=0.0,
        flat_share=flat / total if total > 0.0 else 0.0,
        effort=Effort(1, 1, found.newton_steps, found.products),
    )
