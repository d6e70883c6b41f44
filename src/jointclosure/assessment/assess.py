"""Assessment of a scene: what accuracy costs on it, how hard it is, and which effects it needs.

The same walls are simulated with variants of the scene: with other numerics, without an effect, and
as copies whose results would be equal but for the order of breakage. `Assessment` compares them.
"""

import itertools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pandas as pd

from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.effect_names import without
from jointclosure.assessment.hardness import FEATURES
from jointclosure.assessment.numerical_settings import FINEST, REFINEMENT, ladder_about, named
from jointclosure.assessment.verdicts import CAN_BE_LEFT_OUT
from jointclosure.compilation.code_digests import code_digest
from jointclosure.ensembles.simulation import Reading, Row, simulate_row
from jointclosure.execution.workers import Failed, in_processes, number_of_workers
from jointclosure.inputs import InputError, check_below
from jointclosure.joint.checked_conditions import CheckedConditions, on_grid
from jointclosure.joint.conditions import (
    SCAN_DEFAULTS,
    Changes,
    Conditions,
    conditions_from,
    takes_scans,
)
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.wall_checks import checked_walls
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.parameters import RESOLVED
from jointclosure.storage.files import digest
from jointclosure.uncertainty.expected_cost import relative_cost
from jointclosure.uncertainty.sources import coarser
from jointclosure.uncertainty.variants import COPIES
from jointclosure.walls import Walls
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.wall_files import registered_walls

MOST_BREAKAGE_STEPS = 2e4
"""Breakage steps, over the number of cells, after which a joint without an effect is given up.

That is half a minute for 100 x 100 cells. Most joints with all effects need 10 to 1000. Without
interaction, joints of weak rock can need 300 000, as their gouge then breaks again and again.
"""
DROPS = (
    ("gouge",),
    ("breakage", "gouge"),
    ("interaction",),
    ("substrate", "interaction"),
    ("soft_peaks",),
)
"""Effects that are left out together."""
_Task = tuple[str, int, str]
"""Variant, joint and copy of its walls."""
READ = (*ASSESSED, *FEATURES[:-1], "status", "timing_simulation", "oracle_ratio")
"""Quantities that are read from every simulation; the last one only from walls as they are."""


@takes_scans
def assess(
    walls: Any,
    *,
    conditions: Conditions | CheckedConditions | None = None,
    within: float = 0.05,
    budget: float | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
    **changes: Unpack[Changes],
) -> Assessment:
    """Assess a joint: what accuracy costs, how reliable its closure is, and which effects it needs.

    The joint is simulated with several numerical settings, without groups of effects, and as copies
    that should give equal results (docs/accuracy.md#your-own-joint).

    Parameters
    ----------
    walls : (upper, lower), or list of such pairs
        Arrays (y, x) of heights towards the other wall [m]; or two scans as for
        `jointclosure.close`.
    within : float
        Requested relative error of closures, and relative change up to which an effect can be left
        out, in (0, 1). Errors of a lone joint contain that of the finest setting; those of means
        are differences from the finest setting.
    budget : float, optional
        Processor time in seconds of the joint, or of all joints of a mean for several pairs of
        walls. If given, the most accurate setting within this time is named, in place of the
        cheapest one within the request.
    folder : path, optional
        Existing folder where simulated joints are kept, so that an interrupted assessment can
        continue.
    workers : int, optional
        Number of processes, by default that of the processors available to this process.
    report : callable
        Receives the finished share and the variant that was simulated.
    conditions, **changes
        As for `jointclosure.simulate`. Without ``conditions`` breakage is resolved, unless
        ``numerics`` are given; ``conditions`` keep their numerics, by default the paper's steps.

    Returns
    -------
    Assessment

    Raises
    ------
    InputError
        If an argument is out of its range or a scan cannot be read.
    """
    stated = conditions_from(conditions, changes, "assess", defaults=SCAN_DEFAULTS)
    given = checked_request(stated, within, budget)
    number_of_workers(workers)
    if folder is not None and not Path(folder).is_dir():
        raise InputError(f"folder = {str(folder)!r}: must be an existing folder")
    pairs, spacing = checked_pairs(walls, given)
    return assess_as_checked(
        pairs, on_grid(given, spacing), within, budget, folder, workers, report
    )


