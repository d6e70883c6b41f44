"""Conditions of a simulation as a user states them: rock, load and model."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypedDict

from jointclosure.inputs import InputError, check_length, check_number
from jointclosure.inputs.keywords import check_keywords, takes
from jointclosure.joint.checked_conditions import CheckedConditions, check_together
from jointclosure.joint.load import (
    LARGEST_SEATING,
    check_snapshots,
    check_turns,
    stated_load,
    usual_seating,
)
from jointclosure.joint.rocks import both_walls
from jointclosure.parameters import (
    RESOLVED,
    Choices,
    Effects,
    Numerics,
    Rock,
    check_model,
    check_usual,
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
    def model(self) -> tuple[Effects, Choices, Numerics]:
        """Effects, choices and numerics."""
        return self.effects, self.choices, self.numerics

    def checked(self, snapshots: Sequence[float] = ()) -> CheckedConditions:
        """Return the conditions with their values as simulations use them.

        ``snapshots`` are the stresses [Pa] of snapshots. Raise `InputError` if a condition or a
        snapshot is not allowed.
        """
        pair: tuple[Rock, Rock] = both_walls(self.rock)
        check_model(*self.model)
        if self.spacing is not None:
            check_length("spacing", self.spacing)
        load = stated_load(self.max_normal_stress, self.cycles)
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
        spacing = None if self.spacing is None else float(self.spacing)
        checked = CheckedConditions(
            spacing, pair, load, float(seating), *self.model, self.flow, self.unusual_values
        )
        check_together(checked)
        return checked


def as_stated(checked: CheckedConditions) -> Conditions:
    """Return checked conditions as the `Conditions` that a user would state to get them."""
    load = checked.load
    return Conditions(
        checked.spacing,
        checked.rock,
        load.stresses if load.is_history else load.largest,
        None if load.is_history else checked.cycle_count,
        *checked[3:],
    )


takes_conditions = takes(Conditions)
"""Decorator of functions with the fields of `Conditions` as ``**changes``."""
SCAN_DEFAULTS: Mapping[str, Any] = {"numerics": RESOLVED, "spacing": None}
"""Defaults of functions that take scans, which apply if they are called without ``conditions``."""
takes_scans = takes(Conditions, **SCAN_DEFAULTS)
"""Decorator of functions with the fields of `Conditions` as ``**changes``, where scans determine
the spacing. Without ``conditions`` breakage is resolved, unless ``numerics`` are given;
``conditions`` keep their numerics, by default the paper's steps."""


def conditions_from(
    conditions: Conditions | CheckedConditions | None,
    changes: Mapping[str, Any],
    function: str,
    *required: str,
    defaults: Mapping[str, Any] = {},
) -> Conditions:
    """Return ``conditions`` with the fields ``changes``, or new conditions with these fields.

    New conditions are made if ``conditions`` is None. They have the ``defaults`` of the calling
    function for fields that are not among the changes. Values are not checked. Raise `TypeError`
    for an unknown field, and for new conditions without rock, maximum stress or one of the
    ``required`` fields; the message names the ``function``.
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
    if isinstance(conditions, CheckedConditions):
        conditions = as_stated(conditions)
    return conditions._replace(**changes)
