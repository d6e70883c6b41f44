"""Numerical error of a result of one joint, as a limit that about nine joints in ten keep.

Three things show how large the error may be. The result of the joint changes with other steps,
such as those of twice the tolerance. The first loading as a whole differs from that by a quite
different rule of steps, the paper's steps: a joint whose whole curve depends on the steps has a
large error at its end too, although two results may agree there by chance. The largest jump of the
joint is the closure in which a group of asperities breaks at once, at constant stress
(`joint.cycle_results.largest_jump`): where such a group breaks with one tolerance, it may not break
with a finer one. A least error is added, because joints without changes have one too. The expected
error is the root of the sum of the squares of these four, each times a factor, and the limit is a
multiple of it.

An error is a factor: the limit x means that the result may be 1 + x times too large or too small.

The weights below were fitted to 182 random joints that had the tolerance of `close`, so that about
92 % of them keep the limit, and at least 90 % of other joints should.
`benchmarks/numerical_error.py` fits weights, and measures how the limit holds on further joints;
docs/accuracy.md has its table.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.cycle_results import CHORD_START, net_responses
from jointclosure.joint.history import history_of
from jointclosure.joint.status import LOADING
from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS
from jointclosure.uncertainty.sources import ORDER


class Weights(NamedTuple):
    """Factors of the parts of the expected numerical error of a result, and of its limit."""

    least: float
    """Expected error of a result without any change, jump, difference and scatter [1]."""
    of_jump: float
    """Factor of the largest jump."""
    of_change: float
    """Factor of the change of the result by other steps."""
    limit: float
    """Limit of the error over the expected error."""
    of_curve: float = 0.0
    """Factor of the difference of the first loading by another rule of steps."""
    of_scatter: float = 0.0
    """Factor of the scatter of copies of the joint."""

    def log_error(
        self, jump: float, change: float, curve: float = 0.0, scatter: float = 0.0
    ) -> float:
        """Return the limit of the numerical error, as the logarithm of a factor [1].

        The arguments [1] are the largest jump, the change by other steps, the difference of the
        first loading by another rule of steps, and the scatter of copies. NaN if one is NaN.
        """
        expected = math.hypot(
            self.least,
            self.of_jump * jump,
            self.of_change * change,
            self.of_curve * curve,
            self.of_scatter * scatter,
        )
        return self.limit * expected


WEIGHTS: Mapping[tuple[str, bool], Weights] = {
    (CLOSURE_NET, True): Weights(0.0005, 0.30, 0.58, limit=2.75, of_curve=0.050),
    (CLOSURE_NET, False): Weights(0.0065, 0.01, 0.37, limit=2.6, of_curve=0.036),
    (STIFFNESS, True): Weights(0.003, 0.50, 0.54, limit=2.9, of_curve=0.040),
    (STIFFNESS, False): Weights(0.0035, 0.36, 0.43, limit=3.2, of_curve=0.016),
}
"""Weights by result and by whether the cycle is the first one."""
NOT_STABLE = 0.2
"""Scatter of results that should be equal (`log_scatter`) above which a joint is not stable [1]."""
_SHARES = np.linspace(CHORD_START, 1.0, 21)
"""Stresses at which two loadings are compared, over the maximum."""


def numerical_error(change: float, curve: float, jump: float, quantity: str, cycle: int) -> float:
    """Return the limit of the numerical error of a result that about nine of ten joints keep.

    Parameters
    ----------
    change : float
        Logarithm of the result by other steps over that of the joint [1].
    curve : float
        Difference of the first loading by another rule of steps, as `differences_of_loading` [1].
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
        times as much and 1.5 times as little. NaN if the change, the curve or the jump is NaN.
    """
    return math.expm1(WEIGHTS[quantity, cycle == 1].log_error(jump, change, curve=curve))


def differences_of_loading(joint: xr.Dataset, other: xr.Dataset) -> dict[str, float]:
    """Return by how much the first loading of a joint differs by another rule of steps.

    Parameters
    ----------
    joint, other : Dataset
        Histories of the same joint, as from `jointclosure.simulate`.

    Returns
    -------
    dict of float
        By `CLOSURE_NET` and `STIFFNESS`: the root mean square difference of the net closures since
        first touch, at stresses from half of the maximum of the first cycle to this maximum, over
        the net closure since seating, and over the closure along the chord of the stiffness [1].
        NaN where a loading has no such closure.
    """
    maximum = history_of(joint).maxima[0]
    one, two = (_first_loading(history, maximum) for history in (joint, other))
    difference = float(np.sqrt(np.mean((two - one) ** 2)))
    seated = float(net_responses(joint)["max_closure_seated_net"][0])
    along_chord = float(one[-1] - one[0])
    return {
        quantity: difference / closure if closure > 0.0 else math.nan
        for quantity, closure in ((CLOSURE_NET, seated), (STIFFNESS, along_chord))
    }


def _first_loading(joint: xr.Dataset, maximum: float) -> np.ndarray:
    """Return the net closures [m] of the first loading of a joint at `_SHARES` of a maximum [Pa].

    Stresses that the loading did not reach are read at its largest stress.
    """
    history = history_of(joint)
    loading = history.branch(1, LOADING)
    reached = float(history.stress[loading.steps].max())
    return history.net.read(loading, np.minimum(_SHARES * maximum, reached))


def log_scatter(values: Sequence[float]) -> float:
    """Return the standard deviation of the logarithms of results that should be equal [1].

    NaN stands for a simulation that failed, and is left out. The standard deviation is NaN if fewer
    than two results are left, or if one of them is not positive.
    """
    known = [value for value in values if math.isfinite(value)]
    if len(known) < 2 or min(known) <= 0.0:
        return math.nan
    return float(np.std(np.log(known), ddof=1))


def log_change(value: float, other: float) -> float:
    """Return the logarithm of the ratio of a result ``other`` to ``value`` [1].

    NaN unless both are positive.
    """
    return math.log(other / value) if value > 0.0 and other > 0.0 else math.nan


def numerical_errors_of(
    results: pd.DataFrame, jump: float, curve: Mapping[str, float]
) -> pd.DataFrame:
    """Return the numerical error of net closure and net stiffness, from the rows of a budget.

    Parameters
    ----------
    results : DataFrame
        As `Budget.results`.
    jump : float
        Largest jump of the joint, over its closure [1] (`joint.cycle_results.largest_jump`).
    curve : mapping
        As from `differences_of_loading`; empty if the simulation by another rule failed.

    Returns
    -------
    DataFrame
        One row per ``cycle`` and ``quantity``: ``error`` [1], as `numerical_error` (NaN where no
        other steps are known), and ``scatter``, as `log_scatter`, of the joint, of its copies
        (`jointclosure.uncertainty.variants.COPIES`, such as a mirrored one) and of those with other
        steps; ``by`` describes these steps.
    """
    rows = []
    for cycle, here in results.groupby("cycle"):
        joint, steps, copies = (here[here.source == name] for name in ("", "breakage", ORDER))
        for quantity in (CLOSURE_NET, STIFFNESS):
            best, others, alike = (of[quantity].tolist() for of in (joint, steps, copies))
            changes = [log_change(value, other) for value in best for other in others]
            change = changes[0] if changes else math.nan
            along = curve.get(quantity, math.nan)
            error = numerical_error(change, along, jump, quantity, int(cycle))
            scatter = log_scatter([*best, *others, *alike])
            rows.append((cycle, quantity, error, scatter, ", ".join(steps.value)))
    return pd.DataFrame(rows, columns=["cycle", "quantity", "error", "scatter", "by"])


def limits_of_error(numerical: pd.DataFrame) -> dict[tuple[int, str], float]:
    """Return the numerical errors [1] in a table of `numerical_errors_of`, by (cycle, quantity).

    Errors that are NaN are left out.
    """
    known = numerical.dropna(subset="error")
    return {(row.cycle, row.quantity): row.error for row in known.itertuples()}
