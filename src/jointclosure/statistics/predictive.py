"""Published lengths, and tables of them, against repetitions of the study.

An interval without a root counts as infinitely long. Lengths are then ordered, and a dash is one of
their values, with its probability. The statistic of a table is a composite log-likelihood: the sum
over the entries of the log of the probability of a dash, or of the density of log(length). The sum
ignores that entries depend on each other (both cycles of a case have the same surfaces). This does
not affect p, because the repetitions, whose entries depend on each other in the same way, give the
distribution of the statistic.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.standard_errors import jackknife_error


class LengthDistribution(NamedTuple):
    """Median, ranges, and share of repetitions without a root, whose length is infinite.

    Ranges leave out the same probability at both ends, and more than their nominal probability is
    covered by one that ends at infinity.
    """

    median: float
    low_90: float
    high_90: float
    low_95: float
    high_95: float
    share_without_root: float


def length_distribution(lengths) -> LengthDistribution:
    """Summarise the lengths (R,) of repeated studies, infinite without a root."""
    lengths = _lengths(lengths)
    middle = np.quantile(lengths, 0.5, method="inverted_cdf")
    low = np.quantile(lengths, [0.05, 0.025], method="lower")
    high = np.quantile(lengths, [0.95, 0.975], method="higher")
    without = np.mean(np.isinf(lengths))
    return LengthDistribution(*map(float, (middle, low[0], high[0], low[1], high[1], without)))


def two_sided_p(lengths, observed: float) -> float:
    """Compute the two-sided mid-p value of a published length."""
    lengths, observed = _lengths(lengths), _outcome(observed)
    shorter = np.count_nonzero(lengths < observed)
    equal = np.count_nonzero(lengths == observed)
    below = (shorter + 0.5 * (equal + 1)) / (lengths.size + 1)
    return float(2.0 * min(below, 1.0 - below))


def share_as_short(lengths, observed: float) -> float:
    """Return the probability of a length at most as long as the published one; 1 for a dash."""
    lengths, observed = _lengths(lengths), _outcome(observed)
    return float((1 + np.count_nonzero(lengths <= observed)) / (lengths.size + 1))


def _outcome(observed: float) -> float:
    if observed < 0.0:
        raise InputError(f"observed = {observed!r}: must be a length, or NaN for no root")
    return np.inf if np.isnan(observed) else float(observed)


def _lengths(lengths) -> np.ndarray:
    lengths = np.asarray(lengths, dtype=float)
    if lengths.ndim != 1 or lengths.size == 0 or np.isnan(lengths).any():
        raise InputError(f"lengths: shape {lengths.shape}, must be (R,), with infinity for no root")
    return lengths


TAIL_SHARE = 0.01
"""Share of the density that is a Student t (3 degrees of freedom): no value is impossible."""

GRID = 512
FEWEST_ROOTS = 10
GROUPS = 10


class JointTest(NamedTuple):
    """Composite log-likelihood of a table, its error from finite repetitions, and its rank."""

    log_likelihood: float
    standard_error: float
    p: float  # share of repetitions that are equally or less likely


def joint_test(lengths, observed) -> JointTest:
    """Test a table, or some of its entries, against repetitions of a study.

    Densities are Gaussian kernel estimates of log(length) (Silverman's bandwidth) with a heavy tail
    of weight `TAIL_SHARE`. For p the repetitions are divided into two halves. Each half, and the
    published table with it, is evaluated with the densities of the other half, so that no
    repetition is evaluated with a density to which it contributed. The log-likelihood itself uses
    all repetitions; its standard error is from a jackknife over `GROUPS` groups of repetitions.
    """
    lengths, observed = _checked(lengths, observed)
    group = np.arange(lengths.shape[0]) % GROUPS
    parts = [log_likelihoods(lengths[group != i], observed[None])[0] for i in range(GROUPS)]
    whole, error = log_likelihoods(lengths, observed[None])[0], jackknife_error(parts)
    return JointTest(float(whole), float(error), p_of_table(lengths, observed))


def p_of_table(lengths, observed) -> float:
    """Return only the p of `joint_test`."""
    lengths, observed = _checked(lengths, observed)
    halves = lengths[::2], lengths[1::2]
    as_unlikely = 0
    for half, other in (halves, halves[::-1]):
        likelihoods = log_likelihoods(other, np.vstack([observed, half]))
        as_unlikely += int(np.count_nonzero(likelihoods[1:] <= likelihoods[0]))
    return float((1 + as_unlikely) / (lengths.shape[0] + 1))


def log_likelihoods(lengths: np.ndarray, tables: np.ndarray) -> np.ndarray:
    """Return composite log-likelihoods (m,) of tables (m, entries) under lengths (R, entries)."""
    logs = np.empty(tables.shape)
    for i, (drawn, published) in enumerate(zip(lengths.T, tables.T, strict=True)):
        roots = np.isfinite(drawn)
        without = (np.count_nonzero(~roots) + 0.5) / (drawn.size + 1.0)
        dash = ~np.isfinite(published)
        density = _log_density(np.log(drawn[roots]), np.log(published[~dash]))
        logs[dash, i] = np.log(without)
        logs[~dash, i] = np.log1p(-without) + density
    return logs.sum(axis=1)


def _log_density(draws: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the log density of log(length) from its draws; 0 if there are too few draws."""
    if draws.size < FEWEST_ROOTS or at.size == 0:
        return np.zeros(at.size)
    quarters = np.quantile(draws, [0.25, 0.5, 0.75])
    scale = (quarters[2] - quarters[0]) / 1.349
    width = 0.9 * min(draws.std(ddof=1), scale) * draws.size**-0.2
    low, high = draws.min() - 4.0 * width, draws.max() + 4.0 * width
    grid = np.linspace(low, high, GRID) if at.size > GRID else np.sort(at)
    z = (grid[:, None] - draws) / width
    kernel = np.exp(-0.5 * z * z).mean(axis=1) / (width * np.sqrt(2.0 * np.pi))
    tail = scipy.stats.t.pdf((at - quarters[1]) / scale, 3) / scale
    kernel = np.interp(at, grid, kernel, left=0.0, right=0.0)
    return np.log((1.0 - TAIL_SHARE) * kernel + TAIL_SHARE * tail)


def _checked(lengths, observed) -> tuple[np.ndarray, np.ndarray]:
    lengths, observed = np.asarray(lengths, dtype=float), np.asarray(observed, dtype=float)
    if lengths.ndim != 2 or observed.shape != lengths.shape[1:]:
        raise InputError(
            f"lengths {lengths.shape} and observed {observed.shape}: must be (repetitions, "
            "entries) and (entries,)"
        )
    if lengths.shape[0] < 100:
        raise InputError(f"lengths: {lengths.shape[0]} repetitions, must be 100 or more")
    for name, values in (("lengths", lengths), ("observed", observed)):
        if np.any(values <= 0.0):
            raise InputError(f"{name}: the smallest is {np.nanmin(values)}, must be positive")
    if np.isnan(lengths).any():
        raise InputError("lengths: NaN, must be infinite where there is no root")
    return lengths, np.where(np.isnan(observed), np.inf, observed)
