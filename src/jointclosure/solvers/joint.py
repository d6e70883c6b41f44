"""State of a joint, and the interface of solvers."""

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
"""Curvature times spacing [1] up to which a contact counts as flat. With cells of a tenth of a
millimetre, rounding of heights of some millimetres leaves up to 1e-7; the flattest grain of rock
has 1e-3."""

_LEAST_DROP = float(np.finfo(float).tiny)
"""Least tie tolerance [m], because that of walls with denormal heights rounds to 0."""
CRUSHED = 4
"""Summand of the state of a pair whose rock was crushed, see `ContactLaw`."""


class Outcome(IntEnum):
    """Outcomes of `Solver.settle`; `jointclosure.joint.status.STATUSES` has their remedies."""

    CONVERGED = 0
    """Forces are in equilibrium, and every contact holds or is locked."""
    NOT_CONVERGED = 1
    """Forces did not reach equilibrium within the tolerance."""
    NOT_AT_REST = 2
    """Breakage continued beyond the largest number of steps."""
    RIGID_CONTACT = 3
    """A flat contact without substrate overlaps, whose force is infinite."""


_SPACE_LASTS = 0.5
"""Relative change of the number of contacts up to which the coarse space is kept: it speeds up the
solution, and changes no result but by rounding."""
_RATES = 2
"""Number of fields of a snapshot that are rates; they come last."""


class Effort(NamedTuple):
    """Effort of settling a joint, in counts that do not depend on the machine.

    ``settled`` counts closures at which the joint was brought to rest, ``rounds`` equilibria solved
    on the way, one after each breakage, and ``products`` those with the interaction (both are
    sweeps in the reference solver). ``breakage_steps`` counts how often a pair was lowered.
    """

    settled: int = 0
    rounds: int = 0
    newton_steps: int = 0
    products: int = 0
    breakage_steps: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """Return the sum of both efforts."""
        return Effort(*(count + more for count, more in zip(self, other, strict=True)))


