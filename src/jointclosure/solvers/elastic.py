"""Closure at given total forces without breakage: each is the solution of one convex problem."""

from typing import NamedTuple

import numpy as np

from jointclosure.solvers.contacts import Contacts, separate_equilibrium, separate_shift
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import (
    add_displacements,
    dense_influence,
    dense_limit,
    influence_matrix,
)
from jointclosure.solvers.joint import Effort, Joint, Outcome, Settled
from jointclosure.solvers.newton import Equilibrium

ELASTIC_TOLERANCE = 1e-8
"""Relative residual of the forces, even if `Numerics.force_tolerance` is larger."""
_UNKNOWN = np.empty((0, 0))  # in place of a field of displacements that was not computed
_FIRST_CANDIDATES = 48  # number of candidates at first, until a closure exceeds their reach
_FEW = 0.1
"""Number of candidates over `dense_limit`, up to which all of them are solved for at once."""


class _Point(NamedTuple):
    """State of an elastic joint at one total force, solved or guessed.

    The forces of a guess may be negative.
    """

    force: np.ndarray  # of all cells of the grid (n,) [N]
    gap: np.ndarray  # overlap less interaction (n,) [m], or an upper bound; NaN if not computed
    field: np.ndarray  # displacements (y, x) [m] by the forces; empty if not computed
    closure: float  # [m]
    target: float  # total force [N]


class _Candidates:
    """Cells of an elastic joint that may be in contact up to the closure ``reach`` [m].

    They are the cells that overlap at this closure, and their influence on each other. Equilibrium
    is solved for a *working set* of these candidates. It differs from the textbook's active set:
    all candidates that come into contact are added at once, and none is taken out, because the
    contact law itself gives an open contact a force of 0. Few candidates (`_FEW`) are all solved
    for at once.
    """

    def __init__(self, joint: Joint, reach: float):
        self.joint = joint
        self.reach = reach
        self.tolerance = min(joint.numerics.force_tolerance, ELASTIC_TOLERANCE)
        cells, overlap, self.curvature, compliance = joint.overlapping(reach)
        # overlaps at closure 0, none positive
        self.contacts = joint.contacts(cells, overlap - reach, compliance)
        self.influence = None
        self.matrix = None
        self.few = cells.size <= _FEW * dense_limit(joint.upper.shape)
        if joint.effects.interaction:
            table = joint.influence_table
            self.influence = dense_influence(table) if self.few else joint.influence
            self.matrix = influence_matrix(table, cells[: cells.size if self.few else 0])

    def solve(self, guess: _Point, target: float) -> tuple[Equilibrium, np.ndarray]:
        """Return the equilibrium of the candidates (n,) at a total force [N], and their gaps (n,).

        The `shift` of the equilibrium is the closure [m]. If it exceeds `reach`, other cells may be
        in contact, and the caller must repeat with new candidates. Gaps [m] are as in `_Point`; all
        are NaN if the candidates are few or if there is no interaction. The iteration starts from
        ``guess``, which is for all cells of the grid; `guess.field` is changed in place.
        """
        cells = self.contacts.cells
        closure = min(guess.closure, self.reach)
        start = self.contacts._replace(overlap=self.contacts.overlap + closure)
        force = np.maximum(guess.force[cells], 0.0)
        if self.influence is None or self.few:
            solution = self._equilibrium(start, force, target, self.matrix, _UNKNOWN)
            gap = np.full(cells.size, np.nan)
        else:
            field = guess.field
            if field.size > 0:
                change = force - guess.force[cells]
                add_displacements(self.influence, self.matrix, cells, change, field)
            inside = (force > 0.0) | (guess.gap[cells] > 0.0)
            solution, gap = self._solve_working_set(start, force, inside, target, field)
        return solution._replace(shift=solution.shift + closure), gap

    def _equilibrium(
        self,
        contacts: Contacts,
        force: np.ndarray,
        target: float,
        matrix: np.ndarray | None,
        field: np.ndarray,
    ) -> Equilibrium:
        """Solve the equilibrium of contacts (n,) at a total force [N] from starting forces (n,).

        ``matrix`` is their influence matrix, empty for a convolution, or None without interaction.
        ``field`` (y, x) [m] has the displacements by the starting forces, or is empty. The
        preconditioner of the solution is kept in the joint for the next equilibrium.
        """
        joint = self.joint
        solution = solve_equilibrium(
            self.influence, contacts, force, target, self.tolerance, matrix,
            field=field, space=joint.space_for(int(np.count_nonzero(force))),
        )  # fmt: skip
        joint.coarse_space = solution.space
        return solution

    def _solve_working_set(
        self,
        start: Contacts,
        force: np.ndarray,
        inside: np.ndarray,
        target: float,
        field: np.ndarray,
    ) -> tuple[Equilibrium, np.ndarray]:
        """Solve the equilibrium of the candidates in the working set ``inside`` (n,), a mask.

        Candidates outside of it that would overlap are added, in place, and the equilibrium is
        solved again until none would. If the working set is empty, or too large for an influence
        matrix, all candidates are solved for with a convolution instead, which alone uses
        ``field``: the displacements (y, x) [m] by the starting ``force`` (n,) [N], or empty. Return
        the equilibrium, with the forces of all candidates and the effort of all solutions, and the
        gaps (n,) [m] of `_Point`.
        """
        recent = self.joint.recent_contacts
        newton_steps = 0
        products = 0
        while True:
            some = Contacts._make((*(values[inside] for values in start[:4]), start.substrate))
            contacts, matrix = self.joint.with_matrix(some)
            if matrix is None or not some.cells.size:
                solution = self._equilibrium(start, force, target, self.matrix, field)
                gap = start.overlap + solution.shift - solution.interaction
                break
            slot = recent.slots(some.cells)
            guess = np.zeros(contacts.cells.size)
            guess[slot] = force[inside]
            solution = self._equilibrium(contacts, guess, target, matrix, _UNKNOWN)
            field = _UNKNOWN  # the forces have changed
            newton_steps += solution.newton_steps
            products += solution.products
            force = np.zeros(start.cells.size)
            force[inside] = solution.force[slot]
            gap = start.overlap + solution.shift
            others = np.flatnonzero(~inside & (gap > 0.0))
            gap[others] -= recent.displacement_at(start.cells[others], solution.force)
            gap[inside] -= solution.interaction[slot]
            solution = solution._replace(force=force, newton_steps=0, products=0)
            missed = others[gap[others] > 0.0]
            if not missed.size:
                break
            inside[missed] = True
        newton_steps += solution.newton_steps
        products += solution.products
        return solution._replace(newton_steps=newton_steps, products=products), gap


