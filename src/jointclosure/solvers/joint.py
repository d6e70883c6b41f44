"""The state of a joint, and what a solver makes of it at one closure."""

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from jointclosure.mechanics.contact_law import ContactLaw, contact_law
from jointclosure.parameters import Choices, Effects, Numerics, strength_of
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts, separate_equilibrium
from jointclosure.solvers.interaction_operator import (
    Influence,
    Neighbours,
    dense_limit,
    influence_of,
    influence_table,
    interaction_field,
    mean_displacement,
)

FLATTEST = 1e-6
"""Curvature times spacing [1] below which a contact counts as flat. Rounding of heights some
millimetres about cells of a tenth leaves up to 1e-7; the flattest grain of rock has 1e-3."""

CONVERGED, NOT_CONVERGED, NOT_AT_REST, RIGID_CONTACT = range(4)
"""Outcomes of `Solver.settle`."""


_RATES = 2
"""How many fields of a snapshot are rates; they are its last."""


class Effort(NamedTuple):
    """What settling took, in counts that do not depend on the machine.

    ``settled`` states, those thrown away included; ``rounds``, equilibria solved, as each
    time after breakage; ``newton_steps``; ``products`` with the interaction (the reference:
    sweeps); ``breakage_steps``, one pair lowered once.
    """

    settled: int = 0
    rounds: int = 0
    newton_steps: int = 0
    products: int = 0
    breakage_steps: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """Both efforts together."""
        return Effort(*(own + more for own, more in zip(self, other, strict=True)))


class Settled(NamedTuple):
    """A joint at rest: in equilibrium, every contact held or locked.

    Shares are those of the total force on locked contacts (beyond their
    strength, with nowhere to put their gouge) and on flat ones (no curvature,
    or what rounding leaves of none, so that Eq. (22) gives next to no stress).
    ``correction`` [N] is by how much the total force missed what was predicted
    before anything broke (resolved breakage): the measure of a step's error.
    """

    outcome: int
    closure: float
    total_force: float
    least_force: float
    contacts: int
    mean_interaction: float
    residual: float
    locked_contacts: int
    locked_share: float
    flat_share: float
    effort: Effort
    correction: float = 0.0


