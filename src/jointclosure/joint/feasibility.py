"""Checks before a joint is simulated: number of displacement steps, and strength of all cells."""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.joint.step_control import LARGEST_STEP
from jointclosure.mechanics.contact_law import ContactLaw, contact_law
from jointclosure.parameters import Choices, Effects, Numerics, Rock
from jointclosure.solvers.contacts import separate_shift
from jointclosure.solvers.fast import BAND
from jointclosure.solvers.joint import CRUSHED, Joint

_CRUSHING = 3e6
"""Breakage steps per cell that crush a rock to powder with resolved breakage, at most.
Measured: 1.3e9 steps on 20 x 20 cells of dolerite at 3 MPa with a largest radius of 1 mm, in 93 s;
6e3 steps with 1.5 mm."""
_ELASTIC_STEPS = 10.0
"""Largest number of steps of an elastic history over `Numerics.most_steps`: they are cheap."""


class Strength(NamedTuple):
    """Largest loads that an intact joint carries; infinite where nothing bounds them.

    ``of_cell`` is the largest force [N] of a cell. ``of_joint`` is the stress [Pa] that all cells
    carry together, which is a bound only if rock breaks with gouge. Both hold if no cell is locked:
    a locked cell is beyond its strength, but cannot break, because it has no lower neighbour on
    either wall that could receive its gouge.
    """

    of_cell: float = math.inf
    of_joint: float = math.inf


def joint_strength(joint: Joint) -> Strength:
    """Compute the strength of all cells of an intact joint.

    It is infinite without breakage, or if the strength of any cell is not bounded.
    """
    if not joint.effects.breakage:
        return Strength()
    forces = _cell_strengths(joint.law, joint.numerics.tolerance)[joint.peaks]
    if not np.isfinite(forces).all():
        return Strength()
    together = float(forces.sum()) / joint.area
    return Strength(float(forces.max()), together if joint.effects.gouge else math.inf)


def _cell_strengths(law: ContactLaw, tolerance: float) -> np.ndarray:
    """Return the largest force (8,) [N] of a cell by the state of the pair (`ContactLaw`).

    It is infinite where neither a largest radius nor the base bounds the strength. At rest a pair
    may exceed its strength: its overlap ratio by half of the band, and its force by the factor of
    the overlap to the power of 3/2.
    """
    flattest = np.maximum(2.0 * law.least_curvature, law.filling)
    beyond = (1.0 + 0.5 * BAND * tolerance) ** 1.5
    with np.errstate(divide="ignore"):
        return beyond * law.breaking_force / flattest**2


def check_strength(
    rock: tuple[Rock, Rock],
    max_normal_stress: float,
    effects: Effects,
    choices: Choices,
    numerics: Numerics,
    spacing: float | None = None,
) -> None:
    """Raise `InputError` if a stress [Pa] exceeds the `largest_stress` of two rocks (upper, lower).

    ``spacing`` [m] is that of the grid, or None if it is not known.
    """
    together = largest_stress(rock, effects, choices, numerics, spacing)
    _check_not_crushed(together, max_normal_stress, choices, numerics)


def largest_stress(
    rock: tuple[Rock, Rock],
    effects: Effects,
    choices: Choices,
    numerics: Numerics,
    spacing: float | None = None,
) -> float:
    """Return the stress [Pa] above which simulations of all walls of two rocks are refused.

    It is infinite if there is no such stress. It is what all cells carry together if each of them
    is as strong as the strongest pair of cells can be; with a largest radius alone this is a pair
    of soft peaks. `check_feasible`, which knows the cells, therefore refuses smaller stresses too.
    If the ``spacing`` [m] is None, a largest radius is not used as a bound.
    """
    if not (effects.breakage and effects.gouge and _needs_strength(numerics)):
        return math.inf
    if spacing is None:  # a bound by the base does not depend on it
        spacing = 1.0
        choices = choices._replace(largest_radius=None)
    law = contact_law(spacing, rock, effects, choices)
    strongest = float(_cell_strengths(law, numerics.tolerance)[:CRUSHED].max())
    return strongest / spacing**2


def _needs_strength(numerics: Numerics) -> bool:
    """Return whether a simulation does not end if all cells together cannot carry the stress.

    That is so with resolved breakage, unless many breakage steps are allowed (`_CRUSHING`).
    """
    return numerics.breakage == "resolved" and numerics.most_breakage_steps < _CRUSHING