def elastic_curve(joint: Joint, targets: np.ndarray) -> list[Settled]:
    """Return the states of an elastic joint at total forces (t,) [N], each by one solution.

    The list ends with the first state that did not converge. The forces of the joint, but not its
    interaction, are changed to those of the last state.
    """
    candidates = _Candidates(joint, _closure_of_overlaps(joint, _FIRST_CANDIDATES))
    solved: list[_Point] = []
    settled = []
    for target in targets:
        while True:
            guess = _starting_point(solved, target, candidates.contacts, joint.upper.size)
            solution, gap = candidates.solve(guess, target)
            if not solution.shift > candidates.reach or not np.isfinite(solution.shift):
                break
            candidates = _Candidates(joint, 1.3 * solution.shift)
        force, gaps = _open_state(joint.upper.size)
        point = _Point(force, gaps, solution.field, solution.shift, target)
        point.force[candidates.contacts.cells] = solution.force
        point.gap[candidates.contacts.cells] = gap
        solved = [*solved[-1:], point]
        joint.force[:] = point.force.reshape(joint.force.shape)
        settled.append(_described_solution(joint, candidates, solution))
        if settled[-1].outcome != Outcome.CONVERGED:
            break
    return settled


def _open_state(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return forces (n,) [N] of 0 and gaps (n,) [m] of NaN, as of cells that are not in contact."""
    return np.zeros(size), np.full(size, np.nan)


def _closure_of_overlaps(joint: Joint, count: int) -> float:
    """Return a closure [m] at which at least ``count`` cells overlap, or all if there are fewer."""
    summed = (joint.upper + joint.lower).ravel()
    rank = max(summed.size - count, 0)
    reach = joint.first_touch - float(np.partition(summed, rank)[rank])
    return reach + 4.0 * float(np.spacing(abs(joint.first_touch)))


def _starting_point(solved: list[_Point], target: float, contacts: Contacts, size: int) -> _Point:
    """Return a guess of the state of an elastic joint at a total force ``target`` [N].

    It is extrapolated linearly from the last two solved states. After a single one its forces are
    scaled by the ratio of the total forces, and its closure by the root of this ratio. Before the
    first one, it is the solution without interaction, for the candidates ``contacts`` in a grid of
    ``size`` cells.
    """
    if not solved:
        force, gap = _open_state(size)
        closure = separate_shift(contacts, target)
        alone = separate_equilibrium(contacts, closure)
        force[contacts.cells] = np.nan_to_num(alone, posinf=target)
        return _Point(force, gap, _UNKNOWN, closure, target)
    last = solved[-1]
    if len(solved) == 1:
        share = target / last.target
        closure = last.closure * share**0.5
        return _Point(last.force * share, last.gap, last.field * share, closure, target)
    before = solved[0]
    ahead = (target - last.target) / (last.target - before.target)
    force = last.force + ahead * (last.force - before.force)
    gap = last.gap + ahead * (last.gap - before.gap)
    closure = last.closure + ahead * (last.closure - before.closure)
    both = last.field.shape == before.field.shape
    field = last.field + ahead * (last.field - before.field) if both else _UNKNOWN
    return _Point(force, gap, field, closure, target)


def _described_solution(joint: Joint, candidates: _Candidates, solution: Equilibrium) -> Settled:
    """Return an equilibrium of the candidates as a state at rest, like `Joint.describe`.

    Its mean overlap is NaN if a contact is rigid, which has an infinite force.
    """
    total = float(solution.force.sum())
    outcome = (
        Outcome.CONVERGED if solution.residual <= candidates.tolerance else Outcome.NOT_CONVERGED
    )
    if solution.residual == np.inf:
        outcome = Outcome.RIGID_CONTACT
    flat = joint.force_on_flats(candidates.curvature, solution.force)
    contacts = candidates.contacts
    force = solution.force
    overlap = np.full(force.size, np.nan)  # unknown where a rigid contact has an infinite force
    if outcome != Outcome.RIGID_CONTACT:
        overlap = contacts.substrate * force + contacts.compliance * np.cbrt(force) ** 2
    return Settled(
        outcome=outcome,
        closure=solution.shift,
        total_force=total,
        least_force=float(solution.force.min()),
        contacts=int(np.count_nonzero(solution.force)),
        mean_interaction=joint.mean_interaction(),
        mean_overlap=float(overlap.sum()) / joint.upper.size,
        residual=solution.residual,
        locked_contacts=0,
        locked_share=0.0,
        flat_share=flat / total if total > 0.0 else 0.0,
        effort=Effort(1, 1, solution.newton_steps, solution.products),
    )
