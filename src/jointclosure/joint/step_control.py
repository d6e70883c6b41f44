"""Displacement steps of a history with resolved breakage, from estimates of their error.

See docs/decisions.md#0010-resolved-breakage.
"""

from collections.abc import Callable

import numpy as np

from jointclosure.parameters import Numerics
from jointclosure.solvers.joint import Settled

_CORRECTION, _RISE = 40.0, 10.0
"""Allowed relative error of the predicted force of a step, and allowed relative rise of the force
in a step, both over `Numerics.tolerance`."""
LARGEST_STEP, _SMALLEST_STEP = 4.0, 1.0 / 64.0
"""Largest and smallest step over the configured step."""
_AIM = 0.8
"""Target of the next step, as a share of what is allowed."""
_RETRY = 0.4
"""A step is repeated if the next step would be shorter than this share of it."""
_MOST_LOST = 0.75
"""Largest share of a predicted rise of the force that breakage is expected to remove."""
_RESIDUAL, _LOOSEST = 0.25, 0.04
"""Relative residual of a prediction over the allowed rise, and its upper bound."""
_NEAR = 0.97
"""Target of a step that should reach the end of the loading, as a share of the allowed rise."""
_HARDLY_LESS, _MUCH_SHORTER = 0.8, 0.35
"""If the predicted rise of a shorter step exceeds the first share of that of the longer step, the
next step is at most the second share of the shorter one."""
_MOST_SHORTENED = 4


class StepControl:
    """Selection of the displacement steps of one loading [m]."""

    def __init__(
        self, numerics: Numerics, given: float, target_force: float, *, may_lengthen: bool
    ):
        self._largest = given * (LARGEST_STEP if may_lengthen else 1.0)
        self._smallest = given * _SMALLEST_STEP
        self._target = target_force
        self._most_rise = _RISE * numerics.tolerance * target_force
        self._most_missed = _CORRECTION * numerics.tolerance
        self._predicted = self._slope = self._lost = 0.0

    def fitting(self, step: float, force: float, predict: Callable[[float, float], float]) -> float:
        """Return the step [m], shortened if necessary, before anything breaks in it."""
        missing, smallest = self._target - force, self._smallest
        if self._slope * step > missing:
            step = missing / self._slope
        # the share of the predicted rise that is lost increases as the step gets shorter
        landing = missing * (1.0 + self._lost) / (1.0 - self._lost)
        allowed, aim = _AIM / _RETRY * self._most_rise, _AIM * self._most_rise
        if landing < allowed:
            allowed, aim = landing, _NEAR * landing
            smallest *= _SMALLEST_STEP
        residual = min(_RESIDUAL * allowed / self._target, _LOOSEST)
        before = np.inf
        for shortened in range(_MOST_SHORTENED + 1):
            self._predicted = predict(step, residual)
            rise = self._predicted - force
            if rise <= allowed or step <= smallest or shortened == _MOST_SHORTENED:
                break
            shorter = min(max(aim / rise, 0.1), 0.97)
            if rise > _HARDLY_LESS * before:  # most of the contacts are at their strength
                shorter = min(shorter, _MUCH_SHORTER)
            step, before = max(shorter * step, smallest), rise
        return step

    def following(self, step: float, force: float, settled: Settled) -> float:
        """Return the next step [m] that the error of the last one, from a force [N] on, allows."""
        rise = settled.total_force - force
        self._slope = rise / step
        if self._predicted > force:
            lost = 1.0 - rise / (self._predicted - force)
            self._lost = min(max(lost, 0.0), _MOST_LOST)
        scale = settled.total_force + 0.05 * self._target
        missed = settled.correction / (self._most_missed * scale)
        risen = rise / self._most_rise
        factor = _AIM / max(missed, risen, 0.01)
        longer = step * min(max(factor, 0.25), 2.0)
        return min(max(longer, self._smallest), self._largest)

    @staticmethod
    def must_repeat(step: float, following: float) -> bool:
        """Return whether a step was so long that it must be repeated."""
        return following < _RETRY * step