class Settled(NamedTuple):
    """State reached by `Solver.settle`, at rest if the outcome is `Outcome.CONVERGED`.

    Lengths are in m, forces in N. ``locked_share`` is the share of the force on locked contacts,
    beyond their strength and without lower neighbours for their gouge; ``flat_share`` that on other
    contacts without curvature (`FLATTEST`). ``mean_overlap`` is the sum of the overlaps of contacts
    over the number of cells. With resolved breakage, ``correction`` [N] is how far the total force
    at rest differs from that of the first equilibrium, which follows the short steps. It measures
    the error of the step.
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
    """Two walls, their material, and the forces between them.

    ``upper`` and ``lower`` are heights (y, x) [m], ``rock`` is (upper, lower). ``pristine`` are the
    walls before any loading, if the given ones are not.
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
        self.interaction_acts = effects.interaction  # False while it is left out
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
        self.held_to = -math.inf  # closure [m] up to which nothing is known to break
        # rates per closure [1, N/m] between the last two states
        self.interaction_rate, self.force_rate = np.zeros((2, *self.upper.shape))
        self.coarse_space = NO_COARSE_SPACE  # of the last equilibrium
        self._space_contacts = 0  # number of contacts when it was made

    @cached_property
    def influence_table(self) -> np.ndarray:
        """Influence (ny, nx) [m/N] by distance in cells, see `Influence`."""
        law = self.law
        return influence_table(
            *self.upper.shape, law.base_radius, law.substrate_modulus, law.spacing
        )

    @cached_property
    def breakage_space(self) -> WorkSpace:
        """Work space of breakage."""
        return work_space(self.upper.shape, self.numerics.breakage == "resolved")

    @property
    def influence(self) -> Influence | None:
        """Interaction as a convolution, None if it does not act."""
        return self._influence if self.interaction_acts else None

    @cached_property
    def _influence(self) -> Influence:
        return influence_of(self.influence_table)

    @property
    def area(self) -> float:
        """Area of the joint [m^2]."""
        return self.upper.size * self.law.spacing**2

    def weaken_crushed(self) -> bool:
        """Mark pairs with a cell below its pristine height as crushed; return whether any is new.

        Nothing is marked unless crushed rock is weaker (`Choices.crushed_strength_ratio`).
        """
        if not self.pristine:
            return False
        walls = zip((self.upper, self.lower), self.pristine, strict=True)
        lost = [pristine - wall > self.tie_tolerance for wall, pristine in walls]
        new = (lost[0] | lost[1]) & (self.peaks < CRUSHED)
        self.peaks[new] += CRUSHED
        return bool(new.any())

    def resume_interaction(self) -> None:
        """Switch the interaction on, starting from that of the present forces."""
        self.interaction_acts = self.effects.interaction
        self.interaction[:] = interaction_field(self._influence, self.force)

    def interaction_left_out(self) -> float:
        """Return the largest displacement [m] of a contact by the interaction of present forces."""
        field = interaction_field(self._influence, self.force)
        return float(field[self.force > 0.0].max(initial=0.0))

    @cached_property
    def recent_contacts(self) -> RecentContacts:
        """Cells that overlapped recently, and their influence on each other."""
        return RecentContacts(self.influence_table)

    @cached_property
    def _mean_displacement(self) -> np.ndarray:
        return mean_displacement(self.influence_table)

    @property
    def last_touch(self) -> float:
        """Return the closure at which the present walls just touch [m], without any overlap."""
        highest = float((self.upper + self.lower).max())
        closure = self.first_touch - highest
        while highest + (closure - self.first_touch) > 0.0:  # due to rounding
            closure = math.nextafter(closure, -math.inf)
        return closure

    def snapshot(self) -> tuple[np.ndarray, ...]:
        """Return copies of the whole state, for `restore`."""
        return tuple(field.copy() for field in self._state())

    def restore(self, snapshot: tuple[np.ndarray, ...], *, rates: bool = True) -> None:
        """Restore a snapshot of the state, which stays valid.

        The state is walls, peaks, forces, interaction and closure. With ``rates`` the rates of
        interaction and force per closure are restored too.
        """
        kept = None if rates else -_RATES
        for field, saved in zip(self._state()[:kept], snapshot[:kept], strict=True):
            field[...] = saved

    def _state(self) -> tuple[np.ndarray, ...]:
        fields = (self.upper, self.lower, self.peaks, self.force, self.interaction)
        return (*fields, self.closure, self.interaction_rate, self.force_rate)

    def overlapping(self, closure: float):
        """Return `overlapping_cells` at a closure [m]; current peaks are updated before."""
        if self.choices.peaks == "current":
            self.peaks[:] = peak_map(self.upper, self.lower)
        return overlapping_cells(
            self.upper, self.lower, closure - self.first_touch, self.peaks, self.law
        )

    def contacts(self, cells, overlap, compliance) -> Contacts:
        """Return elastic contacts of these cells, without a limit of their forces."""
        return unlimited(cells, overlap, compliance, self.law.substrate)

    def with_matrix(self, contacts: Contacts) -> tuple[Contacts, np.ndarray | None]:
        """Return contacts with the cells that overlapped recently, and their influence matrix.

        New contacts are added to `recent_contacts`. The matrix (m, m) [m/N] is filled in the first
        n rows and columns, one for each of the n returned contacts, and a later call fills the same
        array. Cells that are not in contact have a negative overlap. Without interaction, or for so
        many contacts that a convolution is cheaper, the same contacts and None are returned.
        """
        if self.influence is None or contacts.cells.size > dense_limit(self.upper.shape):
            return contacts, None
        near = self.recent_contacts
        slot = near.slots(contacts.cells)
        return contacts_among(contacts, slot, near.cells), near.matrix

    def space_for(self, contacts: int) -> CoarseSpace:
        """Return the coarse space, without patches if the number of contacts has changed a lot."""
        made_with = self._space_contacts
        if abs(contacts - made_with) > _SPACE_LASTS * made_with:
            self.coarse_space = NO_COARSE_SPACE
            self._space_contacts = contacts
        return self.coarse_space

    def mean_interaction(self) -> float:
        """Return the bulk indentation [m]: mean displacement of all cells by the interaction."""
        if not self.interaction_acts:
            return 0.0
        return float(np.sum(self._mean_displacement * self.force))

    def force_on_flats(self, curvature: np.ndarray, force: np.ndarray) -> float:
        """Return the force [N] on flat contacts (n,), with a curvature [1/m] up to `FLATTEST`."""
        return float(force[curvature * self.law.spacing < FLATTEST].sum())

    def describe(
        self,
        closure: float,
        outcome: Outcome,
        locked: np.ndarray,
        effort: Effort,
        overlapping: tuple | None = None,
    ) -> Settled:
        """Return the present state; ``locked`` (y, x) are the locked pairs.

        ``overlapping`` is the result of `overlapping`, if it is known. The joint's interaction
        becomes that of its forces, by a product in double precision.
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
    [N], without steps. ``predict(joint, closure, residual)`` returns the total force [N] at a
    closure [m] before anything breaks, and the effort; walls and forces stay as they are. Either is
    None if a solver does not have it.
    """

    @property
    def elastic_curve(self) -> Callable[["Joint", np.ndarray], list[Settled]] | None:
        """Function that solves an elastic curve, or None, see `Solver`."""

    @property
    def predict(self) -> Callable[["Joint", float, float], tuple[float, Effort]] | None:
        """Function that predicts a force, or None, see `Solver`."""

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Change the joint's walls and forces so that it rests at the closure [m].

        Fixed steps of breakage are ``breakage_step`` [m].
        """


def roughness(upper: np.ndarray, lower: np.ndarray) -> float:
    """Compute the root mean square height of both walls about their means [m]."""
    return float(np.sqrt(0.5 * (np.var(upper) + np.var(lower))))
