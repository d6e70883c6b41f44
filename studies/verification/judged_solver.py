"""States of a joint at rest, judged by the oracle while a solver computes them."""

import numpy as np

from jointclosure import oracle
from jointclosure.ensembles.oracle_limits import limits_of
from jointclosure.solvers.joint import CRUSHED, Joint, Outcome, Settled

LARGEST_JUDGED = 2500
"""Number of contacts above which only every tenth state is judged, because the oracle is dense."""
LARGEST_CURVE = 20_000
"""Number of cells above which only the first, middle and last point of an elastic curve are
judged."""


class Judge:
    """Oracle applied to many states of one joint.

    ``worst`` stores, for each field of `oracle.Verdict`, the value closest to its limit or furthest
    beyond it, and ``limits`` this limit: both may differ from state to state. ``states`` counts the
    judged states.
    """

    def __init__(self, given: oracle.PristineJoint, tolerances: dict[str, float]):
        self._given = given
        self._tolerances = tolerances
        self.worst: dict[str, float] = {}
        self.limits: dict[str, float] = {}
        self.states = 0

    def __call__(self, state: oracle.State) -> None:
        verdict = oracle.judge(self._given, state)
        limits = limits_of(verdict, self._given.effects, self._tolerances)
        for name, value in verdict._asdict().items():
            limit = limits.get(name, 0.0)
            worst = self.worst.get(name, -np.inf)
            if not _over_limit(value, limit) <= _over_limit(worst, self.limits.get(name, 0.0)):
                self.worst[name] = value
                self.limits[name] = limit
        self.states += 1


def _over_limit(value: float, limit: float) -> float:
    """Return a number over its limit; if the limit is 0 or infinite (no limit), the number."""
    return value / limit if 0.0 < limit < np.inf else value


class JudgedSolver:
    """Solver whose states at rest are judged; of very large joints only some of them."""

    def __init__(self, inner, judge: Judge):
        self._inner = inner
        self._show = judge
        self._seen = 0
        self.elastic_curve = self._elastic_curve if inner.elastic_curve else None
        self.predict = inner.predict

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Settle the joint with the solver, and judge the state."""
        settled = self._inner.settle(joint, closure, breakage_step)
        self._judge(joint, settled)
        return settled

    def _elastic_curve(self, joint: Joint, targets: np.ndarray) -> list[Settled]:
        # a curve keeps only the forces of its last point, so each point (few of large joints) is
        # solved again; it is judged with closure and total force of the whole curve
        settled = self._inner.elastic_curve(joint, targets)
        self._judge(joint, settled[-1])
        last = joint.force.copy()
        parts = list(range(1, len(settled)))
        if joint.upper.size > LARGEST_CURVE:
            parts = sorted({1, targets.size // 2} & set(parts))
        for part in parts:
            self._inner.elastic_curve(joint, targets[:part])
            self._judge(joint, settled[part - 1])
        joint.force[:] = last
        return settled

    def _judge(self, joint: Joint, settled: Settled) -> None:
        self._seen += 1
        if settled.outcome != Outcome.CONVERGED or (
            settled.contacts > LARGEST_JUDGED and self._seen % 10 != 1
        ):
            return
        state = joint.upper, joint.lower, joint.force, settled.closure, settled.total_force
        self._show(oracle.State(*state, joint.peaks >= CRUSHED))
