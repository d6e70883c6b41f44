"""Scores of fitted constants: how many readings they predict, and how many by chance."""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.randomness import generator

NULL_DRAWS = 10_000  # draws of the null hypothesis; a probability of 0.05 is then known to 0.002


class Scores(NamedTuple):
    """How well each of several rows of constants predicts the readings of measured joints."""

    score: np.ndarray  # number of readings that overlap the intervals of a row (rows,)
    chance: np.ndarray  # probability of this number or a larger one by chance (rows,)


def chance_of_scores(
    values: np.ndarray,
    intervals: tuple[np.ndarray, np.ndarray],
    measured: tuple[np.ndarray, np.ndarray],
    constants: np.ndarray,
    seed: int,
) -> Scores:
    """Compute the score of each row of constants, and how probable it or a better one is by chance.

    The score is the number of readings whose measured range overlaps the interval that the row
    predicts. A row is a set of fitted constants, and a reading is one quantity of one joint.

    Under the null hypothesis the quantities are unrelated: the measured range of each keeps its
    width, but lies about the ``values`` of a row that is drawn for this quantity alone. In every
    draw the best of all rows with at most as many constants is taken, so that the choice among rows
    counts.

    Parameters
    ----------
    values : array (rows, quantities, joints)
        Predicted values.
    intervals : pair of arrays (rows, quantities, joints)
        Low and high ends of the predicted intervals.
    measured : pair of arrays (quantities, joints)
        Low and high ends of the measured ranges.
    constants : array (rows,)
        Number of constants that each row has fitted.
    seed : int
        Seed of the draws.
    """
    rows, quantities, _ = values.shape
    width = 0.5 * (measured[1] - measured[0])
    drawn = generator(seed).integers(rows, size=(NULL_DRAWS, quantities))
    centre = values[drawn, np.arange(quantities)]
    score = _overlaps(intervals, measured).sum(axis=(1, 2))
    by_chance = np.stack(
        [
            _overlaps(ends, (centre - width, centre + width)).sum(axis=(1, 2))
            for ends in zip(*intervals, strict=True)
        ]
    )
    best = {count: by_chance[constants <= count].max(axis=0) for count in np.unique(constants)}
    reached = [(best[n] >= own).sum() for n, own in zip(constants, score, strict=True)]
    return Scores(score, (1.0 + np.array(reached)) / (1.0 + NULL_DRAWS))


def _overlaps(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]):
    """Return whether two ranges (low, high) have a value in common, element by element."""
    return (one[0] <= other[1]) & (other[0] <= one[1])
