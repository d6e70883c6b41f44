"""Numerical error of a result of one joint, as a limit that holds for at least nine joints in ten.

Three things tell of the error. The joint with other steps, and its copies whose results would be
equal but for rounding (`uncertainty.variants.COPIES`), scatter with the steps and with the order in
which asperities break. The largest jump of the joint is the closure in which a group of asperities
breaks at once, at constant stress (`joint.cycles.largest_jump`): where such a group breaks with one
tolerance, in all copies, it may not break with a finer one. The third is a least error, because
joints without jump and scatter have one too. The expected error is the root of the sum of their
squares, each times a factor, and the limit is a multiple of it.

The constants below are rounded ones of fits to 251 random joints, 174 of seed 11 and 77 of seed 21:
the likeliest factors for errors that are distributed as Student's t of 2.5 degrees of freedom,
which has the long tails of the true errors. `benchmarks/numerical_error.py` fits them, and measures
how the limit holds on further joints; docs/accuracy.md has its table.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from jointclosure.uncertainty.results import CLOSURE_NET, STIFFNESS

LEAST = 0.003
"""Expected error of a joint without jump and scatter [1]."""
OF_JUMP: Mapping[tuple[str, bool], float] = {
    (CLOSURE_NET, True): 0.6,
    (STIFFNESS, True): 1.2,
    (CLOSURE_NET, False): 0.3,
    (STIFFNESS, False): 0.3,
}
"""Expected error over the largest jump, by result and by whether the cycle is the first one."""
OF_SCATTER = 1.4
"""Expected error over the standard deviation of the logarithms of the results."""
MULTIPLE = 3.3
"""Limit over the expected error."""
NOT_STABLE = 0.2
"""Scatter of the copies of a joint, relative to their mean, beyond which it is not stable [1]."""


def numerical_error(values: Sequence[float], jump: float, quantity: str, cycle: int) -> float:
    """Return the numerical error of a result, over it, that at least nine of ten joints keep.

    Parameters
    ----------
    values : sequence of float
        The result of the joint, with other steps, and of copies: all that would be equal if neither
        the steps nor the order of breakage mattered. NaN where a simulation failed.
    jump : float
        Largest jump of the joint, over its closure [1].
    quantity : str
        `CLOSURE_NET` or `STIFFNESS`.
    cycle : int
        Number of the load cycle, from 1.

    Returns
    -------
    float
        Relative error [1]; NaN where nothing is known, as without other steps.
    """
    known = [value for value in values if math.isfinite(value) and value > 0.0]
    if len(known) < 2:
        return math.nan
    scatter = float(np.std(np.log(known), ddof=1))
    of_jump = OF_JUMP[quantity, cycle == 1] * jump
    return MULTIPLE * math.hypot(LEAST, of_jump, OF_SCATTER * scatter)


def scatter_of(copies: Sequence[float]) -> float:
    """Return the standard deviation of the results of copies over their mean [1]; 0 for one."""
    known = [number for number in copies if math.isfinite(number)]
    return float(np.std(known, ddof=1) / np.mean(known)) if len(known) > 1 else 0.0