def assess_as_checked(
    pairs: Sequence[Walls],
    given: CheckedConditions,
    within: float = 0.05,
    budget: float | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
    forecast: Callable[[int, float], None] = lambda joints, seconds: None,
) -> Assessment:
    """Assess joints as `assess`, of checked pairs of walls under conditions on their grid.

    The conditions, ``within`` and ``budget`` are those of `checked_request`. The first joint is
    simulated as stated before all others. From its time ``forecast`` then receives how many joints
    are to be simulated, and the processor time [s] that they are expected to take. This is several
    times too short for joints that take long by the paper's steps or without an effect.
    """
    without_flow = given._replace(flow=False)
    setting, ladder, variants = assessed_variants(without_flow)

    def simulated(variants: Mapping[str, CheckedConditions], tasks: list[_Task]) -> pd.DataFrame:
        return closures_of(tasks, setting, variants, pairs, folder, workers, report)

    def tasks_of(variants: Mapping[str, CheckedConditions]) -> list[_Task]:
        return [
            (name, joint, copy)
            for name, joint in itertools.product(variants, range(len(pairs)))
            for copy in (COPIES if name == setting or len(pairs) == 1 else ["as it is"])
        ]

    first = (setting, 0, "as it is")
    of_first = simulated({setting: variants[setting]}, [first])
    others = [task for task in tasks_of(variants) if task != first]
    relative_time = sum(_relative_cost(variants[name]) for name, *_ in others)
    first_seconds = float(of_first.seconds.iloc[0])
    forecast(len(others), first_seconds * relative_time / _relative_cost(variants[setting]))
    closures = pd.concat([of_first, simulated(variants, others)], ignore_index=True)
    found = Assessment(closures, ladder, setting, within, budget)
    together = without_together(found, without_flow)
    if together.keys() <= variants.keys():
        return found
    further = simulated(together, tasks_of(together))
    closures = pd.concat([closures, further], ignore_index=True)
    return Assessment(closures, ladder, setting, within, budget)


def _relative_cost(conditions: CheckedConditions) -> float:
    return relative_cost(conditions.effects, conditions.numerics)


def _warmed_row(walls: Walls, reading: Reading) -> Row:
    """Return the row of a joint, whose time does not contain that of loading the kernels."""
    prepare_kernels([reading.conditions.model])
    return simulate_row(walls, reading)


def checked_request(
    stated: Conditions, within: float = 0.05, budget: float | None = None
) -> CheckedConditions:
    """Return the checked conditions of an assessment.

    Raise `InputError` if they, the requested error [1] or the budget [s] are not allowed.
    """
    check_below("within", within, 1.0, " (0.05 stands for 5 %)")
    if budget is not None:
        check_below("budget", budget, 1e9, " s")  # thirty years
    return checked_as_stated(stated, varied=True)


def assessed_variants(
    given: CheckedConditions,
) -> tuple[str, list[str], dict[str, CheckedConditions]]:
    """Return the variants of a scene.

    They are the name of the stated setting, the names of all settings (the finest last), and the
    conditions of all variants by name.
    """
    variants = {"as stated": given}
    if given.effects.breakage:
        points = given.numerics.curve_points  # of elastic curves, no part of a setting
        finer = given.numerics.tolerance < FINEST.tolerance
        resolved = given.numerics.breakage == "resolved"
        middle = coarser(given.numerics, REFINEMENT) if resolved and finer else RESOLVED
        settings = {
            name: given._replace(numerics=numerics._replace(curve_points=points))
            for name, numerics in ladder_about(middle).items()
        }
        variants = _with_stated(settings, given)
    stated = next(name for name, variant in variants.items() if variant == given)
    ladder = list(variants)
    for names in DROPS:
        variants |= _without_effects(given, names)
    return stated, ladder, variants


def _without_effects(
    given: CheckedConditions, names: Sequence[str]
) -> dict[str, CheckedConditions]:
    """Return the variant without effects by its name, if they act and it has an equilibrium."""
    acting = [name for name in names if getattr(given.effects, name)]
    fewer = given.effects._replace(**dict.fromkeys(acting, False))
    # joints that break have no equilibrium without a substrate
    if not acting or (fewer.breakage and not fewer.substrate):
        return {}
    most = min(given.numerics.most_breakage_steps, MOST_BREAKAGE_STEPS)
    numerics = given.numerics._replace(most_breakage_steps=most)
    return {without(acting): given._replace(effects=fewer, numerics=numerics)}


def without_together(
    assessment: Assessment, given: CheckedConditions
) -> dict[str, CheckedConditions]:
    """Return the variant without all effects that can each be left out, if there are several."""
    left_out = [
        names
        for names in DROPS
        for variant in _without_effects(given, names)
        if assessment.verdict(variant) == CAN_BE_LEFT_OUT
    ]
    every = {name for names in left_out for name in names}
    together = [name for name in given.effects._fields if name in every]
    return _without_effects(given, together) if len(left_out) > 1 else {}


