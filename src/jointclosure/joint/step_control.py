"""Size of the displacement steps of a history (decisions.md#0010-resolved-breakage)."""

from collections.abc import Callable

import numpy as np

from jointclosure.parameters import Numerics
from jointclosure.solvers.joint import Settled

_CORRECTION = 250.0
"""Allowed relative error of the predicted force of a step, over `Numerics.tolerance`. This and the
next four constants were chosen so that the errors of a joint fall with its tolerance at the least
time (docs/decisions.md#0010-resolved-breakage)."""
_VIRGIN_OF_MAXIMUM = 6.0
"""Allowed change of force in a step beyond the former maximum (virgin loading), relative to the
maximum and over the tolerance. Longer steps crush too many asperities."""
_VIRGIN_OF_FORCE = 45.0
"""Allowed change of force in a step of virgin loading, relative to the present force and over the
tolerance."""
_LATER_OF_MAXIMUM = 35.0
"""Allowed change of force in a step elsewhere, relative to the maximum and over the tolerance."""
_LATER_OF_FORCE = 175.0
"""Allowed change of force in a step elsewhere, relative to the present force and over the
tolerance."""
_MOST_OF_MAXIMUM = 0.1
"""Largest allowed change of force at any tolerance, relative to the maximum."""
_MOST_OF_FORCE = 0.5
"""Largest allowed change of force at any tolerance, relative to the present force."""
_FAINT = 0.01
"""Share of the maximum that is added to the present force where a change is relative to it."""
LARGEST_STEP = 4.0
"""Largest step over the configured one, on the first loading."""
_SMALLEST_STEP = 1.0 / 64.0
"""Smallest step over the configured one."""
_AIM = 0.8
"""Change that is aimed at in the next step, over the allowed change."""
_RETRY = 0.4
"""Ratio of the next step to the last step, below which the last step must be repeated."""
_MOST_LOST = 0.75
"""Largest share of a predicted rise of force that breakage is expected to remove."""
_RESIDUAL = 0.25
"""Relative residual of a prediction, over the rise that it predicts."""
_LOOSEST = 0.04
"""Largest relative residual of a prediction."""
_NEAR = 0.97
"""Aim of a step that should reach the end of the loading, over the rise allowed to it."""
_HARDLY_LESS = 0.8
"""Rise of force of a shortened step over that of the step before it was shortened, from which the
rise counts as hardly less: most of the contacts are then at their strength."""
_MUCH_SHORTER = 0.35
"""Largest share of a step that is tried next where shortening it hardly lessened its rise."""
_MOST_SHORTENED = 4
"""Largest number of times that a step is shortened before it is taken."""
_NEAR_SEATING = 0.05
"""Share of the seating force by which a state of an elastic branch may miss it."""
_BEFORE_READING = 0.85
"""Share of a force at which closures of a virgin loading are read, up to which its steps may be of
full length. Beyond it they are shorter: forces go up and down, and longer steps miss the first
peak."""
_PART = 0.2
"""Least allowed change of force in these shorter steps, over the usual allowed change."""


