"""The state of a joint, and what a solver makes of it at one closure."""

from typing import NamedTuple, Protocol

import numpy as np

from jointclosure.parameters import Choices, ContactLaw, Effects, Numerics, contact_law
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.equilibrium import separate_equilibrium
from jointclosure.solvers.interaction_operator import influence_of, interaction_field

CONVERGED, NOT_CONVERGED, NOT_AT_REST, RIGID_CONTACT = range(4)
"""Outcomes of `Solver.settle`."""


class Settled(NamedTuple):
    """A joint at rest: in equilibrium, every contact held or confined.

    Shares are those of the total force on confined contacts (beyond their
    strength, with nowhere to put their gouge) and on flat ones (no curvature,
    so that Eq. (22) gives no stress).
    """

    outcome: int
    closure: float
    total_force: float
    least_force: float
    contacts: int
    mean_interaction: float
    residual: float
    breakage_steps: int
    confined_contacts: int
    confined_share: float
    flat_share: float
    iterations: int


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
        self.law: ContactLaw = contact_law(spacing, rock, effects, choices)
        self.first_touch = float((self.upper + self.lower).max())
        self.tie_tolerance = choices.tie_tolerance * roughness(self.upper, self.lower)
        self.peaks = peak_map(self.upper, self.lower)
        shape = self.upper.shape
        self.influence = influence_of(shape, self.law) if effects.interaction else None
        if self.influence is not None:
            self._mean_displacement = (
                interaction_field(self.influence, np.ones(shape)) / self.upper.size
            )
        self.force = np.zeros(shape)
        self.interaction = np.zeros(shape)

    @property
    def last_touch(self) -> float:
        """Closure at which the walls as they are now only just touch [m]."""
        return self.first_touch - float((self.upper + self.lower).max())

    def snapshot(self) -> tuple[np.ndarray, ...]:
        """Copies of all that changes, for `restore`."""
        fields = (self.upper, self.lower, self.peaks, self.force, self.interaction)
        return tuple(field.copy() for field in fields)

    def restore(self, snapshot: tuple[np.ndarray, ...]) -> None:
        """Go back to a snapshot, which stays valid."""
        fields = (self.upper, self.lower, self.peaks, self.force, self.interaction)
        for field, saved in zip(fields, snapshot, strict=True):
            field[:] = saved

    def overlapping(self, closure: float):
        """Cells that overlap without interaction: see `overlapping_cells`."""
        if self.choices.peaks == "current":
            self.peaks[:] = peak_map(self.upper, self.lower)
        return overlapping_cells(
            self.upper, self.lower, closure - self.first_touch, self.peaks, self.law
        )

    def mean_interaction(self) -> float:
        """Mean displacement of all cells by the interaction: the bulk indentation [m]."""
        if self.influence is None:
            return 0.0
        return float(np.vdot(self._mean_displacement, self.force))

    def describe(
        self,
        closure: float,
        outcome: int,
        breakage_steps: int,
        confined: np.ndarray,
        iterations: int,
    ) -> Settled:
        """Sum up the present state; ``confined`` is a map (y, x).

        The residual is recomputed here from walls and forces alone, whatever
        the solver believes to have reached.
        """
        total = float(self.force.sum())
        share = 1.0 / total if total > 0.0 else 0.0
        rigid = not np.isfinite(total)
        cells, overlap, curvature, compliance = self.overlapping(closure)
        force = self.force.ravel()[cells]
        if self.influence is not None and total > 0.0 and not rigid:
            overlap = overlap - interaction_field(self.influence, self.force).ravel()[cells]
        answer = separate_equilibrium(overlap, compliance, self.law.substrate)
        misfit = np.inf if rigid else share * float(np.abs(answer - force).sum())
        return Settled(
            outcome=outcome,
            closure=closure,
            total_force=total,
            least_force=float(self.force.min()),
            contacts=int(np.count_nonzero(self.force)),
            mean_interaction=self.mean_interaction(),
            residual=misfit,
            breakage_steps=breakage_steps,
            confined_contacts=int(np.count_nonzero(confined & (self.force > 0.0))),
            confined_share=share * float(self.force[confined].sum()),
            flat_share=share * float(force[curvature == 0.0].sum()),
            iterations=iterations,
        )


class Solver(Protocol):
    """Brings a joint to rest at a closure, whatever its state was before."""

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Change the joint's walls and forces so that it rests at the closure [m]."""


def roughness(upper: np.ndarray, lower: np.ndarray) -> float:
    """Root mean square height of both walls about their means [m]."""
    return float(np.sqrt(0.5 * (np.var(upper) + np.var(lower))))