def check_feasible(joint: Joint, strength: Strength, max_normal_stress: float, cycles: int) -> None:
    """Raise `InputError` for a simulation of load ``cycles`` that would take too many steps.

    It would if it needs more displacement steps than `Numerics.most_steps`. With resolved breakage
    it would also if the maximum stress [Pa] is above the stress that all cells carry together
    (``strength``), because breakage then does not end. Fixed steps of breakage end by their number.
    """
    numerics = joint.numerics
    steps, closure = displacement_steps(joint, strength, max_normal_stress, cycles)
    if steps > numerics.most_steps:
        least = numerics.displacement_step * steps / numerics.most_steps
        raise InputError(
            f"displacement_step = {numerics.displacement_step!r} m: a closure of {closure:.3g} m, "
            "without which these walls do not carry the stress, and the later branches take "
            f"{steps:.3g} steps or more, most_steps = {numerics.most_steps:g}; must be at least "
            f"{least:.3g} m, and later_displacement_step too, or most_steps larger (is the unit of "
            "the heights right?)"
        )
    _check_not_crushed(strength.of_joint, max_normal_stress, joint.choices, numerics)


def _check_not_crushed(
    together: float, max_normal_stress: float, choices: Choices, numerics: Numerics
) -> None:
    """Raise `InputError` if all cells carry ``together`` less than the maximum stress, both in Pa.

    It is raised only where the simulation would then not end (`_needs_strength`).
    """
    radius = choices.largest_radius
    crushed = together < max_normal_stress and _needs_strength(numerics)
    if crushed and choices.strength_bound == "base":
        raise InputError(
            f"max_normal_stress (--stress) = {1e-6 * max_normal_stress:g} MPa: must be less than "
            f"{1e-6 * together:.3g} MPa, which all cells together carry with strength_bound = "
            "'base' (or strength_bound, --strength-bound, must be 'none', without such a limit)"
        )
    if crushed and radius:
        least = radius * math.sqrt(max_normal_stress / together)
        raise InputError(
            f"largest_radius = {radius!r} m: with this radius all cells together carry "
            f"{together:.3g} Pa, less than max_normal_stress = {max_normal_stress:g} Pa, and "
            "resolved breakage would take practically unlimited time to crush them; must be at "
            f"least {least:.2g} m (or None, or breakage = 'fixed_step', or most_breakage_steps "
            f"at least {_CRUSHING:g})"
        )


def check_elastic_steps(numerics: Numerics, cycles: int) -> None:
    """Raise `InputError` if an elastic history of this number of cycles has too many steps.

    At most `_ELASTIC_STEPS` times `Numerics.most_steps` are allowed.
    """
    steps = 2.0 * cycles * numerics.curve_points
    if steps > _ELASTIC_STEPS * numerics.most_steps:
        raise InputError(
            f"curve_points = {numerics.curve_points}: with {cycles} cycles the history has "
            f"{steps:.3g} steps, must have at most {_ELASTIC_STEPS:g} times most_steps = "
            f"{numerics.most_steps:g}"
        )


def displacement_steps(
    joint: Joint, strength: Strength, max_normal_stress: float, cycles: int
) -> tuple[float, float]:
    """Estimate the displacement steps of a history, and the closure of its first loading [m].

    The closure is the elastic one under the maximum stress [Pa], without interaction, or
    `crushed_closure` if that is larger. Later branches count as elastic. With resolved breakage the
    steps of the first loading count as the largest ones that are allowed.
    """
    reach = float(np.ptp(joint.upper + joint.lower))
    cells, overlap, _, compliance = joint.overlapping(math.nextafter(reach, math.inf))
    contacts = joint.contacts(cells, overlap, compliance)
    target = max_normal_stress * joint.area
    closure = float(separate_shift(contacts, target)) + reach
    numerics = joint.numerics
    first = numerics.displacement_step
    if numerics.breakage == "resolved":
        first *= LARGEST_STEP
    later = (2 * cycles - 1) * closure / numerics.later_displacement_step
    closure = max(closure, crushed_closure(joint, strength.of_cell, target))
    return closure / first + later, closure


def crushed_closure(joint: Joint, strongest: float, target: float) -> float:
    """Return a closure [m] below which too few cells touch to carry a force ``target`` [N].

    At least n = target / strongest cells are needed, where ``strongest`` is the force [N] of the
    strongest cell. Gouge cannot raise n cells above the mean of the n highest, where the height of
    a cell is the sum of both walls. The closure is 0 if the strength of a cell is not bounded.
    """
    if not math.isfinite(strongest):
        return 0.0
    summed = (joint.upper + joint.lower).ravel()
    count = min(math.ceil(target / strongest), summed.size)
    highest = np.partition(summed, summed.size - count)[summed.size - count :]
    return joint.first_touch - float(highest.mean())
