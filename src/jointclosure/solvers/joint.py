"""State of a joint, and the functions that a solver has: settling, elastic curve, prediction."""

import math
from collections.abc import Callable
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from jointclosure.mechanics.contact_law import ContactLaw, contact_law
from jointclosure.parameters import Choices, Effects, Numerics
from jointclosure.solvers.breakage import WorkSpace, work_space
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.conjugate_gradients import NO_COARSE_SPACE, CoarseSpace
from jointclosure.solvers.contacts import (
    Contacts,
    contacts_among,
    separate_equilibrium,
    unlimited,
)
from jointclosure.solvers.interaction_operator import (
    Influence,
    RecentContacts,
    dense_limit,
    influence_of,
    influence_table,
    interaction_field,
    mean_displacement,
)

FLATTEST = 1e-6
"""Curvature times spacing [1] below which a contact counts as flat. With cells of a tenth of a
millimetre, rounding of heights of some millimetres leaves up to 1e-7; the flattest grain of rock
has 1e-3."""

_LEAST_DROP = float(np.finfo(float).tiny)
"""Least tie tolerance [m]: the usual one of walls with denormal heights would round to 0."""
CRUSHED = 4
"""Summand of the state of a pair whose rock was crushed, see `ContactLaw`."""


class Outcome(IntEnum):
    """Outcomes of `Solver.settle`; `jointclosure.joint.status.STATUSES` has their remedies."""

    CONVERGED = 0
    """Forces are in equilibrium, and every contact holds or is locked."""
    NOT_CONVERGED = 1
    """Forces did not reach equilibrium within the tolerance."""
    NOT_AT_REST = 2
    """Breakage continued beyond the largest number of breakage steps, or of rounds."""
    RIGID_CONTACT = 3
    """A flat contact overlaps without a substrate: its force is infinite."""


_SPACE_LASTS = 0.5
"""Relative change of the number of contacts up to which the coarse space is kept: it speeds up the
solution, and changes no result but by rounding."""
_RATES = 2
"""Number of fields of a snapshot that are rates; they come last."""


class Effort(NamedTuple):
    """Effort of settling a joint, in counts that do not depend on the machine.

    ``settled`` counts the closures at which the joint was brought to rest, ``rounds`` the
    equilibria that were solved on the way, one after each breakage, ``newton_steps`` the steps of
    Newton's method in them, and ``products`` the products of forces with the influence. In the
    reference solver both ``rounds`` and ``products`` are the number of sweeps. ``breakage_steps``
    counts how often a pair of cells was lowered.
    """

    settled: int = 0
    rounds: int = 0
    newton_steps: int = 0
    products: int = 0
    breakage_steps: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """Return the sum of this effort and another one, count by count."""
        return Effort(*(count + more for count, more in zip(self, other, strict=True)))


class Settled(NamedTuple):
    """State of a joint reached by `Solver.settle`, at rest if its outcome is CONVERGED.

    Lengths are in m, forces in N. ``contacts`` is the number of cells that carry force, and
    ``mean_interaction`` the bulk indentation (`Joint.mean_interaction`). ``mean_overlap`` is the
    sum of the overlaps of contacts over the number of cells. ``residual`` is the sum over the
    contacts of |force that the overlap takes - force|, over the sum of the forces. A *locked*
    contact is beyond its strength, but cannot break, because no neighbour on either wall is lower
    and can receive its gouge. ``locked_share`` is the share of the total force on locked contacts,
    and ``flat_share`` the share on contacts that are flat (`FLATTEST`) and not locked.

    With resolved breakage, ``correction`` [N] is the difference between the total force at rest and
    the total force of the first equilibrium, which is solved after the short steps of breakage. It
    measures the error of the step.
    """

    outcome: Outcome
    closure: float
    total_force: float
    least_force: float
    contacts: int
    mean_interaction: float
    mean_overlap: float
    residual: float
    locked_contacts: int
    locked_share: float
    flat_share: float
    effort: Effort
    correction: float = 0.0


