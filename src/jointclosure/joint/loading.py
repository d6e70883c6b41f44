"""Load cycles of a joint, from a maximum and a number of cycles or from a load history."""

import math
from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from jointclosure.inputs import InputError, check_number

USUAL_CYCLES = 2
SEATING_STRESS = 0.5e6
"""Usual stress [Pa] from which seated closures count, as laboratory curves do."""
LARGEST_SEATING = 0.9
"""Largest seating stress over the smallest maximum: from nearer to it, closures since seating are
those of a step or two."""
_SEATING_SHARE = 0.1
"""The same by default, for joints that are loaded less far than the usual seating stress allows."""


class LoadCycle(NamedTuple):
    """Loading to a maximum and unloading to a minimum, in one unit.

    A minimum of 0 is last contact.
    """

    maximum: float
    minimum: float = 0.0


def load_cycles(
    max_normal_stress: float | Sequence[float], cycles: int | None = None
) -> tuple[LoadCycle, ...]:
    """Check a load and return its cycles [Pa]."""
    if cycles is not None:
        check_number("cycles", cycles, whole=True)
        if cycles < 1:
            raise InputError(f"cycles = {cycles!r}: must be a whole number from 1 on")
    turns = _turns(max_normal_stress)
    if turns is None:
        maximum = cast(float, max_normal_stress)
        check_number("max_normal_stress", maximum)
        _check_maximum(maximum, f"{maximum!r} Pa")
        number = USUAL_CYCLES if cycles is None else int(cycles)
        return (LoadCycle(float(maximum)),) * number
    turns_in_words = ", ".join(str(turn) for turn in turns)
    if not turns:
        raise InputError("max_normal_stress = []: a load history needs a maximum")
    for turn in turns:
        check_number("max_normal_stress", turn)
    turns = [*map(float, turns), *([0.0] if len(turns) % 2 else [])]
    maxima, minima = turns[::2], turns[1::2]
    for maximum in maxima:
        _check_maximum(maximum, f"[{turns_in_words}] Pa")
    for number, minimum in enumerate(minima):
        lowest = min(maxima[number : number + 2])
        if not 0.0 <= minimum < lowest:
            raise InputError(
                f"max_normal_stress = [{turns_in_words}] Pa: maxima and minima alternate, and the "
                f"minimum {minimum:g} must be at least 0 and below the maxima beside it "
                f"({lowest:g})"
            )
    if cycles is not None and cycles != len(maxima):
        raise InputError(
            f"cycles = {cycles!r}: must be {len(maxima)}, the number of cycles of the load "
            f"history [{turns_in_words}] Pa, or left out"
        )
    return tuple(map(LoadCycle, maxima, minima))


def usual_seating(least: float) -> float:
    """Return the default seating stress [Pa] for the smallest maximum [Pa] of a load."""
    low = 0.0 < LARGEST_SEATING * least < SEATING_STRESS
    return _SEATING_SHARE * least if low else SEATING_STRESS


def describe_load(max_normal_stress: float | Sequence[float], cycles: int) -> str:
    """Describe a load in words: its stresses in MPa, and its cycles."""
    turns = _turns(max_normal_stress)
    shown = [cast(float, max_normal_stress)] if turns is None else turns
    stresses = ", ".join(f"{1e-6 * stress:g}" for stress in shown)
    return f"{stresses} MPa, {cycles} cycle{'s' if cycles > 1 else ''}"


def largest_stress(max_normal_stress: float | Sequence[float]) -> float:
    """Return the largest stress of a maximum or a load history, unchecked."""
    turns = _turns(max_normal_stress)
    return cast(float, max_normal_stress) if turns is None else max(turns)


def _turns(stress: float | Sequence[float]) -> list[float] | None:
    """Return the stresses of a load history, or None for a single maximum."""
    many = isinstance(stress, Sequence) and not isinstance(stress, str | bytes)
    if many or (isinstance(stress, np.ndarray) and stress.ndim == 1):
        return [*cast(Sequence[float], stress)]
    return None


def _check_maximum(maximum: float, stress_in_words: str) -> None:
    if not 0.0 < maximum < math.inf:
        raise InputError(f"max_normal_stress = {stress_in_words}: must be positive and finite")
