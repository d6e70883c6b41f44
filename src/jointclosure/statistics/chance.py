"""Scores that rows of fitted constants reach by chance."""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.randomness import generator

NULL_DRAWS = 10_000  # of the null hypothesis; a probability of 0.05 is then known to 0.002


class Scores(NamedTuple):
    """How well rows of constants predict readings."""

    score: np.ndarray  # number of readings within a row's intervals (rows,)
    chance: np.ndarray  # probability of so many or more by chance (rows,)


def chance_of_scores(
    values: np.ndarray,
    intervals: tuple[np.ndarray, np.ndarray],
    measured: tuple[np.ndarray, np.ndarray],
    constants: np.ndarray,
    seed: int,
) -> Scores:
    """Compute how often measurements that no row explains give a row's score or a better one.

    ``values`` and the ends of ``intervals`` are (rows, quantities, joints), the ends of
    ``measured`` (quantities, joints), ``constants`` (rows,) the number that a row has fitted. A
    reading counts if its range overlaps the interval of the row. Under the null hypothesis the
    quantities are unrelated: the range of each lies, as wide as it is, about the values of a row
    that is drawn for this quantity alone. Every draw chooses the best of all rows with at most as
    many constants anew, so that the selection among them counts.
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
    """Return whether two ranges (low, high) have a value in common."""
    return (one[0] <= other[1]) & (other[0] <= one[1])
