"""Conditions of a simulation: rock, load and model, as every function that simulates takes them."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypedDict, cast

from jointclosure.inputs import InputError, check_length, check_number
from jointclosure.inputs.keywords import check_keywords, takes
from jointclosure.joint.load import (
    LARGEST_SEATING,
    Load,
    LoadCycle,
    check_snapshots,
    check_turns,
    stated_load,
    usual_seating,
)
from jointclosure.joint.rocks import ROCKS, both_walls, rock_record
from jointclosure.parameters import (
    RESOLVED,
    Choices,
    Effects,
    Numerics,
    Rock,
    check_crushed_strength,
    check_model,
    check_radius,
    check_usual,
    in_double,
)


class Changes(TypedDict, total=False):
    """Fields of `Conditions` as keywords, for type checkers and editors."""

    spacing: float | None
    rock: str | Rock | Sequence[str | Rock]
    max_normal_stress: float | Sequence[float]
    cycles: int | None
    seating_stress: float | None
    effects: Effects
    choices: Choices
    numerics: Numerics
    flow: bool
    unusual_values: bool


class Conditions(NamedTuple):
    """Everything besides the walls on which the closure of a joint depends, in SI.

    Functions that simulate joints take these fields as keywords. They also take ``conditions``, an
    instance of which the keywords replace fields.

    Attributes
    ----------
    spacing : float or None
        Grid spacing h [m] of the walls. It is a parameter of the model, because a cell is an
        asperity. None if scanned walls determine it.
    rock : str, Rock or a pair of them
        Rock of both walls, or of the upper and the lower wall: its properties, or the name of a
        rock of the package, such as "granite" (`jointclosure.joint.rocks.ROCKS`).
    max_normal_stress : float or sequence of float
        Maximum of every cycle [Pa]; or the load history, the stresses at which the load turns,
        alternately a maximum and a minimum, such as 5, 0, 20, 2, 30 MPa. 0 is last contact. If a
        maximum comes last, the joint is then unloaded to 0. Where rock breaks, a minimum must be
        below both maxima beside it by more than the ``stress_tolerance`` of both.
    cycles : int or None
        Number of load cycles, from 1 to 10,000: by default 2, or that of the load history.
    seating_stress : float or None
        Stress from which closures since seating count [Pa], from 0 to 0.9 of the smallest maximum:
        by default 0.5 MPa, or a tenth of that maximum where 0.5 MPa are too much. It does not
        change the history. Seated closures are NaN in a cycle whose loading starts above it.
    effects, choices, numerics : Effects, Choices, Numerics
    flow : bool
        Whether to compute hydraulic apertures (docs/export.md#flow). It changes no other result.
    unusual_values : bool
        Whether values that are unusual for rock are accepted. Otherwise a modulus of 78 Pa, for
        example, is refused, because 78 GPa was probably meant, and a `UserWarning` is given for
        rough walls that seem to be upside down, turned, or in another unit than the spacing.
    """

    spacing: float | None
    rock: Any
    max_normal_stress: float | Sequence[float]
    cycles: int | None = None
    seating_stress: float | None = None
    effects: Effects = Effects()
    choices: Choices = Choices()
    numerics: Numerics = Numerics()
    flow: bool = False
    unusual_values: bool = False

    @property
    def load(self) -> Load:
        """Load [Pa].

        It is parsed from ``max_normal_stress`` and ``cycles`` if the conditions are not checked,
        which may raise `InputError`.
        """
        return stated_load(self.max_normal_stress, self.cycles)

    @property
    def is_checked(self) -> bool:
        """Whether these are conditions that `checked` returned, or a copy of them.

        This does not say that values which the copy replaced are allowed.
        """
        return isinstance(self.max_normal_stress, Load)

    @property
    def cycle_count(self) -> int:
        return len(self.load.load_cycles)

    @property
    def grid_spacing(self) -> float:
        """Grid spacing [m], checked; `InputError` if it is missing or out of its range."""
        spacing = cast(float, self.spacing)
        check_length("spacing", spacing)
        return float(spacing)

    @property
    def largest_stress(self) -> float:
        """Largest normal stress of all cycles [Pa]."""
        return self.load.largest

    @property
    def model(self) -> tuple[Effects, Choices, Numerics]:
        """Effects, choices and numerics."""
        return self.effects, self.choices, self.numerics

    def load_text(self) -> str:
        """Describe the load in words: its stresses in MPa, and its cycles.

        Two stresses alone may have been meant as one number with a decimal comma.
        """
        load = self.load
        given = [f"{1e-6 * stress:g}" for stress in load.stresses]
        cycles = len(load.load_cycles)
        text = f"{', '.join(given)} MPa, {cycles} cycle{'s' if cycles > 1 else ''}"
        if len(given) == 2 and "." not in "".join(given):
            high, low = given
            text += f" (up to {high} and down to {low} MPa; {high}.{low} MPa has a decimal point)"
        return text

    def attributes(self) -> dict[str, Any]:
        """Return checked conditions as attributes of a dataset."""
        load = self.load.load_cycles
        repeated = load == (LoadCycle(load[0].maximum),) * len(load)
        turns = [stress for cycle in load for stress in cycle]
        return model_attributes(self.rock, self.grid_spacing, *self.model) | {
            "max_normal_stress_Pa": load[0].maximum if repeated else turns,
            "seating_stress_Pa": float(cast(float, self.seating_stress)),
        }

    def checked(self, snapshots: Sequence[float] = ()) -> "Conditions":
        """Return the conditions with their values as simulations use them.

        Replaced are ``rock`` by both rocks, ``max_normal_stress`` by a `Load`, ``cycles`` by its
        number, and ``seating_stress`` by its default if not stated. Raise `InputError` if a
        condition, or a stress [Pa] of the snapshots, is not allowed.
        """
        pair: tuple[Rock, Rock] = both_walls(self.rock)
        check_model(*self.model)
        if self.spacing is not None:
            check_length("spacing", self.spacing)
        load = self.load
        if self.effects.breakage or self.numerics.solver == "reference":  # else turns are exact
            check_turns(load, self.numerics.stress_tolerance)
        if not self.unusual_values:
            given = self._asdict() | self.choices._asdict() | self.numerics._asdict()
            del given["max_normal_stress"]  # of which every maximum is checked
            check_usual(pair, **given)
            for maximum in load.stresses[::2]:
                check_usual((), max_normal_stress=maximum)
        least = load.least_maximum
        seating = usual_seating(least) if self.seating_stress is None else self.seating_stress
        check_number("seating_stress", seating)
        if not 0.0 <= seating <= LARGEST_SEATING * least:
            raise InputError(
                f"seating_stress (--seating) = {1e-6 * seating:g} MPa: must be from 0 to "
                f"{LARGEST_SEATING:g} of the smallest maximum of the load, {1e-6 * least:g} MPa"
            )
        check_snapshots(snapshots, load)
        if not self.unusual_values:
            for stress in snapshots:
                check_usual((), snapshots=stress)
        checked = self._replace(
            rock=pair,
            max_normal_stress=cast(Any, load),  # the annotation has what a user may state
            cycles=len(load.load_cycles),
            seating_stress=float(seating),
        )
        check_together(checked)
        return checked


def check_together(conditions: Conditions) -> None:
    """Raise `InputError` if values that are each allowed do not fit each other.

    It is called for checked conditions, and again where one of their values was changed to
    another allowed one. A radius is compared with the grid spacing if this is known.
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


def on_grid(checked: Conditions, spacing: float) -> Conditions:
    """Return checked conditions with the grid spacing [m] that the walls determine.

    Raise `InputError` if it is unusual, or does not fit the other conditions.
    """
    if not checked.unusual_values:
        check_usual((), spacing=spacing)
    conditions = checked._replace(spacing=spacing)
    check_together(conditions)
    return conditions


def check_named_stresses(stresses: Sequence[float], checked: Conditions) -> None:
    """Raise `InputError` unless stresses [Pa] are above 0, and from seating to the largest maximum.

    Closures count from the seating stress, which ``checked`` conditions have.
    """
    largest = checked.largest_stress
    seating = float(cast(float, checked.seating_stress))
    least = f"from the seating stress, {1e-6 * seating:g} MPa," if seating else "above 0 MPa, up"
    for stress in stresses:
        check_number("at", stress)
        if not (stress > 0.0 and seating <= stress <= largest):
            raise InputError(
                f"at (--at): {1e-6 * stress:g} MPa: must be {least} to the maximum normal stress, "
                f"{1e-6 * largest:g} MPa"
            )


def model_attributes(
    rock: tuple[Rock, Rock], spacing: float, effects: Effects, choices: Choices, numerics: Numerics
) -> dict[str, Any]:
    """Return rock, spacing and model as attributes of a dataset; the rock as `rock_record`."""
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


takes_conditions = takes(Conditions)
"""Decorator of functions with the fields of `Conditions` as ``**changes``."""
SCAN_DEFAULTS: Mapping[str, Any] = {"numerics": RESOLVED, "spacing": None}
"""Values of functions that take scans, which hold without ``conditions``."""
takes_scans = takes(Conditions, **SCAN_DEFAULTS)
"""Decorator of functions with the fields of `Conditions` as ``**changes``, where scans determine
the spacing. Without ``conditions`` breakage is resolved, unless ``numerics`` are given;
``conditions`` keep their numerics, by default the paper's steps."""


def conditions_from(
    conditions: Conditions | None,
    changes: Mapping[str, Any],
    function: str,
    *required: str,
    defaults: Mapping[str, Any] = {},
) -> Conditions:
    """Return ``conditions`` with the fields ``changes``, or new conditions with these fields.

    New conditions have the ``defaults`` of the function for fields that are not among the changes.
    Values are not checked. Raise `TypeError` for an unknown field, and for new conditions without
    rock, maximum stress or one of the ``required`` fields; the message names the ``function``.
    """
    needed = (*required, "rock", "max_normal_stress") if conditions is None else ()
    inside = {
        "rock": Rock._fields,
        "effects": Effects._fields,
        "choices": Choices._fields,
        "numerics": Numerics._fields,
    }
    check_keywords(function, changes, Conditions._fields, needed, inside)
    if conditions is None:
        return Conditions(**{"spacing": None, **defaults, **changes})
    return conditions._replace(**changes)
