"""Ratios of means over the same surfaces."""

import numpy as np

from jointclosure.statistics.standard_errors import Estimate, mean_of


def ratio_of_means(over: np.ndarray, under: np.ndarray) -> Estimate:
    """Mean of one row (n,) over that of another, of the same surfaces, and its standard error.

    NaN pairs are left out; NaN where none is left, or the mean under it is 0.

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
    """Harmonic mean of values (n,), and its standard error; NaN values are left out.

    Of stiffnesses it is that of the mean curve: one over the mean compliance. An arithmetic mean
    would be that of the few that are near infinite.
    """
    return ratio_of_means(np.ones(values.size), 1.0 / values)