class Joint:
    """Two walls, what they are made of, and the forces between them.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m]; copied.
    spacing : float
        Grid spacing [m].
    rock : (upper, lower) of Rock
    effects, choices, numerics
        Checked by the caller.
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
    ):
        self.upper = np.array(upper, dtype=np.float64, order="C")
        self.lower = np.array(lower, dtype=np.float64, order="C")
        self.effects, self.choices, self.numerics = effects, choices, numerics
        self.interaction_acts = effects.interaction  # False while it is left out
        self.law: ContactLaw = contact_law(spacing, rock, effects, choices)
        self.compressive_strength = min(map(strength_of, rock))  # [Pa]
        self.first_touch = float((self.upper + self.lower).max())
        self.tie_tolerance = choices.tie_tolerance * roughness(self.upper, self.lower)
        self.peaks = peak_map(self.upper, self.lower)
        self.force = np.zeros(self.upper.shape)
        self.interaction = np.zeros(self.upper.shape)
        self.closure = np.zeros(())  # at which it was last settled
        self.held_to = -math.inf  # closure [m] up to which it is known that nothing breaks
        # per closure, since the last but one
        self.interaction_rate, self.force_rate = np.zeros((2, *self.upper.shape))

    @cached_property
    def influence_table(self) -> np.ndarray:
        """Influence (ny, nx) [m/N] by distance in cells, see `Influence`."""
        law = self.law
        return influence_table(
            *self.upper.shape, law.base_radius, law.substrate_modulus, law.spacing
        )

    @property
    def influence(self) -> Influence | None:
        """The interaction as a convolution; None where it does not act."""
        return self._influence if self.interaction_acts else None

    @cached_property
    def _influence(self) -> Influence:
        return influence_of(self.influence_table)

    def resume_interaction(self) -> None:
        """Have the interaction act again: at first, that of the present forces."""
        self.interaction_acts = self.effects.interaction
        self.interaction[:] = interaction_field(self._influence, self.force)

    def interaction_left_out(self) -> float:
        """Largest displacement [m] of a contact by the interaction of the present forces.

        While the interaction is left out this is a bound of what it would be on these walls at this
        closure: it moves contacts apart, so that with it each carries less, and displaces the
        others less.
        """
        field = interaction_field(self._influence, self.force)
        return float(field[self.force > 0.0].max(initial=0.0))

    @cached_property
    def neighbours(self) -> Neighbours:
        """Cells that overlapped lately, and their influence on each other."""
        return Neighbours(self.influence_table)

    @cached_property
    def _mean_displacement(self) -> np.ndarray:
        return mean_displacement(self.influence_table)

    @property
    def last_touch(self) -> float:
        """Closure at which the walls as they are now only just touch [m]: nothing overlaps."""
        highest = float((self.upper + self.lower).max())
        closure = self.first_touch - highest
        while highest + (closure - self.first_touch) > 0.0:  # by a rounding
            closure = math.nextafter(closure, -math.inf)
        return closure

    def snapshot(self) -> tuple[np.ndarray, ...]:
        """Copies of all that changes, for `restore`."""
        return tuple(field.copy() for field in self._state())

    def restore(self, snapshot: tuple[np.ndarray, ...], *, rates: bool = True) -> None:
        """Go back to a snapshot, which stays valid; without ``rates`` these stay as they are."""
        kept = None if rates else -_RATES
        for field, saved in zip(self._state()[:kept], snapshot[:kept], strict=True):
            field[...] = saved

    def _state(self) -> tuple[np.ndarray, ...]:
        fields = (self.upper, self.lower, self.peaks, self.force, self.interaction)
        return (*fields, self.closure, self.interaction_rate, self.force_rate)

    def overlapping(self, closure: float):
        """Cells that overlap at a closure [m] without interaction: see `overlapping_cells`."""
        if self.choices.peaks == "current":
            self.peaks[:] = peak_map(self.upper, self.lower)
        return overlapping_cells(
            self.upper, self.lower, closure - self.first_touch, self.peaks, self.law
        )

    def contacts(self, cells, overlap, compliance) -> Contacts:
        """Elastic contacts of these cells, without a limit of their forces."""
        limit = np.full(cells.size, np.inf)
        return Contacts(cells, overlap, compliance, limit, self.law.substrate)

    def with_matrix(self, contacts: Contacts) -> tuple[Contacts, np.ndarray | None]:
        """Contacts among all `neighbours`, in their order, and the influence between these.

        Cells that are not given have an overlap that no force answers. Where a dense matrix does
        not pay, the contacts as they are and None.
        """
        if self.influence is None or contacts.cells.size > dense_limit(self.upper.shape):
            return contacts, None
        near = self.neighbours
        slot = near.slots(contacts.cells)
        n = near.cells.size
        overlap, compliance, limit = np.full(n, -1.0), np.ones(n), np.full(n, np.inf)
        overlap[slot], compliance[slot] = contacts.overlap, contacts.compliance
        limit[slot] = contacts.limit
        return Contacts(near.cells, overlap, compliance, limit, contacts.substrate), near.matrix

    def mean_interaction(self) -> float:
        """Mean displacement of all cells by the interaction: the bulk indentation [m]."""
        if not self.interaction_acts:
            return 0.0
        return float(np.sum(self._mean_displacement * self.force))

    def force_on_flats(self, curvature: np.ndarray, force: np.ndarray) -> float:
        """Force [N] on contacts (n,) that are flat: `FLATTEST` and below, by curvature [1/m]."""
        return float(force[curvature * self.law.spacing < FLATTEST].sum())

    def describe(
        self,
        closure: float,
        outcome: int,
        locked: np.ndarray,
        effort: Effort,
        overlapping: tuple | None = None,
    ) -> Settled:
        """Sum up the present state; ``locked`` is a map (y, x).

        ``overlapping`` is what `overlapping` gives of the walls as they are, where it is at hand.

        The residual is recomputed here from walls and forces alone, whatever
        the solver believes to have reached.
        """
        total = float(self.force.sum())
        share = 1.0 / total if total > 0.0 else 0.0
        rigid = not np.isfinite(total)
        if overlapping is None:
            overlapping = self.overlapping(closure)
        cells, overlap, curvature, compliance = overlapping
        force = self.force.ravel()[cells]
        if self.interaction_acts and total > 0.0 and not rigid:
            overlap = overlap - interaction_field(self.influence, self.force).ravel()[cells]
        answer = separate_equilibrium(self.contacts(cells, overlap, compliance), 0.0)
        misfit = np.inf if rigid else share * float(np.abs(answer - force).sum())
        return Settled(
            outcome=outcome,
            closure=closure,
            total_force=total,
            least_force=float(self.force.min()),
            contacts=int(np.count_nonzero(self.force)),
            mean_interaction=self.mean_interaction(),
            residual=misfit,
            locked_contacts=int(np.count_nonzero(locked & (self.force > 0.0))),
            locked_share=share * float(self.force[locked].sum()),
            flat_share=share * self.force_on_flats(curvature, force),
            effort=effort,
        )


class Solver(Protocol):
    """Brings a joint to rest at a closure, whatever its state was before.

    ``elastic_curve(joint, targets)`` closes an elastic joint to total forces
    (t,) [N] without steps, see `jointclosure.solvers.elastic`; None where a
    solver can only step. ``predict(joint, closure, residual)`` gives the total force [N]
    at a closure [m] before anything breaks there, to a relative residual, and what that took: for
    resolved breakage, None where a solver has none. It leaves the walls as they are, and other
    forces.
    """

    @property
    def elastic_curve(self) -> Callable[["Joint", np.ndarray], list[Settled]] | None:
        """See above."""

    @property
    def predict(self) -> Callable[["Joint", float, float], tuple[float, Effort]] | None:
        """See above."""

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Change the joint's walls and forces so that it rests at the closure [m]."""


def roughness(upper: np.ndarray, lower: np.ndarray) -> float:
    """Root mean square height of both walls about their means [m]."""
    return float(np.sqrt(0.5 * (np.var(upper) + np.var(lower))))
