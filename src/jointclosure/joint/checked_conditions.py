"""Conditions of a simulation after they were checked, with their values as simulations use them."""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

from jointclosure.inputs import InputError, check_length, check_number
from jointclosure.joint.load import Load, LoadCycle
from jointclosure.joint.rocks import ROCKS, rock_record
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
    check_crushed_strength,
    check_radius,
    check_usual,
    in_double,
)


class CheckedConditions(NamedTuple):
    """Conditions of a simulation, checked and in SI.

    They are everything that closure depends on except the walls, and whether the flow is computed.
    `jointclosure.Conditions.checked` makes them, and functions that are not public take them. After
    `_replace` with another allowed value, `check_together` checks whether all fit each other.

    Attributes
    ----------
    spacing : float or None
        Grid spacing [m] of the walls, None until scanned walls have determined it.
    rock : (Rock, Rock)
        Rock of the upper and of the lower wall.
    load : Load
        Load cycles [Pa].
    seating_stress : float
        Stress [Pa] from which closures since seating count.
    effects, choices, numerics, flow, unusual_values
        As in `jointclosure.Conditions`.
    """

    spacing: float | None
    rock: tuple[Rock, Rock]
    load: Load
    seating_stress: float
    effects: Effects
    choices: Choices
    numerics: Numerics
    flow: bool
    unusual_values: bool

    @property
    def grid_spacing(self) -> float:
        """Grid spacing [m] of the walls; raises `InputError` if it is not known yet."""
        spacing = cast(float, self.spacing)
        if spacing is None:
            check_length("spacing", spacing)
        return spacing

    @property
    def cycle_count(self) -> int:
        """Number of load cycles of the simulation."""
        return len(self.load.load_cycles)

    @property
    def largest_stress(self) -> float:
        """Largest normal stress [Pa] of all load cycles."""
        return self.load.largest

    @property
    def model(self) -> tuple[Effects, Choices, Numerics]:
        """Effects, choices and numerics of the simulation."""
        return self.effects, self.choices, self.numerics

    def attributes(self) -> dict[str, Any]:
        """Return the conditions as attributes of a dataset."""
        load = self.load.load_cycles
        repeated = load == (LoadCycle(load[0].maximum),) * len(load)
        turns = [stress for cycle in load for stress in cycle]
        return model_attributes(self.rock, self.grid_spacing, *self.model) | {
            "max_normal_stress_Pa": load[0].maximum if repeated else turns,
            "seating_stress_Pa": self.seating_stress,
        }


def check_together(conditions: CheckedConditions) -> None:
    """Raise `InputError` if conditions that are each allowed do not fit each other.

    It is called for checked conditions, and again where one of them was changed to another allowed
    value. A radius is compared with the grid spacing if this is known.
    """
    check_crushed_strength(conditions.choices)
    if conditions.spacing is not None:
        check_radius(conditions.choices, conditions.spacing)
    largest = conditions.largest_stress
    stiffness = min(wall.youngs_modulus for wall in conditions.rock)
    if largest >= stiffness:
        raise InputError(
            f"{conditions.load}: must be below the rock's youngs_modulus = "
            f"{1e-6 * stiffness:g} MPa (in Python both are in Pa)"
        )


def on_grid(checked: CheckedConditions, spacing: float) -> CheckedConditions:
    """Return checked conditions with the grid spacing [m] that the walls determine.

    A stated spacing equal to it was checked with the conditions. Raise `InputError` if another one
    is unusual, or does not fit the other conditions.
    """
    if spacing == checked.spacing:
        return checked
    if not checked.unusual_values:
        check_usual((), spacing=spacing)
    conditions = checked._replace(spacing=spacing)
    check_together(conditions)
    return conditions


def check_named_stresses(stresses: Sequence[float], checked: CheckedConditions) -> None:
    """Raise `InputError` unless stresses [Pa], at which closures are read, are within the load.

    They must be above 0, and from the seating stress of the ``checked`` conditions to the largest
    maximum.
    """
    largest = checked.largest_stress
    seating = checked.seating_stress
    least = f"from the seating stress, {1e-6 * seating:g} MPa," if seating else "above 0 MPa, up"
    for stress in stresses:
        check_number("at", stress)
    outside = [of for of in stresses if not (of > 0.0 and seating <= of <= largest)]
    if outside:
        named = ", ".join(f"{1e-6 * stress:g}" for stress in outside)
        raise InputError(
            f"at (--at): {named} MPa: must be {least} to the maximum normal stress, "
            f"{1e-6 * largest:g} MPa"
        )


def model_attributes(
    rock: tuple[Rock, Rock], spacing: float, effects: Effects, choices: Choices, numerics: Numerics
) -> dict[str, Any]:
    """Return rock, grid spacing [m], effects, choices and numerics as attributes of a dataset.

    All but the spacing are texts in JSON, the rock as in `rock_record`. An attribute names the
    conventions of the dataset.
    """
    names = (name for name, known in ROCKS.items() if rock == (known.intact, known.intact))
    switches = {name: bool(on) for name, on in effects._asdict().items()}
    return {
        "Conventions": "CF-1.11",
        "rock": json.dumps(rock_record(rock, next(names, "rock"))),
        "spacing_m": spacing,
        "effects": json.dumps(switches),
        "choices": json.dumps(in_double(choices)._asdict()),
        "numerics": json.dumps(in_double(numerics)._asdict()),
    }
