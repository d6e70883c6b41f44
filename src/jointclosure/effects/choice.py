"""Selection of the effects that a scene needs, by a pilot without cost if all effects matter.

The significance of an effect depends on rock, roughness and stress, and on the other effects;
there is no rule of thumb. Evidence is collected in the order of its cost, and the first proof
that an effect matters ends the search for it:

1. A pair of walls of the case is closed with all effects. This is a realisation of the case,
   which need not be closed again if all effects act.
2. This run gives lower bounds. A joint that only deforms elastically has the same closure in
   every cycle. Whatever this closure is, one of the cycles then has an error of at least
   (largest - least) / (largest + least). Interaction adds bulk indentation, which is 0 without it.
3. The same walls are closed without the effect. Curves without breakage take little time, and
   several pairs are used; otherwise only one pair is used.

One pair does not show the scatter between pairs. Therefore its change counts twice. Crushing on
the first cycle determines the second cycle, so that without interaction one pair may close a
tenth less there and the next pair a tenth more. This effect grows with the difference between the
cycles: the error of a mean over 20 pairs is then about a sixteenth of (largest - least) /
(largest + least), twice its standard error (measured at 60 random conditions that are in no
test). If this alone exceeds the tolerance, nothing is tried.

An effect is left out if this changes the mean maximum closure of no cycle by more than a
tolerance, where all effects left out before it stay out.
"""

import itertools
import time
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.ensemble.cases import BASE
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import Conditions, conditions_from, takes_conditions
from jointclosure.joint.given_walls import checked_walls, warn_of_doubts
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    Effects,
    check_scene,
    well_posed_scenes,
)

DROPS = (("breakage", "gouge"), ("interaction",), ("substrate",))
"""Effects that are tried to be left out, in the order of the time that this saves (results of the
study of effects). Gouge and soft peaks cost nothing and are kept if anything breaks, and so is the
substrate, because simulations without it then fail."""
ELASTIC_TRIALS = 4
"""Number of pairs of walls that are closed without an effect if nothing breaks; otherwise one."""
MARGIN = 2.0
"""Factor on the change of a single pair, which does not show the scatter between pairs."""
DIVERGENCE = 1.0 / 16.0
"""Error of a mean without interaction due to chance, over the relative difference of the cycles."""
_CLEAR = 2.0
"""Number of tolerances, including the margin, from which the change of the first pair is sufficient
and no other pairs are closed."""


def possible_scenes(effects: Effects, chosen: bool = True) -> list[Effects]:
    """Return the scenes that may be selected from these effects, with all of them first.

    If they are not to be ``chosen``, only all of them together.
    """
    scenes = [effects]
    for scene in scenes if chosen else ():
        for names in DROPS:
            fewer = _without(scene, names)
            if fewer is not None and fewer not in scenes:
                scenes.append(fewer)
    return scenes


def _without(scene: Effects, names: tuple[str, ...]) -> Effects | None:
    """Return a scene without some effects; None if this is not tried."""
    fewer = scene._replace(**dict.fromkeys(names, False))
    fails = "substrate" in names and scene.breakage
    return None if fewer == scene or fails or fewer not in well_posed_scenes() else fewer


class Closed(NamedTuple):
    """Pair of walls that was closed with all effects.

    It is the result of `jointclosure.simulate`, and the processor time [s].
    """

    dataset: xr.Dataset
    seconds: float


class SceneChoice(NamedTuple):
    """Effects selected for a case, their estimated error, and reasons.

    ``error`` is the relative error of the mean maximum closure, the largest over the cycles, with a
    margin; 0 if all effects act. ``reasons`` has a sentence for every group of effects that was
    tried to be left out. ``closed`` contains the first pairs of walls, closed with all effects.
    ``trial_seconds`` is the time of closures without some effects, which is lost if all effects
    act.
    """

    effects: Effects
    error: float
    reasons: tuple[str, ...]
    closed: tuple[Closed, ...] = ()
    trial_seconds: float = 0.0


@takes_conditions
def choose_effects(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    *,
    conditions: Conditions | None = None,
    tolerance: float = AUTO_TOLERANCE,
    report: Callable[[str], None] = lambda line: None,
    **changes: Any,
) -> SceneChoice:
    """Select the effects that matter in a scene.

    Parameters
    ----------
    walls : iterable of (upper, lower)
        Pairs of walls (y, x) [m] of the case; only as many as necessary are closed.
    conditions, **changes
        As for `jointclosure.simulate`. ``effects`` may act; they are the reference.
    tolerance : float
        Relative change of the mean maximum closure of a cycle, in (0, 1), below
        which an effect does not matter.
    report : callable
        Receives a line for each decision.

    Raises
    ------
    InputError
        If the tolerance is out of range, there are no walls, or `jointclosure.simulate` refuses
        an argument.
    """
    stated = conditions_from(conditions, changes, "choose_effects", "spacing")
    stated = stated._replace(seating_stress=0.0)
    spacing = stated.grid_spacing
    pairs = _checked_pairs(walls, spacing)
    stated = stated.checked()
    if not stated.unusual_values:
        for pair in pairs:
            warn_of_doubts(*pair, spacing)
    return choose_among(pairs, stated, tolerance, report)


