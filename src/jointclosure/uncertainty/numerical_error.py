"""Numerical error of a result of one joint, as a limit that about nine joints in ten keep.

Three things show how large the error may be. The joint with other steps, and its copies whose
results would be equal but for rounding (`uncertainty.variants.COPIES`), scatter with the steps and
with the order in which asperities break. The largest jump of the joint is the closure in which a
group of asperities breaks at once, at constant stress (`joint.cycle_results.largest_jump`): where
such a group breaks with one tolerance, in all copies, it may not break with a finer one. The third
is a least error, because joints without jump and scatter have one too. The expected error is the
root of the sum of their squares, each times a factor, and the limit is a multiple of it.

An error is a factor: the limit x means that the result may be 1 + x times too large or too small.

The constants below were chosen by 410 random joints that had the tolerance of `close`. About 92 %
of them keep the limit, so that at least 90 % of other joints should. Of 210 sets of constants none
has limits that are smaller by more than a tenth for as many joints.
`benchmarks/numerical_error.py` compares constants, and measures how the limit holds on further
joints; docs/accuracy.md has its table.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS
from jointclosure.uncertainty.sources import ORDER

LEAST = 0.003
"""Expected error of a joint without jump and scatter [1]."""
OF_JUMP: Mapping[bool, float] = {True: 0.6, False: 0.2}
"""Expected error over the largest jump, by whether the cycle is the first one."""
OF_SCATTER = 1.4
"""Expected error over the standard deviation of the logarithms of the results."""
LIMIT: Mapping[tuple[str, bool], float] = {
    (CLOSURE_NET, True): 3.2,
    (CLOSURE_NET, False): 2.8,
    (STIFFNESS, True): 3.7,
    (STIFFNESS, False): 3.4,
}
"""Limit over the expected error, by result and by whether the cycle is the first one."""
NOT_STABLE = 0.2
"""Scatter of the results of a joint, as `log_scatter`, beyond which it is not stable [1]."""


def numerical_error(scatter: float, jump: float, quantity: str, cycle: int) -> float:
    """Return the numerical error of a result, over it, that about nine of ten joints keep.

    Parameters
    ----------
    scatter : float
        Scatter of the result of the joint, with other steps, and of copies, as `log_scatter` [1].
    jump : float
        Largest jump of the joint, over its closure [1].
    quantity : str
        `CLOSURE_NET` or `STIFFNESS`.
    cycle : int
        Number of the load cycle, from 1.

    Returns
    -------
    float
        Relative error [1], by which the result may be multiplied or divided: 0.5 stands for 1.5
        times as much and 1.5 times as little. NaN if the scatter is.
    """
    first = cycle == 1
    expected = math.hypot(LEAST, OF_JUMP[first] * jump, OF_SCATTER * scatter)
    return math.expm1(LIMIT[quantity, first] * expected)


def log_scatter(values: Sequence[float]) -> float:
    """Return the standard deviation of the logarithms of results that would be equal [1].

    NaN stands for a simulation that failed, and does not count. The scatter is NaN for less than
    two results, and if one is not positive.
    """
    known = [value for value in values if math.isfinite(value)]
    if len(known) < 2 or min(known) <= 0.0:
        return math.nan
    return float(np.std(np.log(known), ddof=1))


def numerical_errors_of(results: pd.DataFrame, jump: float) -> pd.DataFrame:
    """Return the numerical error of net closure and net stiffness, from the rows of a budget.

    Parameters
    ----------
    results : DataFrame
        As `Budget.results`.
    jump : float
        Largest jump of the joint, over its closure [1] (`joint.cycle_results.largest_jump`).

    Returns
    -------
    DataFrame
        One row per ``cycle`` and ``quantity``: ``error`` [1], as `numerical_error` (NaN where no
        other steps are known), and ``scatter``, as `log_scatter`, of the joint, of its copies
        (`jointclosure.uncertainty.variants.COPIES`, such as a mirrored one) and of those with other
        steps; ``by`` describes these steps and copies.
    """
    rows = []
    for cycle, here in results.groupby("cycle"):
        joint, steps, copies = (here[here.source == name] for name in ("", "breakage", ORDER))
        for quantity in (CLOSURE_NET, STIFFNESS):
            best, others, alike = (of[quantity].tolist() for of in (joint, steps, copies))
            scatter = log_scatter([*best, *others, *alike])
            error = np.nan
            if np.isfinite(others).any():
                error = numerical_error(scatter, jump, quantity, int(cycle))
            by = f"{', '.join(steps.value)} and {len(alike)} copies"
            rows.append((cycle, quantity, error, scatter, by))
    return pd.DataFrame(rows, columns=["cycle", "quantity", "error", "scatter", "by"])


def limits_of_error(numerical: pd.DataFrame) -> dict[tuple[int, str], float]:
    """Return the known numerical errors [1] of `numerical_errors_of` by cycle and quantity."""
    known = numerical.dropna(subset="error")
    return {(row.cycle, row.quantity): row.error for row in known.itertuples()}
