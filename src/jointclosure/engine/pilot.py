"""Sequential test of whether effects can be left out, on pairs of walls that are closed both ways.

Walls are closed with all effects and without some. The change of the mean maximum closure is known
after each pair with limits of Student's t for paired differences. Pairs are added until the upper
limit of every cycle lies inside the tolerance, or the lower one of a cycle outside of it. Both are
one-sided limits, because each of the two decisions has one way to be wrong (equivalence is two
one-sided tests, D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987, 657-680). A limit that is
looked at after each pair needs a larger confidence at each look: the risk is divided over the looks
as 1/(1 2), 1/(2 3), 1/(3 4) and so on, which sums to the whole (Bonferroni's inequality with
unequal weights, the "alpha spending" of K. K. G. Lan and D. L. DeMets, Biometrika 70, 1983,
659-663). The number of looks need not be known before.

Closures that are not used are lost: those with all effects if some are left out, and those without
if all act. The second kind is bounded, because it has no benefit: `LOSS`, or a joint if that is
more. If the bound is reached, the mean of the changes decides, with more caution where less time is
saved.
"""

import time
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import close_walls
from jointclosure.parameters import Effects
from jointclosure.statistics.standard_errors import percent

CONFIDENCE = 0.8
"""Confidence [1] of all limits of a test together."""
LOSS = 0.01
"""Largest share of the time of all joints that tests may lose; at least the time of a joint."""
UNDECIDED, CAUTIOUS = 0.9, 0.5
"""Shares of the tolerance up to which the mean decides if the bound of time is reached, where much
time (`MUCH`) is saved and elsewhere."""
MUCH = 0.3
"""Share of time that counts as much. Interaction takes half of the time or more; soft peaks near
the strength take a tenth to a third, and two pairs of them were misleading."""
_ONE_PAIR = 2.0
"""Factor on the change of one pair, which has no interval, if there is no time for another."""
WORTH = 0.1
"""Least share of time that leaving out an effect must save to be tested further."""


_CORNER = 16
"""Number of cells along the corner of the walls that is closed to load the kernels."""


class Closed(NamedTuple):
    """Result of `jointclosure.simulate`, and its processor time [s]."""

    dataset: xr.Dataset
    seconds: float


Close = Callable[[int, Effects], Closed | None]
"""Function that closes the pair of walls of a number with some effects; None without that pair."""


class Verdict(NamedTuple):
    """Outcome of a test: whether effects are left out, the estimated error [1], and its reason."""

    left_out: bool
    error: float
    reason: str


