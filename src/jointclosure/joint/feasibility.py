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
"""Breakage steps over the number of cells needed to crush a rock to powder with resolved breakage.
Measured: 1.3e9 steps on 20 x 20 cells of dolerite at 3 MPa with a largest radius of 1 mm, in 93 s;
6e3 steps with 1.5 mm."""
_ELASTIC_STEPS = 10.0
"""Steps of an elastic history over `Numerics.most_steps`: they are cheap."""


class Strength(NamedTuple):
    """Largest loads that an intact joint carries if no cell is locked; infinite if unbounded.

    ``of_cell`` is the largest force [N] of a cell, ``of_joint`` the stress [Pa] that all cells
    carry together, which is a bound only if rock breaks with gouge.
    """

    of_cell: float = math.inf
    of_joint: float = math.inf


def joint_strength(joint: Joint) -> Strength:
    """Compute the strength of all cells of an intact joint."""
    if not joint.effects.breakage:
        return Strength()
    forces = _cell_strengths(joint.law, joint.numerics.tolerance)[joint.peaks]
    if not np.isfinite(forces).all():
        return Strength()
    together = float(forces.sum()) / joint.area
    return Strength(float(forces.max()), together if joint.effects.gouge else math.inf)


def _cell_strengths(law: ContactLaw, tolerance: float) -> np.ndarray:
    """Return the largest force (8,) [N] of a cell by the state of the pair; infinite if unbounded.

    A pair may exceed its strength by half the band, its force by as much to the power of 3/2.
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
    """Raise `InputError` for a stress [Pa] above the `largest_stress` of the rocks."""
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

    It is infinite if there is none. All cells count as the strongest kind, which with the largest
    radius alone are soft peaks: `check_feasible` knows the cells, and also refuses smaller
    stresses. Without a spacing [m] that radius is not a bound.
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
    """Return whether a simulation does not end where all cells together carry too little."""
    return numerics.breakage == "resolved" and numerics.most_breakage_steps < _CRUSHING


def check_feasible(joint: Joint, strength: Strength, max_normal_stress: float, cycles: int) -> None:
    """Raise `InputError` for a simulation that would take too many steps.

    It needs more displacement steps than `Numerics` allows, or a stress [Pa] above the strength of
    all cells together with resolved breakage, which does not end beyond it. Fixed steps of breakage
    end by their number.
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
    """Raise `InputError` if all cells ``together`` carry less than the stress, both [Pa]."""
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
    """Raise `InputError` if an elastic history of some ``cycles`` has too many steps.

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
    """Estimate the displacement steps of a history and the closure of its first loading [m].

    The closure is the elastic one, or `crushed_closure` if that is larger. Later branches count as
    elastic.
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
    """Return a closure [m] below which too few cells touch to carry the force ``target`` [N].

    At least n = target / strongest cells are needed, where ``strongest`` is the force [N] of the
    strongest cell. Heights are sums of both walls: gouge cannot raise n cells above the mean of the
    n highest. The closure is 0 if the strength of a cell is not bounded.
    """
    if not math.isfinite(strongest):
        return 0.0
    summed = (joint.upper + joint.lower).ravel()
    count = min(math.ceil(target / strongest), summed.size)
    highest = np.partition(summed, summed.size - count)[summed.size - count :]
    return joint.first_touch - float(highest.mean())
