"""Limits of the numbers of the oracle, and the state of a joint that it judges."""

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from jointclosure.engine import oracle
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import LOADING
from jointclosure.joint.simulation import height_datum
from jointclosure.solvers.elastic import ELASTIC_TOLERANCE
from jointclosure.solvers.fast import BAND
from jointclosure.solvers.registry import solver_named
from jointclosure.walls.pairs import Walls

VOLUME_TOLERANCE = 1e-12
STRENGTH_TOLERANCE = 1e-6
"""Allowed relative excess over strength of a contact at rest, due to the last change of the
interaction."""
LOAD_TOLERANCE = 1e-12
ROUNDINGS = 16.0
"""Allowed error of an overlap, in units in the last place of the heights."""
SOLVED = 1.01
"""Allowed residual over a solver's tolerance; the solver sums its residual in another order."""
_MOST_CONTACTS = 20_000
"""Number of cells in contact above which no snapshot is judged, because the oracle is dense."""


def limits_of(verdict, effects, tolerances: dict[str, float]) -> dict[str, float]:
    """Return the limits of the numbers of an `oracle.Verdict`, by name; others are 0.

    Forces may have the error of the solver's tolerance plus the effect of the last digits of the
    heights. ``rounding`` and, if broken material vanishes, ``volume`` are only reported.
    """
    digits = ROUNDINGS * verdict.rounding
    solved = SOLVED * tolerances["residual"] + digits
    lost = effects.breakage and not effects.gouge
    return {
        "residual": solved,
        "without_overlap": solved,
        "without_force": solved,
        "rounding": np.inf,
        "load": LOAD_TOLERANCE,
        "volume": np.inf if lost else VOLUME_TOLERANCE if effects.breakage else 0.0,
        "strength": STRENGTH_TOLERANCE + tolerances["strength"] + digits,
    }


def tolerances_of(effects, numerics, by_stress: bool = True) -> dict[str, float]:
    """Return the limits of the oracle's numbers that follow from effects and numerics, by name.

    ``by_stress``: whether stresses were solved for, and not a closure.
    """
    residual = numerics.force_tolerance
    if by_stress and not effects.breakage and solver_named(numerics.solver).elastic_curve:
        residual = min(residual, ELASTIC_TOLERANCE)
    resolved = numerics.breakage == "resolved"
    return {"residual": residual, "strength": 0.5 * BAND * numerics.tolerance if resolved else 0.0}


def largest_ratio(numbers: Mapping[str, float], limits: Mapping[str, float]) -> float:
    """Return the largest number over its limit; infinite for a number above a limit of 0.

    Numbers that are only reported, whose limit is infinite, do not count.
    """
    both = ((value, limits.get(name, 0.0)) for name, value in numbers.items())
    judged = [(value, limit) for value, limit in both if limit < math.inf and (value or limit)]
    return float(np.max([value / limit if limit else math.inf for value, limit in judged]))


def oracle_ratio(walls: Walls, closed: xr.Dataset, conditions: Conditions) -> float:
    """Return the oracle's largest number over its limit, at the first maximum.

    NaN for more cells in contact than it can judge, and where breakage passed the maximum.
    """
    loaded = closed.isel(snapshot=closed.snapshot_branch.values == LOADING)
    if not loaded.sizes["snapshot"]:
        return math.nan
    snapshot, area = loaded.isel(snapshot=0), walls[0].size * conditions.grid_spacing**2
    force, step = snapshot.snapshot_force.values, int(snapshot.snapshot_step)
    if np.count_nonzero(force) > _MOST_CONTACTS:
        return math.nan
    datums = [height_datum(wall) for wall in walls]  # the solver sees walls without them
    broken = snapshot.snapshot_upper.values - datums[0], snapshot.snapshot_lower.values - datums[1]
    upper, lower = (wall - datum for wall, datum in zip(walls, datums, strict=True))
    model = conditions.rock, conditions.effects, conditions.choices
    joint = oracle.Joint(upper, lower, conditions.grid_spacing, *model)
    total = float(closed.normal_stress[step]) * area
    verdict = oracle.judge(joint, oracle.State(*broken, force, float(closed.closure[step]), total))
    tolerances = tolerances_of(conditions.effects, conditions.numerics)
    return largest_ratio(verdict._asdict(), limits_of(verdict, conditions.effects, tolerances))
