"""Selection of the effects that a scene needs, by a pilot that loses little if all matter.

The significance of an effect depends on rock, roughness and stress, and on the other effects.
Evidence is collected in the order of its cost:

1. A pair of walls of the case is closed with all effects. This is a realisation of the case,
   which need not be closed again if all effects act.
2. This run shows what need not be tested (`_screened`).
3. Pairs are closed with and without the effect until the change of the mean is known well enough,
   or the time for it is spent (`jointclosure.engine.pilot`). Pairs that were closed with the
   selected effects are realisations of the case.

An effect is left out if this changes the mean maximum closure of no cycle by more than a
tolerance, where all effects left out before it stay out.
"""

import itertools
import json
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.joints import read_joint, reading_of_case, stacked
from jointclosure.engine.pilot import Closed, Pilot, Verdict, closing
from jointclosure.engine.settings import BASE, ClosureSettings
from jointclosure.engine.walls import seeds_of, walls_of
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import Conditions, conditions_from, takes_conditions
from jointclosure.joint.given_walls import checked_walls, warn_of_doubts
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    Effects,
    check_scene,
    well_posed_scenes,
)
from jointclosure.statistics.standard_errors import percent

DROPS = (("breakage", "gouge"), ("interaction",), ("substrate",), ("soft_peaks",))
"""Effects that are tried to be left out, in this order: pairs without breakage take a tenth of the
time, so that the ten that it needs leave time for the others. Gouge costs nothing and is kept if
anything breaks, and so is the substrate, because simulations without it then fail. Soft peaks cost
time only where walls crush and interaction matters, and are kept elsewhere."""
CRUSHED = 0.25
"""Share of bulk indentation in the maximum closure [1] from which soft peaks are tested. Below,
they changed closures by 24 to 340 % at 38 random conditions, above by 3 and 12 % at 2 others."""
BREAKAGE_PAIRS = 10
"""Least number of pairs that are closed before breakage is left out. Where few asperities carry
load, something breaks in some joints only, and their changes are large: an interval of a few pairs
in which nothing broke does not show them."""
BREAKAGE_PART = 0.5
"""Part of the time that may be lost to which the test of breakage, the first one, is limited."""
BULK_SHARE = 1.5
"""Share of bulk indentation in the closure, over the tolerance, from which interaction is kept
without a test. Its other displacements make up for a part of the indentation."""
JOINTS = 20
"""Number of joints of a case that a selection is made for, if it is not given."""
_MOST_PAIRS = 20
"""Number of given pairs of walls that a pilot uses at most."""


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
    free = "soft_peaks" in names and not (scene.breakage and scene.interaction)
    return None if fewer == scene or fails or free or fewer not in well_posed_scenes() else fewer


class SceneChoice(NamedTuple):
    """Effects selected for a case, their estimated error, and reasons.

    ``error`` is an upper limit of the relative error of the mean maximum closure, the largest over
    the cycles (`jointclosure.engine.pilot.CONFIDENCE`); 0 if all effects act. ``reasons`` has a
    sentence for every group of effects that was tried to be left out. ``closed`` contains the first
    pairs of walls, closed with the selected effects. ``lost_seconds`` is the time of closures with
    other effects.
    """

    effects: Effects
    error: float
    reasons: tuple[str, ...]
    closed: tuple[Closed, ...] = ()
    lost_seconds: float = 0.0


@takes_conditions
def choose_effects(
    walls: Iterable[tuple[np.ndarray, np.ndarray]],
    *,
    conditions: Conditions | None = None,
    tolerance: float = AUTO_TOLERANCE,
    joints: int = JOINTS,
    report: Callable[[str], None] = lambda line: None,
    **changes: Any,
) -> SceneChoice:
    """Select the effects that matter in a scene.

    Parameters
    ----------
    walls : iterable of (upper, lower)
        Pairs of walls (y, x) [m] of the case; only as many as necessary are closed. The change of
        a single pair counts twice.
    conditions, **changes
        As for `jointclosure.simulate`. ``effects`` may act; they are the reference.
    tolerance : float
        Relative change of the mean maximum closure of a cycle, in (0, 1), below
        which an effect does not matter.
    joints : int
        Number of joints that will be closed with the selected effects, at least 1. The more they
        are, the more time the selection may take.
    report : callable
        Receives a line for each decision.

    Raises
    ------
    InputError
        If the tolerance or the number of joints is out of range, there are no walls, or
        `jointclosure.simulate` refuses an argument.
    """
    stated = conditions_from(conditions, changes, "choose_effects", "spacing")
    spacing = stated.grid_spacing
    pairs = _checked_pairs(walls, spacing)
    stated = stated.checked()._replace(seating_stress=0.0)
    if not stated.unusual_values:
        for pair in pairs:
            warn_of_doubts(*pair, spacing)
    _check(tolerance, joints, stated.effects)
    return choose_among(Pilot(closing(pairs, stated), stated.effects, joints), tolerance, report)


def _check(tolerance: float, joints: int, effects: Effects) -> None:
    """Raise `InputError` if a selection cannot be made."""
    check_number("tolerance", tolerance)
    check_scene(effects)
    if not 0.0 < tolerance < 1.0:
        raise InputError(f"tolerance = {tolerance!r}: must lie between 0 and 1")
    check_number("joints", joints, whole=True)
    if joints < 1:
        raise InputError(f"joints = {joints}: must be at least 1")


