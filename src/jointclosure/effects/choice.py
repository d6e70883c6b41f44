"""Only the effects that a scene calls for: decided by a pilot that costs nothing where all matter.

What an effect is worth depends on rock, roughness and stress, and on what else
acts; no rule of thumb says it. The evidence is gathered in the order of its cost, and the first
proof that an effect matters ends the search for it:

1. A pair of walls of the case is closed with all effects. This is a realisation of the case, which
   needs not be closed again where all effects act.
2. What that run tells by itself. A joint that only deforms elastically closes by as much in every
   cycle, so whatever that closure is, one of the cycles is off by (largest - least) / (largest +
   least) at least. Interaction adds bulk indentation, which is nothing without it.
3. The same walls closed without the effect. Curves without breakage take little time, and are
   taken of a few pairs; else one pair has to do.

One pair does not tell how the pairs scatter: what it shows counts twice. What is crushed on the
first cycle decides the second, so that the same pair may close by a tenth less there without
interaction and the next by a tenth more. That is the worse, the more the cycles differ: a mean over
20 pairs is then off by about a sixteenth of (largest - least) / (largest + least), twice its
standard error (measured at 60 random conditions that no test has). Where this is too much already,
nothing is tried.

What changes the mean maximum closure of no cycle by more than a tolerance is left out, judged with
all that was left out before it.
"""

import itertools
import time
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.ensemble.cases import BASE
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import ClosureSettings, Conditions
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.inputs import InputError, check_length, check_number
from jointclosure.joint.given_walls import checked_walls, warn_of_doubts
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    Choices,
    Effects,
    Numerics,
    both_walls,
    check_scene,
    check_usual,
    well_posed_scenes,
)

DROPS = (("breakage", "gouge"), ("interaction",), ("substrate",))
"""Effects that are tried without, in this order: by what their absence saves (results of the
study of effects). Gouge and soft peaks cost nothing and stay as they are where anything breaks;
so does the substrate, without which simulations fail there."""
ELASTIC_TRIALS = 4
"""Pairs of walls that are closed without an effect where nothing breaks; else one is."""
MARGIN = 2.0
"""What a single pair shows counts so many times, as it does not tell how pairs scatter."""
DIVERGENCE = 1.0 / 16.0
"""By what share of the cycles' difference a mean is off without interaction, by chance alone."""
_CLEAR = 2.0
"""Where the first pair shows so many tolerances, margin included, no others are closed."""


def possible_scenes(effects: Effects, chosen: bool = True) -> list[Effects]:
    """Scenes that may be chosen where these effects may act, themselves the first.

    Themselves alone where none is ``chosen``.
    """
    found = [effects]
    for scene in found if chosen else ():
        for names in DROPS:
            fewer = _without(scene, names)
            if fewer is not None and fewer not in found:
                found.append(fewer)
    return found


def _without(scene: Effects, names: tuple[str, ...]) -> Effects | None:
    """A scene without some effects; None where these are not tried without."""
    fewer = scene._replace(**dict.fromkeys(names, False))
    fails = "substrate" in names and scene.breakage
    return None if fewer == scene or fails or fewer not in well_posed_scenes() else fewer


class Closed(NamedTuple):
    """A pair of walls that was closed with all effects: as from `jointclosure.simulate`, and the
    processor time [s]."""

    dataset: xr.Dataset
    seconds: float