def _with_stated(
    settings: dict[str, CheckedConditions], given: CheckedConditions
) -> dict[str, CheckedConditions]:
    """Return settings of the numerics, ordered by their accuracy, among which is the stated one.

    Resolved breakage as stated takes the place of the setting with its tolerance, from which it may
    differ in its first steps.
    """
    if given in settings.values():
        return settings
    if given.numerics.breakage != "resolved":
        return {"as stated": given} | settings
    every = settings | {named(given.numerics): given}
    coarse = [name for name, one in every.items() if one.numerics.breakage != "resolved"]
    resolved = sorted(every.keys() - coarse, key=lambda name: -every[name].numerics.tolerance)
    return {name: every[name] for name in (*coarse, *resolved)}


def checked_pairs(walls: Any, conditions: CheckedConditions) -> tuple[list[Walls], float]:
    """Return checked pairs of walls and their spacing [m]; scans are registered.

    Raise `InputError` if there are no pairs, walls are not allowed, or arrays have no spacing in
    the checked ``conditions``.
    """
    spacing = conditions.spacing
    # scans are tuples too
    one_pair = len(walls) == 2 and (
        isinstance(walls[0], Scan | Cloud) or not isinstance(walls[0], tuple | list)
    )
    pairs: Any = [walls] if one_pair else walls
    if isinstance(walls, np.ndarray) or any(len(pair) != 2 for pair in pairs):
        raise InputError("walls: must be (upper, lower), or a list of such pairs")
    if len(pairs) == 1 and not all(isinstance(wall, np.ndarray) for wall in pairs[0]):
        upper, lower = pairs[0]
        unusual = conditions.unusual_values
        pair = registered_walls(upper, lower, {}, spacing, unusual_values=unusual)
        return [(pair.upper, pair.lower)], pair.spacing
    if spacing is None:
        raise InputError("spacing = None: must be given for walls that are arrays")
    if not len(pairs):
        raise InputError("walls: 0 pairs, must be at least one")
    return [checked_walls(upper, lower, spacing) for upper, lower in pairs], spacing


def closures_of(
    tasks: Sequence[_Task],
    stated: str,
    variants: Mapping[str, CheckedConditions],
    pairs: Sequence[Walls],
    folder: str | Path | None = None,
    workers: int | None = 1,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> pd.DataFrame:
    """Return `Assessment.closures` of tasks (variant, joint, copy).

    Those that the folder keeps are not simulated again. Raise `InputError` if the stated variant of
    a pair cannot be simulated.
    """
    processes = number_of_workers(workers)
    kept = dict[str, Any]()
    file = Path(folder) / "closures.jsonl" if folder else None
    for line in file.read_text(encoding="utf-8").splitlines() if file and file.exists() else ():
        if line.endswith("}}"):  # another one was cut off
            entry = json.loads(line)
            kept[entry["key"]] = entry["row"]
    code = code_digest("jointclosure.ensembles.simulation:simulate_row")
    walls = [digest(*(wall.tobytes() for wall in pair)) for pair in pairs]
    keys = {(v, j, copy): digest(code, walls[j], copy, variants[v]) for v, j, copy in tasks}
    missing = [task for task in tasks if keys[task] not in kept]
    asked = [
        (
            tuple(COPIES[copy](wall) for wall in pairs[joint]),
            Reading(variants[name], READ if copy == "as it is" else READ[:-1]),
        )
        for name, joint, copy in missing
    ]
    # before processes need them, which would each compile them
    prepare_kernels({variants[name].model for name, *_ in missing}, processes)
    for done, (at, row) in enumerate(in_processes(_warmed_row, asked, processes), start=1):
        name = missing[at][0]
        key = keys[missing[at]]
        if isinstance(row, Failed):
            if name == stated and isinstance(row.error, InputError):
                raise row.error  # no scene, and nothing to compare
            row = {"error": str(row.error)}
        kept[key] = {quantity: np.asarray(values).tolist() for quantity, values in row.items()}
        if file:
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps({"key": key, "row": kept[key]}) + "\n")
        report(done / len(missing), name)
    parts = []
    for (name, joint, copy), key in keys.items():
        cycles = np.arange(1, variants[name].cycle_count + 1)
        row = {"variant": name, "joint": joint, "copy_of_walls": copy, "cycle": cycles, "error": ""}
        parts.append(pd.DataFrame(row | dict.fromkeys(READ, math.nan) | kept[key]))
    return pd.concat(parts, ignore_index=True).rename(columns={"timing_simulation": "seconds"})
