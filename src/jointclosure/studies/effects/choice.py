"""Only the effects that a scene calls for: decided by a pilot on pieces of its own walls.

What an effect is worth depends on rock, roughness and stress, and on what else
acts; no rule of thumb says it. So a few pieces of the case's walls are closed
with all effects, and again without those whose absence saves time, largest
saving first. What changes the mean maximum closure of no cycle by more than a
tolerance is left out, judged with all that was left out before it.
"""

import itertools
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import ClosureSettings, Conditions
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.inputs import InputError, check_length, check_number
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    both_walls,
    check_usual,
    well_posed_scenes,
)
from jointclosure.protocol import FAILURE

DROPS = (("breakage", "gouge"), ("interaction",), ("substrate",))
"""Effects that are tried without, in this order: by what their absence saves (results of the
study of effects). Gouge and soft peaks cost nothing and stay as they are where anything breaks."""
PILOT_CELLS = 32
"""Cells along the longer side of a piece."""
PILOTS = 6
"""Pieces that are closed: one of the middle of each of so many pairs of walls."""
_FIRST, _CLEAR = 2, 4.0
"""Pieces that are closed first; where each of these changes by so many tolerances, no more are."""


def possible_scenes(effects: Effects, chosen: bool = True) -> list[Effects]:
    """Scenes that may be chosen where these effects may act, themselves the first.

    Themselves alone where none is ``chosen``.
    """
    found = [effects]
    for scene in found if chosen else ():
        for names in DROPS:
            fewer = scene._replace(**dict.fromkeys(names, False))
            if fewer in well_posed_scenes() and fewer not in found:
                found.append(fewer)
    return found


class SceneChoice(NamedTuple):
    """Effects chosen for a case, by how much they are estimated to be off, and why.

    ``error`` is relative, of the mean maximum closure, the largest over the
    cycles, with two standard errors on top; 0 where all effects act.
    ``reasons`` has a sentence for every group of effects that was tried without.
    """

    effects: Effects
    error: float
    reasons: tuple[str, ...]


def choose_effects(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    *,
    spacing: float,
    rock,
    max_normal_stress: float,
    cycles: int = 2,
    effects: Effects = Effects(),
    choices: Choices = Choices(),
    numerics: Numerics = Numerics(),
    unusual_values: bool = False,
    tolerance: float = 0.02,
    report: Callable[[str], None] = lambda line: None,
) -> SceneChoice:
    """Choose the effects that matter in a scene.

    Parameters
    ----------
    walls : iterable of (upper, lower)
        Pairs of walls (y, x) [m] of the case, of which the first `PILOTS` are used.
    spacing, rock, max_normal_stress, cycles, choices, numerics, unusual_values
        As for `jointclosure.simulate`.
    effects : Effects
        Those that may act, and against which others are held.
    tolerance : float
        Relative change of the mean maximum closure of a cycle, in (0, 1), below
        which an effect does not matter.
    report : callable
        Receives a line for each decision.

    Returns
    -------
    SceneChoice

    Raises
    ------
    InputError
        A tolerance out of range, no walls, or what `jointclosure.simulate` refuses.
    """
    check_length("spacing", spacing)
    check_number("max_normal_stress", max_normal_stress)
    rocks = both_walls(rock)
    if not unusual_values:
        check_usual(rocks, spacing=spacing, max_normal_stress=max_normal_stress)
    conditions = Conditions(
        spacing, rock, max_normal_stress, cycles, 0.0, effects, choices, numerics
    )
    return choose_among(walls, conditions, tolerance, report)


def choose_among(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    conditions: Conditions,
    tolerance: float,
    report: Callable[[str], None] = lambda line: None,
) -> SceneChoice:
    """`choose_effects` among those of the conditions at which walls are closed."""
    if not 0.0 < tolerance < 1.0:
        raise InputError(f"tolerance = {tolerance!r}: must lie between 0 and 1")
    effects = conditions.effects
    pilot = _Pilot(list(itertools.islice(walls, PILOTS)), conditions)
    chosen, error, reasons = effects, 0.0, []
    for names in DROPS:
        trial = chosen._replace(**dict.fromkeys(names, False))
        if trial == chosen or trial not in well_posed_scenes():
            continue
        change = pilot.changes(trial, _FIRST)
        clear = np.abs(change).max(axis=1).min() > _CLEAR * tolerance
        if np.isfinite(change).all() and not clear:
            change = pilot.changes(trial, len(pilot.pairs))
        off = _bound(change)
        dropped = off <= tolerance
        moved = f"changes by up to {100.0 * off:.2g} %" if np.isfinite(off) else "is not to be had"
        reasons.append(
            f"without {' and '.join(names)} the mean maximum closure {moved} "
            f"({len(change)} pilots): {'left out' if dropped else 'kept'}"
        )
        report(reasons[-1])
        if dropped:
            chosen, error = trial, off
    if chosen == effects:
        report("every effect matters: all act")
    return SceneChoice(chosen, error, tuple(reasons))


