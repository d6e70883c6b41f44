"""Displacement steps of a loading with resolved breakage, from estimates of their error.

See docs/decisions/0010-resolved-breakage.md.
"""

from collections.abc import Callable

import numpy as np

from jointclosure.parameters import Numerics
from jointclosure.solvers.joint import Settled

_CORRECTION, _RISE = 40.0, 10.0
"""What a step may miss its predicted force by, and raise the force by, both relative and over
`Numerics.tolerance`."""
LARGEST_STEP, _SMALLEST_STEP = 4.0, 1.0 / 64.0
"""Bounds of a step over the given one."""
_AIM = 0.8
"""What a next step aims at, over what is allowed."""
_RETRY = 0.4
"""A step is taken again where the next would be this much shorter."""
_MOST_LOST = 0.75
"""Share of a predicted rise of the force that breakage is expected to take at most."""
_RESIDUAL, _LOOSEST = 0.25, 0.04
"""Relative residual of a prediction over the rise that it may have, and the largest."""
_NEAR = 0.97
"""What a step that is to land aims at, over the predicted rise that it may have."""
_HARDLY_LESS, _MUCH_SHORTER = 0.8, 0.35
"""Where a shorter step's predicted rise is so much of the longer one's, the next is so short."""
_MOST_SHORTENED = 4


class StepControl:
    """Chooses the displacement steps of one loading [m].

    Parameters
    ----------
    numerics : Numerics
    given : float
        The displacement step that is configured [m].
    target_force : float
        Force [N] at which the loading ends.
    may_lengthen : bool
        Whether steps may become longer than the given one: on the first loading.
    """

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
        """The step, or a shorter one, before anything breaks in it [m].

        It lands on the target, should the force go on rising as it did in the step before; and its
        predicted force rises so little that it need not be taken again.

        Parameters
        ----------
        step : float
            [m].
        force : float
            Before the step [N].
        predict : callable
            The force after a step [m], if nothing broke in it [N], to a relative residual.
        """
        missing, smallest = self._target - force, self._smallest
        if self._slope * step > missing:
            step = missing / self._slope
        # the shorter a step the more of its predicted rise is lost, where much is
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
        """The step [m] that the error of the last one, from a force [N] on, allows.

        What breaks in a step changes the contacts, so that the force misses the one
        predicted; the miss grows with the step. It is kept in proportion to the
        tolerance, of the force and a twentieth of the target; and so is the rise of
        the force, as what a step jumps over breaks at the end of it.
        """
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
        """Whether a step was so long that it is to be taken again."""
        return following < _RETRY * step
