"""Assessment of a scene: what accuracy costs on it, how hard it is, and which effects it needs.

The same walls are closed by variants of the scene: with other numerics, without an effect, and as
copies that must close alike. All results are read from the differences between variants on the same
walls (`jointclosure.engine.assessment`). A lone joint is compared on its copies, whose scatter is
that of the order of breakage; several joints are compared as they are.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pandas as pd

from jointclosure.compilation.sources import code_digest
from jointclosure.engine.assessment import (
    ASSESSED,
    FEATURES,
    REFINEMENT,
    Assessment,
    assessed,
)
from jointclosure.engine.cache import digest
from jointclosure.engine.joints import Reading, close_joint
from jointclosure.engine.scanned_joint import RESOLVED, registered_walls
from jointclosure.engine.uncertainty import coarser
from jointclosure.engine.walls import COPIES, Walls
from jointclosure.engine.workers import Failed, number_of_workers, shared
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import (
    Changes,
    Conditions,
    conditions_from,
    takes_conditions,
)
from jointclosure.joint.given_walls import checked_walls
from jointclosure.joint.warmup import compile_kernels
from jointclosure.parameters import Numerics

DROPS = (
    ("gouge",),
    ("breakage", "gouge"),
    ("interaction",),
    ("substrate", "interaction"),
    ("soft_peaks",),
)
"""Effects that are left out together."""
LARGEST_BUDGET = 1e9
"""Processor time [s] that no budget exceeds: thirty years."""
READ = (*ASSESSED, *FEATURES[:-1], "status", "timing_simulation", "oracle_ratio")
"""Quantities that are read of every closure; the last one only where states are judged."""


def resolved(tolerance: float) -> Numerics:
    """Return resolved numerics whose first steps shrink with the tolerance."""
    return coarser(RESOLVED, tolerance / RESOLVED.tolerance)


LADDER = {"the paper's steps": Numerics()} | {
    f"tolerance {tolerance:g}": resolved(tolerance)
    for tolerance in (RESOLVED.tolerance * REFINEMENT**power for power in (1, 0, -1))
}
"""Settings of the numerics that are compared, from the cheapest to the finest."""
FINEST = list(LADDER.values())[-1]


@takes_conditions
def assess(
    walls: Any,
    *,
    conditions: Conditions | None = None,
    within: float = 0.05,
    budget: float | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
    **changes: Unpack[Changes],
) -> Assessment:
    """Say what accuracy costs on a scene, how hard it is, and which effects it needs.

    Parameters
    ----------
    walls : (upper, lower), or list of such pairs
        Arrays (y, x) of heights towards the other wall [m]; or two scans as for
        `jointclosure.close`.
    within : float
        Relative error that is requested of mean closures, and up to which an effect can be left
        out, in (0, 1).
    budget : float, optional
        Processor time [s] whose use is described instead.
    folder : path, optional
        Existing folder where closures are kept, so that an interrupted assessment goes on.
    workers : int, optional
        Number of processes, by default that of the processors available to this process.
    report : callable
        Receives the finished share and the variant that was closed.
    conditions, **changes
        As for `jointclosure.simulate`; breakage is resolved unless ``numerics`` are given.

    Returns
    -------
    Assessment

    Raises
    ------
    InputError
        If an argument is out of its range or a scan cannot be read.
    """
    changes = changes if conditions else {"numerics": RESOLVED} | changes
    given = conditions_from(conditions, changes, "assess")
    check_request(given, within, budget)
    if folder is not None and not Path(folder).is_dir():
        raise InputError(f"folder = {str(folder)!r}: must be an existing folder")
    pairs, spacing = checked_pairs(walls, given.spacing)
    given = given._replace(spacing=spacing, flow=False).checked()
    stated, ladder, variants = variants_of(given)
    tasks = [
        (name, joint, copy)
        for name in variants
        for joint in range(len(pairs))
        for copy in (COPIES if name == stated or len(pairs) == 1 else ["as it is"])
    ]
    closures = closures_of(tasks, stated, variants, pairs, folder, workers, report)
    return assessed(closures, ladder, stated, within, budget)


def check_request(given: Conditions, within: float = 0.05, budget: float | None = None) -> None:
    """Raise `InputError` if conditions, a requested error [1] or a budget [s] are not allowed."""
    asked: dict[str, tuple[float, float]] = {"within": (within, 1.0)}
    if budget is not None:
        asked["budget"] = budget, LARGEST_BUDGET
    for name, (value, most) in asked.items():
        check_number(name, value)
        if not 0.0 < value < most:
            raise InputError(f"{name} = {value!r}: must lie between 0 and {most:g}")
    given.checked()


def variants_of(given: Conditions) -> tuple[str, list[str], dict[str, Conditions]]:
    """Return the names of the stated variant and of all settings, finest last, and all variants.

    Joints that break have no equilibrium without a substrate.
    """
    variants = {"as stated": given}
    if given.effects.breakage:
        points = given.numerics.curve_points  # of elastic curves, no part of a setting
        settings = {
            name: given._replace(numerics=numerics._replace(curve_points=points))
            for name, numerics in LADDER.items()
        }
        variants = settings if given in settings.values() else variants | settings
    stated = next(name for name, variant in variants.items() if variant == given)
    ladder = list(variants)
    for names in DROPS:
        acting = [name for name in names if getattr(given.effects, name)]
        fewer = given.effects._replace(**dict.fromkeys(acting, False))
        if acting and (fewer.substrate or not fewer.breakage):
            name = f"without {' and '.join(acting)}".replace("_", " ")
            variants[name] = given._replace(effects=fewer)
    return stated, ladder, variants


def checked_pairs(walls: Any, spacing: float | None) -> tuple[list[Walls], float]:
    """Return checked pairs of walls and their spacing [m]; scans are registered."""
    pairs: Any = [walls] if len(walls) == 2 and not isinstance(walls[0], tuple | list) else walls
    if isinstance(walls, np.ndarray) or any(len(pair) != 2 for pair in pairs):
        raise InputError("walls: must be (upper, lower), or a list of such pairs")
    if len(pairs) == 1 and not all(isinstance(wall, np.ndarray) for wall in pairs[0]):
        upper, lower = pairs[0]
        pair = registered_walls(upper, lower, {}, spacing)
        return [(pair.upper, pair.lower)], pair.spacing
    if spacing is None:
        raise InputError("spacing = None: must be given for walls that are arrays")
    if not len(pairs):
        raise InputError("walls: 0 pairs, must be at least one")
    return [checked_walls(upper, lower, spacing) for upper, lower in pairs], spacing


def closures_of(
    tasks: Sequence[tuple[str, int, str]],
    stated: str,
    variants: Mapping[str, Conditions],
    pairs: Sequence[Walls],
    folder: str | Path | None = None,
    workers: int | None = 1,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> pd.DataFrame:
    """Return `Assessment.closures` of (variant, joint, copy); what a folder keeps is not closed."""
    processes = number_of_workers(workers)
    file = Path(folder) / "closures.jsonl" if folder else None
    kept = _kept(file)
    code = code_digest(f"{__name__}:close_variant")
    walls = [digest(*(wall.tobytes() for wall in pair)) for pair in pairs]
    keys = [digest(code, walls[joint], copy, variants[name]) for name, joint, copy in tasks]
    places = [place for place, key in enumerate(keys) if key not in kept]
    asked = []
    for name, joint, copy in (tasks[place] for place in places):
        copied = tuple(COPIES[copy](wall) for wall in pairs[joint])
        asked.append((copied, variants[name], copy == "as it is"))
    used = [variant for _, variant, _ in asked]
    for one in {(v.effects, v.choices, v.numerics.solver, v.numerics.breakage) for v in used}:
        compile_kernels(*one)  # before processes need them, and no part of a measured time
    closed = shared(close_variant, asked, processes) if asked else ()
    for done, (place, row) in enumerate(closed, start=1):
        at = places[place]
        if isinstance(row, Failed) and tasks[at][0] == stated and isinstance(row.error, InputError):
            raise row.error  # no scene, and nothing to compare
        kept[keys[at]] = {"error": str(row.error)} if isinstance(row, Failed) else row
        if file:
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps({"key": keys[at], "row": kept[keys[at]]}) + "\n")
        report(done / len(places), tasks[at][0])
    lacking = dict.fromkeys((*READ, "seconds"), math.nan)
    rows = []
    for (name, joint, copy), key in zip(tasks, keys, strict=True):
        cycles = np.arange(1, variants[name].cycle_count + 1)
        about = {"variant": name, "joint": joint, "copy_of_walls": copy, "cycle": cycles}
        rows.append(pd.DataFrame(about | {"error": ""} | lacking | kept[key]))
    return pd.concat(rows, ignore_index=True)


def _kept(file: Path | None) -> dict[str, Any]:
    """Read closures that were kept; a line that was cut off is left out."""
    kept: dict[str, Any] = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file and file.exists() else ():
        if line.endswith("}}"):
            entry = json.loads(line)
            kept[entry["key"]] = entry["row"]
    return kept


def close_variant(walls: Walls, conditions: Conditions, judged: bool) -> dict[str, Any]:
    """Close walls, and return `READ` and the oracle's number, if it is asked, as plain numbers."""
    row = close_joint(walls, Reading(conditions, READ if judged else READ[:-1]))
    row["seconds"] = row.pop("timing_simulation")
    return {name: np.asarray(values).tolist() for name, values in row.items()}