def choose_among(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    conditions: Conditions,
    tolerance: float,
    report: Callable[[str], None] = lambda line: None,
) -> SceneChoice:
    """Select, as `choose_effects`, among the effects of the conditions of the closures."""
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
        moved = f"changes by {why}" if np.isfinite(off) else "cannot be computed"
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
    """Return the relative error without some effects, and its reason, from cheap evidence."""
    least = pilot.shown(names)
    if MARGIN * least > tolerance:
        counted = f"{MARGIN:g} times {100.0 * least:.2g} %"
        return (
            MARGIN * least,
            f"{counted} (estimated from one run with all effects, therefore doubled)",
        )
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
    """Select effects for a case of a study, among its effects and to its tolerance.

    Raises
    ------
    InputError
        If the study does not select effects.
    """
    tolerance = settings.effects_chosen_to
    if tolerance is None:
        raise InputError("effects.auto = null: must be a tolerance to select effects")
    return choose_among(walls_of(settings.surfaces), settings.conditions(), tolerance, report)


class RockChoice(NamedTuple):
    """Effects for all cases of a rock, and their estimated error.

    ``cases`` are the choices of the cases that were examined.
    """

    effects: Effects
    error: float
    cases: dict[str, SceneChoice]


def choose_for_rock(
    settings: dict[str, ClosureSettings], report: Callable[[str], None] = lambda line: None
) -> RockChoice:
    """Make one selection for all cases of a rock, because these are compared with each other.

    Parameters
    ----------
    settings : dict
        Settings of each case by its label.
    report : callable
        Receives a line for each decision.

    Returns
    -------
    RockChoice
        Effects that matter in any case. The base case is examined first. If all effects act in
        an examined case, the remaining cases are not examined.
    """
    allowed = next(iter(settings.values())).case.effects
    by_case: dict[str, SceneChoice] = {}
    together = Effects(*[False] * len(Effects._fields))
    for label in sorted(settings, key=lambda label: settings[label].case.parameter != BASE):
        report(f"{label}:")
        by_case[label] = choose_for_case(settings[label], report)
        together = Effects(*map(any, zip(together, by_case[label].effects, strict=True)))
        if together == allowed:
            break
    report(f"for all cases, {len(by_case)} of {len(settings)} examined: {together}")
    error = max(choice.error for choice in by_case.values()) if together != allowed else 0.0
    return RockChoice(together, error, by_case)


def _checked_pairs(
    walls: Iterable[tuple[np.ndarray, np.ndarray]], spacing: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return as many checked pairs of walls as a pilot may close."""
    pairs = list(itertools.islice(walls, ELASTIC_TRIALS))
    if not pairs:
        raise InputError("walls: 0 pairs, must be at least one")
    for pair in pairs:
        if len(pair) != 2 or np.ndim(pair[0]) != 2:
            raise InputError(
                f"walls: has an array of shape {np.shape(pair[0])}, must be walls (y, x) in a list "
                "of pairs, such as [(upper, lower)]"
            )
    return [checked_walls(*pair, spacing) for pair in pairs]


class _Pilot:
    """Pairs of walls that are closed in the required scenes, at most once."""

    def __init__(self, pairs: list[tuple[np.ndarray, np.ndarray]], conditions: Conditions):
        self.pairs, self.conditions = pairs, conditions
        self.closed: list[Closed] = []
        self.trial_seconds = 0.0
        self._known: dict[Effects, list[np.ndarray]] = {}

    def shown(self, names: tuple[str, ...]) -> float:
        """Return a lower bound of the change of closure [1] without some effects.

        It is from the run with all effects; 0 if that shows no change.
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
        """Return relative changes of closure (pair, cycle) [1] from all effects to a scene."""
        full, rows = self._full(count), self._known.setdefault(scene, [])
        numerics = self.conditions.numerics
        if not scene.breakage:
            # only the maximum is needed
            numerics = numerics._replace(curve_points=1, solver="fast")
        conditions = self.conditions._replace(effects=scene, numerics=numerics)
        start = time.process_time()
        rows += [max_closures(close_walls(*p, conditions)) for p in self.pairs[len(rows) : count]]
        self.trial_seconds += time.process_time() - start
        return (np.array(rows[:count]) - full) / full.mean(axis=0)

    def _full(self, count: int) -> np.ndarray:
        """Return maximum closures (pair, cycle) [m] of the first pairs with all effects."""
        for pair in self.pairs[len(self.closed) : count]:
            start = time.process_time()
            dataset = close_walls(*pair, self.conditions)
            self.closed.append(Closed(dataset, time.process_time() - start))
        return np.array([max_closures(pair.dataset) for pair in self.closed[:count]])


def max_closures(closed: xr.Dataset) -> np.ndarray:
    """Return maximum closures (cycle,) [m] of a simulation; NaN if it failed."""
    return np.where(int(closed.status) >= FAILURE, np.nan, closed.max_closure.values)
