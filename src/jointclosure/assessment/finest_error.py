"""Limit of the numerical error of a joint by the finest setting of an assessment.

The copies of a joint (`jointclosure.uncertainty.variants.COPIES`) would give equal results, if
these did not depend on the order of breakage. Three things show how large the error of a result by
the finest setting may be: the scatter of the copies, the change by the next coarser setting, and
the largest jump of the joint, the closure in which a group of asperities breaks at once. A least
error is added. The expected error is the root of the sum of the squares of these four, each times a
factor, and the limit is a multiple of it.

The weights below were fitted to 127 random joints whose next coarser setting has five times the
tolerance, so that about 92 % of them keep the limit, and at least 90 % of other joints should.
`benchmarks/assessment_error.py` fits weights, and measures how the limits hold on further joints;
docs/accuracy.md has its table. `jointclosure.uncertainty.numerical_error` has the limit of a joint
that is simulated by one setting, without copies.
"""

from collections.abc import Mapping

from jointclosure.assessment.assessed_results import CLOSURE, GROSS, STIFFNESS
from jointclosure.uncertainty.numerical_error import Weights

WEIGHTS: Mapping[tuple[str, bool], Weights] = {
    (CLOSURE, True): Weights(0.0007, 0.30, 0.19, limit=2.7, of_scatter=1.80),
    (CLOSURE, False): Weights(0.0007, 0.19, 0.24, limit=2.65, of_scatter=1.25),
    (GROSS, True): Weights(0.0007, 0.06, 0.01, limit=2.75, of_scatter=1.60),
    (GROSS, False): Weights(0.0007, 0.08, 0.18, limit=3.6, of_scatter=1.00),
    (STIFFNESS, True): Weights(0.0007, 0.36, 0.15, limit=3.0, of_scatter=1.80),
    (STIFFNESS, False): Weights(0.0007, 0.21, 0.42, limit=2.6, of_scatter=1.60),
}
"""Weights by result and by whether the cycle is the first one."""


def log_error_of_finest(
    scatter: float, change: float, jump: float, quantity: str, cycle: int
) -> float:
    """Return the logarithm of the factor by which a result by the finest setting may be wrong.

    About nine of ten joints keep this limit.

    Parameters
    ----------
    scatter : float
        Standard deviation of the logarithms of the results of the copies [1], by the finest and by
        the next coarser setting in the root mean square.
    change : float
        Mean logarithm of the results by the next coarser setting, less that of the finest [1].
    jump : float
        Largest jump of the joint, over its closure [1].
    quantity : str
        One of `assessed_results.LIMITED`.
    cycle : int
        Number of the load cycle, from 1.

    Returns
    -------
    float
        NaN if the scatter or the change is.
    """
    return WEIGHTS[quantity, cycle == 1].log_error(jump, change, scatter=scatter)