def choose_for_case(
    settings: ClosureSettings, report: Callable[[str], None] = lambda line: None
) -> SceneChoice:
    """`choose_effects` for a case of a study, among its effects and to its tolerance.

    Raises
    ------
    InputError
        The study chooses none.
    """
    tolerance = settings.effects_chosen_to
    if tolerance is None:
        raise InputError("effects.auto = null: the study chooses no effects")
    return choose_among(walls_of(settings.surfaces), settings.conditions(), tolerance, report)


class _Pilot:
    """Pieces of walls, closed in the scenes that are asked for and no more often than needed."""

    def __init__(self, pairs: list[tuple[np.ndarray, np.ndarray]], conditions: Conditions):
        if len(pairs) < _FIRST:
            raise InputError(f"walls: {len(pairs)} pairs, a pilot needs {_FIRST} at least")
        self.pairs, self.effects, self.conditions = pairs, conditions.effects, conditions
        self.pieces = [(_piece(upper), _piece(lower)) for upper, lower in pairs]
        self._known: dict[Effects, list[np.ndarray]] = {}

    def changes(self, scene: Effects, count: int) -> np.ndarray:
        """Changes of closure (pair, cycle) from all effects to a scene, over the mean [1]."""
        full = self._closures(self.effects, count)
        change = self._closures(scene, count) - full
        if self.effects.interaction and not scene.interaction:
            change = change - self._bulk_missed(count)
        return change / full.mean(axis=0)

    def _closures(self, scene: Effects, count: int) -> np.ndarray:
        rows = self._known.setdefault(scene, [])
        told = self.conditions._replace(effects=scene)
        rows += [max_closures(piece, told) for piece in self.pieces[len(rows) : count]]
        return np.array(rows[:count])

    def _bulk_missed(self, count: int) -> np.ndarray:
        """Closure by interaction (pair, cycle) [m] that whole walls have beyond their pieces.

        Bulk indentation grows with the side of the joint, so a piece shows too little of
        it. That of elastic walls is taken for all, as it takes no steps.
        """
        numerics = self.conditions.numerics._replace(curve_points=1, solver="fast")
        scene = self.effects._replace(breakage=False, gouge=False)
        elastic = self.conditions._replace(effects=scene, numerics=numerics)
        alone = elastic._replace(effects=scene._replace(interaction=False))
        whole, piece = (
            np.array([max_closures(p, elastic) - max_closures(p, alone) for p in some[:count]])
            for some in (self.pairs, self.pieces)
        )
        return whole - piece


def _piece(wall: np.ndarray) -> np.ndarray:
    """The middle of a wall (y, x), at most `PILOT_CELLS` along a side."""
    cuts = []
    for size in wall.shape:
        start = max(size - PILOT_CELLS, 0) // 2
        cuts.append(slice(start, start + min(size, PILOT_CELLS)))
    return wall[tuple(cuts)]


def max_closures(pair: tuple[np.ndarray, np.ndarray], conditions: Conditions) -> np.ndarray:
    """Maximum closures (cycle,) [m] of a pair of walls; NaN where the simulation failed."""
    closed = close_walls(*pair, conditions)
    return np.where(int(closed.status) >= FAILURE, np.nan, closed.max_closure.values)


def _bound(change: np.ndarray) -> float:
    """Largest |mean| over the cycles of changes (pair, cycle), with two standard errors on top."""
    error = change.std(axis=0, ddof=1) / np.sqrt(len(change))
    bound = np.max(np.abs(change.mean(axis=0)) + 2.0 * error)
    return float(bound) if np.isfinite(bound) else np.inf
