"""Numerical error of a result of one joint, as a statement that holds in at least nine of ten.

Two things are observed. The joint with other steps shows how results move with the tolerance. Its
copies, whose results would be equal but for rounding (`uncertainty.variants.COPIES`), show how
results scatter with the order in which asperities break. Neither shows all: a group of asperities
that breaks with one tolerance, in all copies, may not break with a finer one. The variance of the
copies is therefore combined with an expected one, as in the estimate of a variance from a few
values and a prior (Gelman et al. 2013, section 2.6). On the first cycle it falls with the number of
cells in contact, of which a group is a part.

The constants below were chosen on 107 random joints, 28 of seed 7 and 79 of seed 11. How they hold
on further ones is measured by `benchmarks/numerical_error.py`, whose table docs/accuracy.md has.
"""

import math
from collections.abc import Sequence

import numpy as np

FACTOR = 3.25
"""Half-width of the statement, over its standard deviation. It is more than the 1.96 of a normal
distribution, as few copies give the deviation, and groups of asperities break at once."""
PRIOR_WEIGHT = 1.0
"""Number of values that the expected scatter counts as."""
EXPECTED_FIRST = 0.57
"""Expected scatter of a result on the first cycle, times the root of the cells in contact [1]."""
EXPECTED_LATER = 0.02
"""Expected scatter of a result on a later cycle [1]."""
NOT_STABLE = 0.2
"""Scatter of the copies of a joint, relative to their mean, beyond which it is not stable [1]."""


def numerical_error(
    value: float, changed: Sequence[float], copies: Sequence[float], contacts: float, cycle: int
) -> float:
    """Return the numerical error of a result, over it, that at least nine of ten joints keep.

    Parameters
    ----------
    value : float
        The result, positive.
    changed : sequence of float
        The result by other steps, of the joint and of its copies.
    copies : sequence of float
        All results that would be equal if the order of breakage did not matter, such as those of
        copies, in any steps; ``value`` may be one.
    contacts : float
        Number of cells in contact at the maximum stress.
    cycle : int
        Number of the load cycle, from 1.

    Returns
    -------
    float
        Relative error [1]; NaN where nothing is known, as without other steps.
    """
    known = [number for number in copies if math.isfinite(number) and number > 0.0]
    others = [number for number in changed if math.isfinite(number) and number > 0.0]
    if not others or not value > 0.0:
        return math.nan
    first = EXPECTED_FIRST / math.sqrt(max(contacts, 1.0))
    expected = (first if cycle == 1 else EXPECTED_LATER) ** 2
    free = max(len(known) - 1, 0)
    scatter = float(np.var(np.log(known), ddof=1)) if free else 0.0
    variance = (PRIOR_WEIGHT * expected + free * scatter) / (PRIOR_WEIGHT + free)
    change = float(np.mean(np.log(others))) - math.log(value)
    return FACTOR * math.sqrt(variance + 0.5 * change**2)


def scatter_of(copies: Sequence[float]) -> float:
    """Return the standard deviation of the results of copies over their mean [1]; 0 for one."""
    known = [number for number in copies if math.isfinite(number)]
    return float(np.std(known, ddof=1) / np.mean(known)) if len(known) > 1 else 0.0