class StepControl:
    """Selection of the displacement steps [m] of one branch, with resolved breakage.

    ``given`` is the configured step [m]. The branch is a loading to ``target_force`` [N], which is
    virgin beyond ``former``, the largest earlier maximum [N], or an unloading if ``former`` is
    infinite. A branch that passes the ``seating_force`` [N] without breakage gets a state near it.
    """

    def __init__(
        self,
        numerics: Numerics,
        given: float,
        target_force: float,
        former: float,
        seating_force: float = 0.0,
    ):
        self._largest = given * (LARGEST_STEP if former == 0.0 else 1.0)
        self._smallest = given * _SMALLEST_STEP
        self._target = target_force
        self._former = former
        self._seating = seating_force
        self._readings = seating_force, max(0.5 * target_force, former)  # see `net_responses`
        self._tolerance = numerics.tolerance
        self._predicted = self._slope = self._lost = 0.0
        self._broke = False  # in the last step

    def fitting(self, step: float, force: float, predict: Callable[[float, float], float]) -> float:
        """Return a displacement step [m] from a force [N], shortened until its rise is allowed.

        ``predict(step, residual)`` returns the force [N] after a step, before anything breaks.
        `following` must be called next, with the state after the step.
        """
        seated = self._broke or force >= (1.0 - _NEAR_SEATING) * self._seating
        missing = (self._target if seated else min(self._seating, self._target)) - force
        smallest = self._smallest
        if self._slope * step > missing:
            step = missing / self._slope
        # the share of the predicted rise that is lost increases as the step gets shorter
        landing = missing * (1.0 + self._lost) / (1.0 - self._lost)
        most_rise = self._most_change(force)
        allowed = _AIM / _RETRY * most_rise
        aim = _AIM * most_rise
        if landing < allowed:
            allowed = landing
            aim = _NEAR * landing
            smallest *= _SMALLEST_STEP
        # an elastic step must not pass the target: what rests just below its strength would break
        residual = min(_RESIDUAL * allowed / self._target, _LOOSEST) if self._broke else 0.0
        before = np.inf
        for shortened in range(_MOST_SHORTENED + 1):
            self._predicted = predict(step, residual)
            rise = self._predicted - force
            if rise <= allowed or step <= smallest or shortened == _MOST_SHORTENED:
                break
            shorter = min(max(aim / rise, 0.1), 0.97)
            if rise > _HARDLY_LESS * before:  # most of the contacts are at their strength
                shorter = min(shorter, _MUCH_SHORTER)
            step = max(shorter * step, smallest)
            before = rise
        return step

    def following(self, step: float, force: float, settled: Settled) -> float:
        """Return the next displacement step [m], by the error of the last one.

        ``step`` [m] led from ``force`` [N] to the state ``settled``, and was returned by `fitting`.
        The caller must repeat it if `must_repeat` says so.
        """
        rise = settled.total_force - force
        self._slope = rise / step
        self._lost = 0.0
        self._broke = settled.effort.breakage_steps > 0
        if self._broke and self._predicted > force:
            lost = 1.0 - rise / (self._predicted - force)
            self._lost = min(max(lost, 0.0), _MOST_LOST)
        scale = settled.total_force + 0.05 * self._target
        allowed = _CORRECTION * self._tolerance * scale
        return self.after(step, force, rise, settled.correction / allowed)

    def after(self, step: float, force: float, change: float, missed: float = 0.0) -> float:
        """Return the next step [m] after a ``step`` [m] from a force [N] with a change of force.

        ``change`` is in N, ``missed`` is the error of that step over the allowed error. The next
        step is between the smallest and the largest allowed one, and between a quarter and twice
        the last one.
        """
        factor = _AIM / max(missed, change / self._most_change(force), 0.01)
        longer = step * min(max(factor, 0.25), 2.0)
        return min(max(longer, self._smallest), self._largest)

    def step_to_seating(self, step: float, force: float, left: float) -> float:
        """Return a step [m] of unloading, shortened if it would pass the seating force.

        With the whole ``step`` the force falls from ``force`` to ``left`` [N].
        """
        least, most = ((1.0 + side * _NEAR_SEATING) * self._seating for side in (-1.0, 1.0))
        if left >= least or force <= most or step <= self._smallest:
            return step
        return max((force - self._seating) / (force - left) * step, self._smallest)

    def _most_change(self, force: float) -> float:
        """Return the largest allowed change of force [N] in a step that starts at a force [N]."""
        virgin = self._former <= force and self._former < self._target
        rise = self._tolerance * (_VIRGIN_OF_MAXIMUM if virgin else _LATER_OF_MAXIMUM)
        steepest = self._tolerance * (_VIRGIN_OF_FORCE if virgin else _LATER_OF_FORCE)
        faint = force + _FAINT * self._target
        of_maximum = min(rise, _MOST_OF_MAXIMUM) * self._target
        change = min(of_maximum, min(steepest, _MOST_OF_FORCE) * faint)
        if virgin:
            for reading in self._readings:
                if force < reading:
                    change = min(change, max(_BEFORE_READING * reading - force, _PART * change))
        return change


def must_repeat(step: float, following: float) -> bool:
    """Return whether a step is so much longer than the following one that it must be repeated."""
    return following < _RETRY * step