class SceneChoice(NamedTuple):
    """Effects chosen for a case, by how much they are estimated to be off, and why.

    ``error`` is relative, of the mean maximum closure, the largest over the
    cycles, with a margin; 0 where all effects act.
    ``reasons`` has a sentence for every group of effects that was tried without. ``closed``: the
    first pairs of walls, closed with all effects; ``trial_seconds``: what was spent on closing
    walls without some, which is lost where all act.
    """

    effects: Effects
    error: float
    reasons: tuple[str, ...]
    closed: tuple[Closed, ...] = ()
    trial_seconds: float = 0.0


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
    tolerance: float = AUTO_TOLERANCE,
    report: Callable[[str], None] = lambda line: None,
) -> SceneChoice:
    """Choose the effects that matter in a scene.

    Parameters
    ----------
    walls : iterable of (upper, lower)
        Pairs of walls (y, x) [m] of the case, of which as few as decide are closed.
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
    pairs = _checked_pairs(walls, spacing)
    if not unusual_values:
        check_usual(rocks, spacing=spacing, max_normal_stress=max_normal_stress)
        for pair in pairs:
            warn_of_doubts(*pair, spacing)
    conditions = Conditions(
        spacing, rock, max_normal_stress, cycles, 0.0, effects, choices, numerics
    )
    return choose_among(pairs, conditions, tolerance, report)


def choose_among(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    conditions: Conditions,
    tolerance: float,
    report: Callable[[str], None] = lambda line: None,
) -> SceneChoice:
    """`choose_effects` among those of the conditions at which walls are closed."""
    check_number("tolerance", tolerance)
    check_scene(conditions.effects)
    if not 0.0 < tolerance < 1.0:
        raise InputError(f"tolerance = {tolerance!r}: must lie between 0 and 1")
    effects = conditions.effects
    pilot = _Pilot(list(itertools.islice(walls, ELASTIC_TRIALS)), conditions)
    chosen, error, reasons = effects, 0.0, []
    for names in DROPS:
        trial = _without(chosen, names)
        if trial is None:
            continue
        off, why = _evidence(pilot, names, trial, tolerance)
        dropped = off <= tolerance
        moved = f"changes by {why}" if np.isfinite(off) else "is not to be had"
        reasons.append(
            f"without {' and '.join(names)} the mean maximum closure {moved}: "
            f"{'left out' if dropped else 'kept'}"
        )
        report(reasons[-1])
        if dropped:
            chosen, error = trial, off
    if chosen == effects:
        report("every effect matters: all act")
    return SceneChoice(chosen, error, tuple(reasons), tuple(pilot.closed), pilot.trial_seconds)


def _evidence(pilot: "_Pilot", names, trial: Effects, tolerance: float) -> tuple[float, str]:
    """What a scene without some effects is off by, and that in words: the cheapest that decides."""
    least = pilot.shown(names)
    if MARGIN * least > tolerance:
        counted = f"{MARGIN:g} times {100.0 * least:.2g} %"
        return MARGIN * least, f"{counted} (estimated from one run with all effects, so doubled)"
    change = pilot.changes(trial, 1)
    off = MARGIN * float(np.abs(change).max())
    many = 1 if trial.breakage else len(pilot.pairs)
    if many > 1 and off <= _CLEAR * tolerance:
        change = pilot.changes(trial, many)
        error = change.std(axis=0, ddof=1) / np.sqrt(many)
        off = float(np.max(np.abs(change.mean(axis=0)) + 2.0 * error))
    off = off if np.isfinite(off) else np.inf
    return off, f"up to {100.0 * off:.2g} % ({len(change)} tried)"


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


class RockChoice(NamedTuple):
    """Effects for all cases of a rock, by how much they are estimated to be off, and the choices of
    those cases that were asked."""

    effects: Effects
    error: float
    cases: dict[str, SceneChoice]


def choose_for_rock(
    settings: dict[str, ClosureSettings], report: Callable[[str], None] = lambda line: None
) -> RockChoice:
    """One choice for the cases of a rock, which are compared with each other.

    Parameters
    ----------
    settings : dict
        Of each case by its label.
    report : callable
        Receives a line for each decision.

    Returns
    -------
    RockChoice
        The effects that matter in any case. The base case is asked first; where all effects act in
        a case that was asked, the others are not.
    """
    allowed = next(iter(settings.values())).case.effects
    found: dict[str, SceneChoice] = {}
    together = Effects(*[False] * len(Effects._fields))
    for label in sorted(settings, key=lambda label: settings[label].case.parameter != BASE):
        report(f"{label}:")
        found[label] = choose_for_case(settings[label], report)
        together = Effects(*map(any, zip(together, found[label].effects, strict=True)))
        if together == allowed:
            break
    report(f"for all cases, {len(found)} of {len(settings)} asked: {together}")
    error = max(choice.error for choice in found.values()) if together != allowed else 0.0
    return RockChoice(together, error, found)


def _checked_pairs(
    walls: Iterable[tuple[np.ndarray, np.ndarray]], spacing: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """As many pairs of walls as a pilot closes at most."""
    pairs = list(itertools.islice(walls, ELASTIC_TRIALS))
    if not pairs:
        raise InputError("walls: 0 pairs, a pilot needs one at least")
    for pair in pairs:
        if len(pair) != 2 or np.ndim(pair[0]) != 2:
            raise InputError(
                f"walls: an array of shape {np.shape(pair[0])} where a wall (y, x) should be; "
                "give a list of pairs, such as [(upper, lower)]"
            )
    return [checked_walls(*pair, spacing) for pair in pairs]


class _Pilot:
    """Pairs of walls, closed in the scenes that are asked for and no more often than needed."""

    def __init__(self, pairs: list[tuple[np.ndarray, np.ndarray]], conditions: Conditions):
        self.pairs, self.conditions = pairs, conditions
        self.closed: list[Closed] = []
        self.trial_seconds = 0.0
        self._known: dict[Effects, list[np.ndarray]] = {}

    def shown(self, names: tuple[str, ...]) -> float:
        """The change of closure [1] without some effects that a run with all of them shows.

        0 where it shows none.
        """
        closures = self._full(1)[0]
        if not np.isfinite(closures).all():
            return np.inf
        differ = float(np.ptp(closures) / (closures.max() + closures.min()))
        if "breakage" in names:
            return differ
        if "interaction" in names:
            bulk = self.closed[0].dataset.max_bulk_indentation.values
            return max(float(np.max(bulk / closures)), DIVERGENCE * differ)
        return 0.0

    def changes(self, scene: Effects, count: int) -> np.ndarray:
        """Changes of closure (pair, cycle) from all effects to a scene, over the mean [1]."""
        full, rows = self._full(count), self._known.setdefault(scene, [])
        numerics = self.conditions.numerics
        if not scene.breakage:
            # only the maximum is read
            numerics = numerics._replace(curve_points=1, solver="fast")
        told = self.conditions._replace(effects=scene, numerics=numerics)
        start = time.process_time()
        rows += [max_closures(close_walls(*p, told)) for p in self.pairs[len(rows) : count]]
        self.trial_seconds += time.process_time() - start
        return (np.array(rows[:count]) - full) / full.mean(axis=0)

    def _full(self, count: int) -> np.ndarray:
        """Maximum closures (pair, cycle) [m] of the first pairs with all effects."""
        for pair in self.pairs[len(self.closed) : count]:
            start = time.process_time()
            dataset = close_walls(*pair, self.conditions)
            self.closed.append(Closed(dataset, time.process_time() - start))
        return np.array([max_closures(each.dataset) for each in self.closed[:count]])


def max_closures(closed: xr.Dataset) -> np.ndarray:
    """Maximum closures (cycle,) [m] of a simulation; NaN where it failed."""
    return np.where(int(closed.status) >= FAILURE, np.nan, closed.max_closure.values)