class Pilot:
    """Pairs of walls that are closed with required effects, at most once.

    Parameters
    ----------
    close : callable
        Closes a pair, as from `closing`.
    effects : Effects
        All effects that may act.
    joints : int
        Number of joints that will be closed with the selected effects.
    """

    def __init__(self, close: Close, effects: Effects, joints: int):
        self.close, self.effects, self.joints = close, effects, joints
        self.closed: dict[Effects, list[Closed]] = {}
        self.closures(effects, 1)

    def closures(self, effects: Effects, count: int) -> np.ndarray:
        """Return maximum closures (pair, cycle) [m] of the first pairs; fewer if there are none."""
        closed = self.closed.setdefault(effects, [])
        while len(closed) < count:
            result = self.close(len(closed), effects)
            if result is None:
                break
            closed.append(result)
        return np.array([max_closures(pair.dataset) for pair in closed[:count]])

    def changes(self, effects: Effects, count: int) -> np.ndarray:
        """Return changes of the closures of the first pairs (pair, cycle) from all effects [1]."""
        without = self.closures(effects, count)
        full = self.closures(self.effects, len(without))
        return (without - full) / full.mean(axis=0)

    def seconds(self, effects: Effects) -> float:
        """Return the mean time [s] of a joint with some effects; NaN if none was closed."""
        closed = self.closed.get(effects)
        return float(np.mean([pair.seconds for pair in closed])) if closed else np.nan

    def lost(self, selected: Effects) -> float:
        """Return the time [s] of all closures with other effects than the selected ones."""
        others = (pairs for effects, pairs in self.closed.items() if effects != selected)
        return sum(pair.seconds for pairs in others for pair in pairs)

    def test(
        self,
        fewer: Effects,
        before: Effects,
        tolerance: float,
        least_pairs: int = 1,
        part: float = 1.0,
    ) -> Verdict:
        """Test whether fewer effects change the mean maximum closure of no cycle too much.

        The change is from all effects; ``before`` are those selected so far. With less than
        ``least_pairs`` nothing is left out. All tests up to this one may lose ``part`` of the time
        that may be lost.
        """
        count, error, saved, changes = 0, np.inf, 0.0, np.empty((0, 1))
        while self._affordable(fewer, part):
            changes = self.changes(fewer, count + 1)
            if len(changes) == count:
                break
            count = len(changes)
            if not np.isfinite(changes).all():
                return Verdict(False, np.inf, "cannot be computed")
            saved = 1.0 - self.seconds(fewer) / self.seconds(before)
            if saved < WORTH:
                return Verdict(False, np.inf, f"takes {100.0 * saved:.0f} % less time, too little")
            least, error = _limits(changes)
            if (error <= tolerance and count >= least_pairs) or least > tolerance:
                break
        if not count:
            return Verdict(False, np.inf, "is not tested, as other tests took the time for it")
        mean = float(np.abs(changes.mean(axis=0)).max())
        if count == 1:  # no interval: the tolerance is all that is known of an error within it
            error = max(_ONE_PAIR * mean, tolerance)
        trusted = count > 1 and mean <= tolerance * (UNDECIDED if saved >= MUCH else CAUTIOUS)
        inside = error <= tolerance or trusted
        inside = inside and count >= least_pairs
        limit = f", at most {percent(error)}" if np.isfinite(error) else ""
        pairs = f"{count} pair{'s' if count > 1 else ''}"
        return Verdict(inside, error, f"changes by {percent(mean)}{limit} ({pairs})")

    def _affordable(self, fewer: Effects, part: float) -> bool:
        """Return whether another pair without effects may be lost."""
        bound = part * max(1.0, LOSS * self.joints) * self.seconds(self.effects)
        one = self.seconds(fewer)
        return self.lost(self.effects) + (one if np.isfinite(one) else 0.0) <= bound


def _limits(changes: np.ndarray) -> tuple[float, float]:
    """Return one-sided limits of the largest mean change over the cycles, of (pair, cycle).

    The lower one is of the cycle where it is largest, 0 if no cycle differs significantly from 0.
    """
    count = len(changes)
    if count < 2:
        return 0.0, np.inf
    risk = (1.0 - CONFIDENCE) / ((count - 1) * count)
    width = scipy.stats.t.ppf(1.0 - risk, count - 1)
    width = width * changes.std(axis=0, ddof=1) / np.sqrt(count)
    mean = np.abs(changes.mean(axis=0))
    return max(0.0, float((mean - width).max())), float((mean + width).max())


def closing(walls: Iterable[tuple[np.ndarray, np.ndarray]], conditions: Conditions) -> Close:
    """Return a function that closes pairs of walls (y, x) [m], which are drawn when needed.

    The time to load the kernels of a scene is not counted as that of its first joint.
    """
    remaining = iter(walls)
    pairs: list[tuple[np.ndarray, np.ndarray]] = []
    loaded: set[Effects] = set()

    def close(number: int, effects: Effects) -> Closed | None:
        while len(pairs) <= number:
            pair = next(remaining, None)
            if pair is None:
                return None
            pairs.append(pair)
        stated = conditions._replace(effects=effects)
        if effects not in loaded:
            upper, lower = (wall[:_CORNER, :_CORNER] for wall in pairs[number])
            close_walls(upper, lower, stated)
            loaded.add(effects)
        start = time.process_time()
        dataset = close_walls(*pairs[number], stated)
        return Closed(dataset, time.process_time() - start)

    return close


def max_closures(closed: xr.Dataset) -> np.ndarray:
    """Return maximum closures (cycle,) [m] of a simulation; NaN if it failed."""
    return np.where(int(closed.status) >= FAILURE, np.nan, closed.max_closure.values)