class Joint:
    """Two walls, their rock, and the present forces between them.

    ``upper`` and ``lower`` are heights (y, x) [m], of which copies are taken; ``rock`` is a pair
    for (upper, lower). ``pristine`` are the walls before any loading; by default the given walls
    are pristine. Solvers change the walls, forces and interaction of the joint.
    """

    def __init__(
        self,
        upper: np.ndarray,
        lower: np.ndarray,
        spacing: float,
        rock: tuple,
        effects: Effects,
        choices: Choices,
        numerics: Numerics,
        pristine: tuple[np.ndarray, np.ndarray] | None = None,
    ):
        self.upper = np.array(upper, dtype=np.float64, order="C")
        self.lower = np.array(lower, dtype=np.float64, order="C")
        self.effects = effects
        self.choices = choices
        self.numerics = numerics
        self.interaction_acts = effects.interaction  # False while the interaction is left out
        self.law: ContactLaw = contact_law(spacing, rock, effects, choices)
        self.compressive_strength = min(wall.compressive_strength for wall in rock)  # [Pa]
        self.first_touch = float((self.upper + self.lower).max())
        tie = choices.tie_tolerance * roughness(self.upper, self.lower)
        self.tie_tolerance = max(tie, _LEAST_DROP)
        intact = pristine or (self.upper, self.lower)
        self.peaks = peak_map(*intact)
        weakens = choices.crushed_strength_ratio < 1.0
        self.pristine = tuple(wall.copy() for wall in intact) if weakens else ()
        self.weaken_crushed()
        self.force = np.zeros(self.upper.shape)
        self.interaction = np.zeros(self.upper.shape)
        self.closure = np.zeros(())  # of the last settled state
        self.held_to = -math.inf  # closure [m] up to which nothing breaks; -infinity: not known
        # rates per closure [1, N/m] between the last two states
        self.interaction_rate, self.force_rate = np.zeros((2, *self.upper.shape))
        self.coarse_space = NO_COARSE_SPACE  # of the last equilibrium
        self._space_contacts = 0  # number of contacts when it was made

    @cached_property
    def influence_table(self) -> np.ndarray:
        """Influence of a cell of the joint (ny, nx) [m/N] by distance in cells, see `Influence`."""
        law = self.law
        return influence_table(
            *self.upper.shape, law.base_radius, law.substrate_modulus, law.spacing
        )

    @cached_property
    def breakage_space(self) -> WorkSpace:
        """Work space of the breakage kernel, kept from call to call."""
        return work_space(self.upper.shape, self.numerics.breakage == "resolved")

    @property
    def influence(self) -> Influence | None:
        """Interaction as a convolution, None while the interaction is left out."""
        return self._influence if self.interaction_acts else None

    @cached_property
    def _influence(self) -> Influence:
        return influence_of(self.influence_table)

    @property
    def area(self) -> float:
        """Nominal area of the joint [m2]."""
        return self.upper.size * self.law.spacing**2

    def weaken_crushed(self) -> bool:
        """Mark pairs of cells as crushed where a wall is below its pristine height.

        A wall is below if it is so by more than the tie tolerance. The mark is in the states of the
        pairs, `peaks`. Return whether any pair is new. Nothing is marked unless crushed rock is
        weaker (`Choices.crushed_strength_ratio`).
        """
        if not self.pristine:
            return False
        walls = zip((self.upper, self.lower), self.pristine, strict=True)
        lost = [pristine - wall > self.tie_tolerance for wall, pristine in walls]
        new = (lost[0] | lost[1]) & (self.peaks < CRUSHED)
        self.peaks[new] += CRUSHED
        return bool(new.any())

    def resume_interaction(self) -> None:
        """Let the interaction of the joint act again, and set it to that of the present forces.

        It does not act if the effects leave it out.
        """
        self.interaction_acts = self.effects.interaction
        self.interaction[:] = interaction_field(self._influence, self.force)

    def interaction_left_out(self) -> float:
        """Return the largest displacement [m] of a contact that the interaction would cause now.

        It is computed from the present forces, whether the interaction acts or not; 0 without
        contacts.
        """
        field = interaction_field(self._influence, self.force)
        return float(field[self.force > 0.0].max(initial=0.0))

    @cached_property
    def recent_contacts(self) -> RecentContacts:
        """Cells of the joint that overlapped recently, and their influence on each other."""
        return RecentContacts(self.influence_table)

    @cached_property
    def _mean_displacement(self) -> np.ndarray:
        return mean_displacement(self.influence_table)

    @property
    def last_touch(self) -> float:
        """Largest closure [m] at which no cells of the present walls overlap."""
        highest = float((self.upper + self.lower).max())
        closure = self.first_touch - highest
        while highest + (closure - self.first_touch) > 0.0:  # due to rounding
            closure = math.nextafter(closure, -math.inf)
        return closure

    def snapshot(self) -> tuple[np.ndarray, ...]:
        """Return copies of the whole state of the joint, for `restore`."""
        return tuple(field.copy() for field in self._state())

    def restore(self, snapshot: tuple[np.ndarray, ...], *, rates: bool = True) -> None:
        """Restore the state of the joint from a snapshot, which can be used again.

        The state is walls, states of the pairs (`peaks`), forces, interaction and closure. With
        ``rates`` the rates of interaction and force per closure are restored too, otherwise they
        stay.
        """
        kept = None if rates else -_RATES
        for field, saved in zip(self._state()[:kept], snapshot[:kept], strict=True):
            field[...] = saved

    def _state(self) -> tuple[np.ndarray, ...]:
        fields = (self.upper, self.lower, self.peaks, self.force, self.interaction)
        return (*fields, self.closure, self.interaction_rate, self.force_rate)

    def overlapping(self, closure: float):
        """Return the `overlapping_cells` of the present walls at a closure [m].

        If the choice of peaks is "current", the states of the pairs (`peaks`) are updated before.
        """
        if self.choices.peaks == "current":
            self.peaks[:] = peak_map(self.upper, self.lower)
        return overlapping_cells(
            self.upper, self.lower, closure - self.first_touch, self.peaks, self.law
        )

    def contacts(self, cells, overlap, compliance) -> Contacts:
        """Return elastic contacts at cells (n,), whose forces have no limit."""
        return unlimited(cells, overlap, compliance, self.law.substrate)

    def with_matrix(self, contacts: Contacts) -> tuple[Contacts, np.ndarray | None]:
        """Return contacts with the cells that overlapped recently, and their influence matrix.

        New contacts are added to `recent_contacts`. The matrix (m, m) [m/N] is filled in the first
        n rows and columns, one for each of the n returned contacts, and a later call overwrites the
        same array. Cells that are not in contact have a negative overlap. If there is no
        interaction, or are so many contacts that a convolution is cheaper, the given contacts and
        None are returned.
        """
        if self.influence is None or contacts.cells.size > dense_limit(self.upper.shape):
            return contacts, None
        near = self.recent_contacts
        slot = near.slots(contacts.cells)
        return contacts_among(contacts, slot, near.cells), near.matrix

    def space_for(self, contacts: int) -> CoarseSpace:
        """Return the preconditioner of the last equilibrium, for a number of contacts.

        If the number has changed by more than half since it was made, a `NO_COARSE_SPACE` takes its
        place, and the next solution makes a new one.
        """
        made_with = self._space_contacts
        if abs(contacts - made_with) > _SPACE_LASTS * made_with:
            self.coarse_space = NO_COARSE_SPACE
            self._space_contacts = contacts
        return self.coarse_space

    def mean_interaction(self) -> float:
        """Return the bulk indentation [m]: the mean displacement of all cells by the interaction.

        It is computed from the present forces, and is 0 while the interaction is left out.
        """
        if not self.interaction_acts:
            return 0.0
        return float(np.sum(self._mean_displacement * self.force))

    def force_on_flats(self, curvature: np.ndarray, force: np.ndarray) -> float:
        """Return the sum of forces (n,) [N] on the contacts that are flat (`FLATTEST`).

        ``curvature`` (n,) [1/m] is that of the contacts.
        """
        return float(force[curvature * self.law.spacing < FLATTEST].sum())

    def describe(
        self,
        closure: float,
        outcome: Outcome,
        locked: np.ndarray,
        effort: Effort,
        overlapping: tuple | None = None,
    ) -> Settled:
        """Return the present state of the joint at a closure [m], with its residual computed anew.

        ``locked`` (y, x) is a mask of the locked pairs. ``overlapping`` is the result of
        `overlapping` at this closure, if the caller has it. If the interaction acts and the forces
        are finite and not all 0, the joint's interaction is set to that of its forces, by a product
        in double precision.
        """
        total = float(self.force.sum())
        share = 1.0 / total if total > 0.0 else 0.0
        rigid = not np.isfinite(total)
        if overlapping is None:
            overlapping = self.overlapping(closure)
        cells, overlap, curvature, compliance = overlapping
        force = self.force.ravel()[cells]
        if self.interaction_acts and total > 0.0 and not rigid:
            self.interaction[:] = interaction_field(self.influence, self.force)
            overlap = overlap - self.interaction.ravel()[cells]
        answer = separate_equilibrium(self.contacts(cells, overlap, compliance), 0.0)
        free = ~locked.ravel()[cells]
        misfit = np.inf if rigid else share * float(np.abs(answer - force).sum())
        return Settled(
            outcome=outcome,
            closure=closure,
            total_force=total,
            least_force=float(self.force.min()),
            contacts=int(np.count_nonzero(self.force)),
            mean_interaction=self.mean_interaction(),
            mean_overlap=float(np.maximum(overlap, 0.0).sum()) / self.upper.size,
            residual=misfit,
            locked_contacts=int(np.count_nonzero(locked & (self.force > 0.0))),
            locked_share=share * float(self.force[locked].sum()),
            flat_share=share * self.force_on_flats(curvature[free], force[free]),
            effort=effort,
        )


class Solver(Protocol):
    """Interface of solvers, which bring a joint to rest at a closure from any state.

    ``elastic_curve(joint, targets)`` returns the states of an elastic joint at total forces (t,)
    [N], without displacement steps. ``predict(joint, closure, residual)`` returns the total force
    [N] at a closure [m] before anything breaks, and the effort; walls and forces stay as they are.
    A solver without one of these two functions has None in its place.
    """

    @property
    def elastic_curve(self) -> Callable[["Joint", np.ndarray], list[Settled]] | None:
        """Function of a solver for elastic joints at total forces; None if the solver has none."""

    @property
    def predict(self) -> Callable[["Joint", float, float], tuple[float, Effort]] | None:
        """Function of a solver that predicts the total force at a closure; None if it has none."""

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m], in place, and return the state reached.

        Its walls, forces and interaction are changed. Fixed steps of breakage lower a pair of cells
        by ``breakage_step`` [m].
        """


def roughness(upper: np.ndarray, lower: np.ndarray) -> float:
    """Compute the root mean square height [m] of both walls together, each about its mean."""
    return float(np.sqrt(0.5 * (np.var(upper) + np.var(lower))))
