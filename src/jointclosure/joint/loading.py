"""How a joint is loaded: cycles, from a maximum and their number or from a history of stresses."""

import math
from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from jointclosure.inputs import InputError, check_number

USUAL_CYCLES = 2
SEATING_STRESS = 0.5e6
"""Default stress [Pa] from which seated closures count: laboratory curves start there."""


class LoadCycle(NamedTuple):
    """Loading to a maximum and unloading to a minimum; 0 is last contact. Both in one unit."""

    maximum: float
    minimum: float = 0.0


def load_cycles(
    max_normal_stress: float | Sequence[float], cycles: int | None = None
) -> tuple[LoadCycle, ...]:
    """Load cycles [Pa], checked.

    Parameters
    ----------
    max_normal_stress : float or sequence of float
        Maximum of every cycle [Pa], each unloaded to last contact. Or the load history: the
        stresses at which the load turns, a maximum first, then a minimum, a maximum and so on. 0
        is last contact; after a maximum that comes last the joint is unloaded to it.
    cycles : int, optional
        Their number: by default 2, or those of the load history.

    Returns
    -------
    tuple of LoadCycle

    Raises
    ------
    InputError
        A maximum that is not positive and finite, a minimum that is negative or not below the
        maxima beside it, another number of cycles than the load history has.
    """
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
    told = ", ".join(str(turn) for turn in turns)
    if not turns:
        raise InputError("max_normal_stress = []: a load history needs a maximum")
    for turn in turns:
        check_number("max_normal_stress", turn)
    turns = [*map(float, turns), *([0.0] if len(turns) % 2 else [])]
    maxima, minima = turns[::2], turns[1::2]
    for maximum in maxima:
        _check_maximum(maximum, f"[{told}] Pa")
    for number, minimum in enumerate(minima):
        lowest = min(maxima[number : number + 2])
        if not 0.0 <= minimum < lowest:
            raise InputError(
                f"max_normal_stress = [{told}] Pa: maxima and minima take turns, and minimum "
                f"{minimum:g} must be from 0 to below the maxima beside it ({lowest:g})"
            )
    if cycles is not None and cycles != len(maxima):
        raise InputError(
            f"cycles = {cycles!r}: must be left out or {len(maxima)}, as many as the load "
            f"history [{told}] Pa has"
        )
    return tuple(map(LoadCycle, maxima, minima))


def load_said(max_normal_stress: float | Sequence[float], cycles: int) -> str:
    """The load in words: its stresses in MPa, and its cycles."""
    turns = _turns(max_normal_stress)
    shown = [cast(float, max_normal_stress)] if turns is None else turns
    stresses = ", ".join(f"{1e-6 * stress:g}" for stress in shown)
    return f"{stresses} MPa, {cycles} cycle{'s' if cycles > 1 else ''}"


def largest_stress(max_normal_stress: float | Sequence[float]) -> float:
    """Largest stress of a maximum or a load history, unchecked."""
    turns = _turns(max_normal_stress)
    return cast(float, max_normal_stress) if turns is None else max(turns)


def _turns(stress: float | Sequence[float]) -> list[float] | None:
    """The stresses of a load history, None of a single maximum."""
    many = isinstance(stress, Sequence) and not isinstance(stress, str | bytes)
    if many or (isinstance(stress, np.ndarray) and stress.ndim == 1):
        return [*cast(Sequence[float], stress)]
    return None


def _check_maximum(maximum: float, told: str) -> None:
    if not 0.0 < maximum < math.inf:
        raise InputError(f"max_normal_stress = {told}: must be positive and finite")


def check_snapshots(snapshots: Sequence[float], max_normal_stress: float) -> None:
    """Raise `InputError` unless stresses [Pa] of snapshots lie within the load."""
    for stress in snapshots:
        check_number("snapshots", stress)
        if not 0.0 <= stress <= max_normal_stress:
            raise InputError(
                f"snapshots: {stress!r} Pa: must be from 0 to max_normal_stress = "
                f"{max_normal_stress!r} Pa"
            )
