"""Ratios of means over the same surfaces."""

import numpy as np

from jointclosure.statistics.standard_errors import Estimate, mean_of


def ratio_of_means(over: np.ndarray, under: np.ndarray) -> Estimate:
    """Compute the ratio of the means of two rows (n,) on the same surfaces, and its error.

    NaN pairs are left out. The result is NaN if none is left, or if the mean ``under`` is 0.

    Notes
    -----
    Delta method: the error of mean(over - ratio under)/mean(under).
    """
    known = np.isfinite(over) & np.isfinite(under)
    over, under = over[known], under[known]
    if not known.any() or under.mean() == 0.0:
        return Estimate(np.nan, np.nan)
    ratio = float(over.mean() / under.mean())
    if over.size < 2:
        return Estimate(ratio, np.nan)
    error = mean_of(over - ratio * under).standard_error
    return Estimate(ratio, error / abs(float(under.mean())))


def harmonic_mean(values: np.ndarray) -> Estimate:
    """Compute the harmonic mean of values (n,), and its standard error; NaN are left out.

    For stiffnesses it is the stiffness of the mean curve: one over the mean compliance. The
    arithmetic mean would be dominated by the few nearly infinite values.
    """
    return ratio_of_means(np.ones(values.size), 1.0 / values)