def choose_among(
    pilot: Pilot, tolerance: float, report: Callable[[str], None] = lambda line: None
) -> SceneChoice:
    """Select, as `choose_effects`, among the effects of a pilot."""
    chosen, error, reasons = pilot.effects, 0.0, []
    for names in DROPS:
        fewer = _without(chosen, names)
        if fewer is None:
            continue
        verdict = _screened(pilot, names, fewer, tolerance)
        limits = (BREAKAGE_PAIRS, BREAKAGE_PART) if "breakage" in names else (1, 1.0)
        verdict = verdict or pilot.test(fewer, chosen, tolerance, *limits)
        reasons.append(
            f"without {' and '.join(names)} the mean maximum closure {verdict.reason}: "
            f"{'left out' if verdict.left_out else 'kept'}"
        )
        report(reasons[-1])
        if verdict.left_out:
            chosen, error = fewer, verdict.error
    if chosen == pilot.effects:
        report("every effect matters: all act")
    closed = tuple(pilot.closed[chosen])
    return SceneChoice(chosen, error, tuple(reasons), closed, pilot.lost(chosen))


def _screened(
    pilot: Pilot, names: tuple[str, ...], fewer: Effects, tolerance: float
) -> Verdict | None:
    """Return the verdict if a run with all effects, and an elastic one, suffice for it.

    A joint that only deforms elastically has the same closure in every cycle. Whatever this closure
    is, one of the cycles then has an error of at least (largest - least) / (largest + least). The
    elastic run takes little time, and the change without breakage is mostly the same in every
    joint. Interaction adds bulk indentation, which is 0 without it (`BULK_SHARE`).
    """
    closures = pilot.closures(pilot.effects, 1)[0]
    if not np.isfinite(closures).all():
        return Verdict(False, np.inf, "cannot be computed")
    bulk = pilot.closed[pilot.effects][0].dataset.max_bulk_indentation.values
    share = float(np.max(bulk / closures))
    if "soft_peaks" in names and share < CRUSHED:
        return Verdict(False, np.inf, "is not tested, as this saves little time")
    least, shown = 0.0, "one run with all effects"
    if "breakage" in names:
        least = float(np.ptp(closures) / (closures.max() + closures.min()))
        if least <= tolerance:
            least, shown = float(np.abs(pilot.changes(fewer, 1)).max()), "one pair of walls"
    elif "interaction" in names:
        least = share if share > BULK_SHARE * tolerance else 0.0
    if least <= tolerance:
        return None
    return Verdict(False, least, f"changes by about {percent(least)} or more (from {shown})")


def choose_for_case(
    settings: ClosureSettings,
    report: Callable[[str], None] = lambda line: None,
    joints: int | None = None,
) -> SceneChoice:
    """Select effects for a case of a study, among its effects and to its tolerance.

    ``joints`` is the number of joints that share the selection; by default those of the settings.

    Raises
    ------
    InputError
        If the study does not select effects.
    """
    tolerance = settings.effects_chosen_to
    if tolerance is None:
        raise InputError("effects.auto = null: must be a tolerance to select effects")
    joints = joints or settings.surfaces.realizations
    _check(tolerance, joints, settings.case.effects)
    close = closing(walls_of(settings.surfaces), settings.conditions())
    return choose_among(Pilot(close, settings.case.effects, joints), tolerance, report)


def choose_for_rock(
    settings: dict[str, ClosureSettings], report: Callable[[str], None] = lambda line: None
) -> xr.Dataset:
    """Make one selection for all cases of a rock, because these are compared with each other.

    It is made in the case where effects matter most: that of the largest maximum stress over the
    compressive strength, and the base case among equals. Both the bulk indentation of interaction
    and the breakage grow with this ratio. ``settings`` are those of each case by its label.

    The joints that were closed with the selected effects are returned as from `close_case`, with
    the attributes ``case`` and ``chosen``: JSON of the ``effects``, their ``error``, and the choice
    of the case.
    """

    def order(label: str) -> tuple[float, bool]:
        case = settings[label].case
        ratio = case.max_normal_stress / case.intact.compressive_strength
        return (-round(ratio, 12), case.parameter != BASE)

    label = min(settings, key=order)
    joints = sum(one.surfaces.realizations for one in settings.values())
    report(f"{label}, for {len(settings)} cases of {joints} joints together:")
    choice = choose_for_case(settings[label], report, joints)
    used = settings[label].with_effects(choice.effects)
    surfaces, reading = used.surfaces, reading_of_case(used)
    rows = [
        read_joint(walls, closed.dataset, closed.seconds, reading)
        for walls, closed in zip(walls_of(surfaces), choice.closed, strict=False)
    ]
    numbers = surfaces.first_realization + np.arange(len(rows))
    seeds = [f"{seed:032x}" for seed in seeds_of(surfaces)[: len(rows)]]
    about = {"effects": choice.effects._asdict(), "error": choice.error}
    chosen = about | {"cases": {label: about | {"reasons": choice.reasons}}}
    closed = stacked(rows, numbers, np.array(seeds, dtype=object), reading)
    return closed.assign_attrs(case=label, chosen=json.dumps(chosen))


def _checked_pairs(
    walls: Iterable[tuple[np.ndarray, np.ndarray]], spacing: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return as many checked pairs of walls as a pilot may close."""
    pairs = list(itertools.islice(walls, _MOST_PAIRS))
    if not pairs:
        raise InputError("walls: 0 pairs, must be at least one")
    for pair in pairs:
        if len(pair) != 2 or np.ndim(pair[0]) != 2:
            raise InputError(
                f"walls: has an array of shape {np.shape(pair[0])}, must be walls (y, x) in a list "
                "of pairs, such as [(upper, lower)]"
            )
    return [checked_walls(*pair, spacing) for pair in pairs]
