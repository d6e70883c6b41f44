"""Load of a joint: its cycles, from what a user states."""

import math
from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from jointclosure.inputs import InputError, check_count, check_number

USUAL_CYCLES = 2
MOST_CYCLES = 10_000
SEATING_STRESS = 0.5e6  # usual stress [Pa] from which seated closures count, as in laboratories
LARGEST_SEATING = 0.9
"""Largest seating stress over the smallest maximum of the load."""
_SEATING_SHARE = 0.1
"""Default seating stress over the smallest maximum of a load, where the usual one is too large."""


_STATED = "max_normal_stress (--stress)"
"""Keyword of the load, and its option on the command line."""


class LoadCycle(NamedTuple):
    """Loading to a maximum and unloading to a minimum, both stresses [Pa] or both forces [N].

    A minimum of 0 stands for last contact.
    """

    maximum: float
    minimum: float = 0.0


class Load(NamedTuple):
    """Checked load of a joint: its load cycles, and the stresses that were stated.

    ``load_cycles`` are in Pa. ``stresses`` [Pa] are as stated: the turning points of a load history
    if ``is_history``, else the one maximum of all cycles.
    """

    load_cycles: tuple[LoadCycle, ...]
    stresses: tuple[float, ...]
    is_history: bool

    def __str__(self) -> str:
        """Return the stated load in MPa, with its keyword and option, as messages name it."""
        return _shown(self.stresses, self.is_history)

    def description(self) -> str:
        """Describe the load in words: its stresses in MPa, and its cycles.

        Two stresses alone may have been meant as one number with a decimal comma.
        """
        given = [f"{1e-6 * stress:g}" for stress in self.stresses]
        cycles = len(self.load_cycles)
        text = f"{', '.join(given)} MPa, {cycles} cycle{'s' if cycles > 1 else ''}"
        if len(given) == 2 and "." not in "".join(given):
            high, low = given
            text += f" (up to {high} and down to {low} MPa; {high}.{low} MPa has a decimal point)"
        return text

    @property
    def least_maximum(self) -> float:
        """Smallest maximum of all load cycles [Pa]."""
        return min(cycle.maximum for cycle in self.load_cycles)

    @property
    def largest(self) -> float:
        """Largest stress of the load [Pa], a number of the type that was stated."""
        return max(self.stresses)


def stated_load(max_normal_stress: float | Sequence[float], cycles: int | None = None) -> Load:
    """Return the load that is stated as in `Conditions`, a maximum or a history [Pa].

    Raise `InputError` if it is not allowed.
    """
    if _is_history(max_normal_stress):
        return parsed_load(tuple(cast(Sequence[float], max_normal_stress)), True, cycles)
    return parsed_load((cast(float, max_normal_stress),), False, cycles)


def parsed_load(given: tuple[float, ...], is_history: bool, cycles: int | None = None) -> Load:
    """Return the load of stated stresses [Pa], or raise `InputError`.

    If ``is_history`` they are alternately maxima and minima; a last maximum gets the minimum 0.
    Otherwise the first is the maximum of all ``cycles``, by default `USUAL_CYCLES`.
    """
    if cycles is not None:
        check_count("cycles", cycles, 1, MOST_CYCLES)
    if len(given) > 2 * MOST_CYCLES:
        raise InputError(
            f"{_STATED}: has {len(given)} stresses, must have at most {2 * MOST_CYCLES}"
        )
    if not given:
        raise InputError(f"{_STATED} = []: a load history needs a maximum")
    for turn in given:
        check_number("max_normal_stress", turn)
    shown = _shown(given, is_history)
    stresses = [*map(float, given), *([0.0] if len(given) % 2 else [])]
    maxima = stresses[::2]
    minima = stresses[1::2]
    for number, (maximum, minimum) in enumerate(zip(maxima, minima, strict=True)):
        if not 0.0 < maximum < math.inf:
            raise InputError(f"{shown}: must be positive and finite")
        lowest = min(maxima[number : number + 2])
        if not 0.0 <= minimum < lowest:
            raise InputError(
                f"{shown}: maxima and minima alternate, and the minimum "
                f"{1e-6 * minimum:g} MPa must be at least 0 and below the maxima beside it "
                f"({1e-6 * lowest:g} MPa)"
            )
    if not is_history:
        same = (LoadCycle(maxima[0]),) * (USUAL_CYCLES if cycles is None else int(cycles))
        return Load(same, given, is_history)
    if cycles is not None and cycles != len(maxima):
        raise InputError(
            f"cycles = {cycles!r}: must be {len(maxima)}, the number of cycles of "
            f"{shown}, or left out"
        )
    return Load(tuple(map(LoadCycle, maxima, minima)), given, is_history)


def usual_seating(least: float) -> float:
    """Return the default seating stress [Pa] for the smallest maximum ``least`` [Pa] of a load.

    It is `SEATING_STRESS`, or a tenth of the maximum if the former exceeds 0.9 of the maximum.
    """
    low = 0.0 < LARGEST_SEATING * least < SEATING_STRESS
    return _SEATING_SHARE * least if low else SEATING_STRESS


def _shown(stresses: Sequence[float], is_history: bool) -> str:
    """Return stated stresses [Pa] in MPa, with the names of the keyword and of the option."""
    in_mpa = ", ".join(f"{1e-6 * stress:g}" for stress in stresses)
    return f"{_STATED} = {f'[{in_mpa}]' if is_history else in_mpa} MPa"


def _is_history(stress: object) -> bool:
    """Return whether a stated load is a sequence of stresses, and not a single maximum."""
    if isinstance(stress, np.ndarray):
        return stress.ndim == 1
    return isinstance(stress, Sequence) and not isinstance(stress, str | bytes)


def check_turns(load: Load, tolerance: float) -> None:
    """Raise `InputError` if a minimum and a maximum beside it may be equal within a tolerance.

    The ``tolerance`` is relative, and applies to both.
    """
    cycles = load.load_cycles
    for number, cycle in enumerate(cycles):
        minimum = cycle.minimum
        lowest = min(beside.maximum for beside in cycles[number : number + 2])
        if minimum * (1.0 + tolerance) >= lowest * (1.0 - tolerance):
            most = lowest * (1.0 - tolerance) / (1.0 + tolerance)
            raise InputError(
                f"{load}: the minimum {1e-6 * minimum:g} MPa is too close to a maximum beside it, "
                f"{1e-6 * lowest:g} MPa, as both are met within the stress_tolerance, "
                f"{tolerance:g}: the minimum must be below {1e-6 * most:.6g} MPa, or the "
                "stress_tolerance smaller"
            )


def check_snapshots(snapshots: Sequence[float], load: Load) -> None:
    """Raise `InputError` unless the stresses [Pa] of snapshots are from 0 to the load's largest."""
    for stress in snapshots:
        check_number("snapshots", stress)
        if not 0.0 <= stress <= load.largest:
            raise InputError(
                f"snapshots: {1e-6 * stress:g} MPa: must be from 0 to the maximum normal "
                f"stress, {1e-6 * load.largest:g} MPa"
            )
