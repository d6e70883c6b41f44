"""States of a joint at rest, judged by the oracle while a solver closes it."""

import math

import numpy as np
import xarray as xr

from jointclosure.engine import oracle
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import LOADING
from jointclosure.joint.simulation import height_datum
from jointclosure.solvers.elastic import ELASTIC_TOLERANCE
from jointclosure.solvers.fast import BAND
from jointclosure.solvers.joint import CONVERGED, CRUSHED, Joint, Settled
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
_LARGEST_JUDGED = 2500
"""Number of contacts above which only every tenth state is judged, because the oracle is dense."""
_LARGEST_CURVE = 20_000
"""Number of cells in contact above which no snapshot is judged; number of cells above which only
the first, middle and last point of an elastic curve are."""


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


class Judge:
    """Oracle applied to many states of one joint.

    ``worst`` stores, for each field of `oracle.Verdict`, the value closest to its limit or furthest
    beyond it, and ``limits`` this limit: both may differ from state to state. ``states`` counts the
    judged states.
    """

    def __init__(self, given: oracle.Joint, tolerances: dict[str, float]):
        self._given, self._tolerances = given, tolerances
        self.worst: dict[str, float] = {}
        self.limits: dict[str, float] = {}
        self.states = 0

    def __call__(self, state: oracle.State) -> None:
        verdict = oracle.judge(self._given, state)
        limits = limits_of(verdict, self._given.effects, self._tolerances)
        for name, value in verdict._asdict().items():
            limit, worst = limits.get(name, 0.0), self.worst.get(name, -np.inf)
            if not _share(value, limit) <= _share(worst, self.limits.get(name, 0.0)):
                self.worst[name], self.limits[name] = value, limit
        self.states += 1

    @property
    def ratio(self) -> float:
        """Largest number over its limit; infinite for a number above a limit of 0.

        Numbers that are only reported, whose limit is infinite, do not count.
        """
        both = zip(self.worst.values(), self.limits.values(), strict=True)
        judged = [(value, limit) for value, limit in both if limit < math.inf and (value or limit)]
        return float(np.max([value / limit if limit else math.inf for value, limit in judged]))


def _share(value: float, limit: float) -> float:
    """Return a number over its limit; itself if the limit is 0, or infinite (only reported)."""
    return value / limit if 0.0 < limit < np.inf else value


class JudgedSolver:
    """Solver whose states at rest are all judged."""

    def __init__(self, inner, judge: Judge):
        self._inner, self._show = inner, judge
        self._seen = 0
        self.elastic_curve = self._elastic_curve if inner.elastic_curve else None
        self.predict = inner.predict

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Settle as the solver, and judge the state."""
        settled = self._inner.settle(joint, closure, breakage_step)
        self._judge(joint, settled)
        return settled

    def _elastic_curve(self, joint: Joint, targets: np.ndarray) -> list[Settled]:
        # a curve keeps only the forces of its last point: each point is solved again, and judged
        # with closure and total force of the whole curve; only a few points of large joints
        settled = self._inner.elastic_curve(joint, targets)
        self._judge(joint, settled[-1])
        last = joint.force.copy()
        parts = list(range(1, len(settled)))
        if joint.upper.size > _LARGEST_CURVE:
            parts = sorted({1, targets.size // 2} & set(parts))
        for part in parts:
            self._inner.elastic_curve(joint, targets[:part])
            self._judge(joint, settled[part - 1])
        joint.force[:] = last
        return settled

    def _judge(self, joint: Joint, settled: Settled) -> None:
        self._seen += 1
        if settled.outcome != CONVERGED or (
            settled.contacts > _LARGEST_JUDGED and self._seen % 10 != 1
        ):
            return
        state = joint.upper, joint.lower, joint.force, settled.closure, settled.total_force
        self._show(oracle.State(*state, joint.peaks >= CRUSHED))


def oracle_ratio(walls: Walls, closed: xr.Dataset, conditions: Conditions) -> float:
    """Return the oracle's largest number over its limit, at the first maximum.

    NaN for more cells in contact than it can judge, and where breakage passed the maximum.
    """
    loaded = closed.isel(snapshot=closed.snapshot_branch.values == LOADING)
    if not loaded.sizes["snapshot"]:
        return math.nan
    snapshot, area = loaded.isel(snapshot=0), walls[0].size * conditions.grid_spacing**2
    force, step = snapshot.snapshot_force.values, int(snapshot.snapshot_step)
    if np.count_nonzero(force) > _LARGEST_CURVE:
        return math.nan
    datums = [height_datum(wall) for wall in walls]  # the solver sees walls without them
    broken = snapshot.snapshot_upper.values - datums[0], snapshot.snapshot_lower.values - datums[1]
    upper, lower = (wall - datum for wall, datum in zip(walls, datums, strict=True))
    model = conditions.rock, conditions.effects, conditions.choices
    judge = Judge(
        oracle.Joint(upper, lower, conditions.grid_spacing, *model),
        tolerances_of(conditions.effects, conditions.numerics),
    )
    total = float(closed.normal_stress[step]) * area
    judge(oracle.State(*broken, force, float(closed.closure[step]), total))
    return judge.ratio
