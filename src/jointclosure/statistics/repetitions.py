"""Repetitions of a published study, drawn from simulated surfaces, and a table against them.

A study draws n surfaces for every level of every parameter, independently, as the paper did, and
publishes the lengths of its indifference intervals. A pool of N surfaces per case is itself a
sample; therefore a repetition first resamples the pool (N of N, with replacement) and then draws n
surfaces from this. To correct the smaller scatter of a finite pool, values are moved away from its
mean by the factor N/(N - 1). The mean of a repetition at a level then has the variance
s^2/n + s^2/(N - 1) about the mean of the pool (s: its standard deviation, ddof 1), as a new study's
mean has, including the error of the pool. The variance within a repetition is s^2.

An interval without a root counts as infinitely long. Lengths are then ordered, and a dash is one of
their values, with its probability. The statistic of a table is a composite log-likelihood: the sum
over the entries of the log of the probability of a dash, or of the density of log(length). The sum
ignores that entries depend on each other (both cycles of a case have the same surfaces). This does
not affect p, because the repetitions, whose entries depend on each other in the same way, give the
distribution of the statistic.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeVar

import numpy as np

from jointclosure.statistics.indifference import (
    ResponseMoments,
    critical_value,
    lengths_of_responses,
)
from jointclosure.statistics.standard_errors import jackknife_error

RESAMPLED_POOLS = 40
"""Number of resampled pools: the error of a probability is then known to a ninth of it."""
_FEWEST_REPETITIONS = 100  # from each resampled pool
TAIL_SHARE = 0.01
"""Weight of a Student's t (3 degrees of freedom) in a density, so that no value is impossible."""

BLOCK = 16384
"""Numbers that are computed at once: few enough to stay in the cache of a processor."""
GRID = 512  # most places at which a density is computed; between them it is interpolated
FEWEST_ROOTS = 10  # repetitions with a root from which a density is estimated
GROUPS = 10  # of repetitions, one of which is left out at a time (jackknife)
Key = TypeVar("Key", bound=tuple[str, ...] | str)


class Pool(NamedTuple):
    """Results (targets, N) on the N simulated surfaces of one case.

    ``surfaces`` is the name of the surfaces. Pools with the same name have the same surfaces in the
    same order, and are resampled together.
    """

    values: np.ndarray
    surfaces: str


class Sensitivity(NamedTuple):
    """Levels of one parameter of one rock, and the pool of each level.

    The ``levels`` (k,) ascend, and one of them is the ``base``.
    """

    levels: np.ndarray
    base: float
    pools: tuple[Pool, ...]


class Design(NamedTuple):
    """Design of a published study: number of surfaces drawn per level, significance of its t test.

    The parameters of a rock are assumed to share the surfaces that are drawn at the base level; the
    paper does not say.
    """

    draws: int = 20
    significance: float = 0.05

    @property
    def critical_change(self) -> float:
        """Smallest significant difference of two means, in standard deviations: t sqrt(2/n)."""
        critical = critical_value(self.draws, self.significance)
        return float(critical * np.sqrt(2.0 / self.draws))


class DrawnResponse(NamedTuple):
    """Results for one parameter in R repetitions of a study."""

    levels: np.ndarray  # (k,)
    base: float
    means: np.ndarray  # (R, targets, k)
    deviations: np.ndarray  # (R, targets, k)
    lengths: np.ndarray  # (R, targets), of indifference intervals; infinite without a root


def draw_studies(
    sensitivities: Mapping[Key, Sensitivity],
    design: Design,
    repetitions: int,
    random: np.random.Generator,
) -> dict[Key, DrawnResponse]:
    """Draw ``repetitions`` of a study from pools, and compute the lengths of their intervals.

    The draws are independent at every level, but parameters whose base pools have one name share
    the surfaces that are drawn at the base. The result is by parameter, as ``sensitivities``.
    """
    resampled: dict[str, np.ndarray] = {}
    at_base: dict[str, np.ndarray] = {}
    of_base: dict[tuple[str, tuple[int, ...], bytes], tuple[np.ndarray, np.ndarray]] = {}
    moments = []
    for sensitivity in sensitivities.values():
        of_levels = []
        for level, pool in zip(sensitivity.levels, sensitivity.pools, strict=True):
            size = pool.values.shape[1]
            name = pool.surfaces
            if name not in resampled:
                smallest = np.min_scalar_type(size)
                resampled[name] = random.integers(size, size=(repetitions, size), dtype=smallest)
            index = random.integers(size, size=(repetitions, design.draws))
            if level != sensitivity.base:
                of_levels.append(_moments(pool, resampled[name], index))
                continue
            # the parameters of a rock share what is drawn at its base
            index = at_base.setdefault(name, index)
            values = pool.values
            key = (name, values.shape, values.tobytes())
            if key not in of_base:
                of_base[key] = _moments(pool, resampled[name], index)
            of_levels.append(of_base[key])
        means, deviations = (np.stack(part, axis=-1) for part in zip(*of_levels, strict=True))
        moments.append(ResponseMoments(sensitivity.levels, means, deviations, sensitivity.base))
    lengths = lengths_of_responses(moments, design.draws, design.significance)
    return {
        key: DrawnResponse(
            np.asarray(sensitivity.levels, float),
            sensitivity.base,
            np.asarray(means),
            np.asarray(deviations),
            np.nan_to_num(found, nan=np.inf),
        )
        for (key, sensitivity), (_, means, deviations, _), found in zip(
            sensitivities.items(), moments, lengths, strict=True
        )
    }


def parameters_without_effect(sensitivities: Mapping[Key, Sensitivity]) -> dict[Key, Sensitivity]:
    """Return ``sensitivities`` of parameters without any effect: all levels have the base pool."""
    return {
        key: Sensitivity(levels, base, (pools[list(levels).index(base)],) * len(pools))
        for key, (levels, base, pools) in sensitivities.items()
    }


def resampled_pools(
    sensitivities: Mapping[Key, Sensitivity], random: np.random.Generator, pools: int
) -> Iterator[dict[Key, Sensitivity]]:
    """Generate ``pools`` bootstrap copies of ``sensitivities``, a mapping to `Pool`.

    In a copy every `Pool` has as many surfaces as before, drawn with replacement. Pools with the
    same ``surfaces`` name have the same draws. Each copy draws from ``random`` when it is asked
    for.
    """
    each = [pool for sensitivity in sensitivities.values() for pool in sensitivity.pools]
    sizes = {pool.surfaces: pool.values.shape[1] for pool in each}
    for _ in range(pools):
        chosen = {name: random.integers(size, size=(size,)) for name, size in sizes.items()}
        yield {
            key: Sensitivity(
                levels, base, tuple(Pool(p.values[:, chosen[p.surfaces]], p.surfaces) for p in kept)
            )
            for key, (levels, base, kept) in sensitivities.items()
        }


def repetitions_of_pool(repetitions: int) -> int:
    """Return how many repetitions are drawn from each resampled pool, for so many in total."""
    return max(repetitions // 8, _FEWEST_REPETITIONS)


def pool_error(shares, repetitions: int, again=()) -> np.ndarray:
    """Return the standard errors (...) of shares of repetitions that the surfaces of a pool cause.

    ``shares`` (pools, ...) are those in ``repetitions`` from each resampled pool, NaN if unknown.
    Their variance contains the variance of the repetitions, which is subtracted. With ``again``
    (pools,), the shares (pools,) in other repetitions from the same pools, the error is the root of
    the covariance of both instead. It is NaN where at most half of the shares are known.
    """
    if len(again):
        both = np.array([shares, again], dtype=float)
        both = both[:, np.isfinite(both).all(axis=0)]
        if both.shape[1] <= len(again) // 2:
            return np.array(np.nan)
        return np.sqrt(np.maximum(np.cov(both)[0, 1], 0.0))
    shares = np.asarray(shares, dtype=float)
    known = np.isfinite(shares).sum(axis=0)
    shares = np.where(known > len(shares) // 2, shares, 0.0)
    noise = np.nanmean(shares * (1.0 - shares), axis=0) / repetitions
    variance = np.maximum(np.nanvar(shares, axis=0, ddof=1) - noise, 0.0)
    return np.where(known > len(shares) // 2, np.sqrt(variance), np.nan)


def _moments(pool: Pool, resampled: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means and standard deviations (R, targets) of draws from a pool of N surfaces.

    ``resampled`` (R, N) are the surfaces of the resampled pool of each repetition, ``index`` (R, n)
    the places in it that are drawn.
    """
    chosen = np.take_along_axis(resampled, index, axis=1)
    size = pool.values.shape[1]
    centre = pool.values.mean(axis=1, keepdims=True)
    values = (centre + (pool.values - centre) * (size / (size - 1)))[:, chosen]
    means = values.mean(axis=-1, keepdims=True)
    deviations = values.std(axis=-1, ddof=1, mean=means)
    return means[..., 0].T, deviations.T


class LengthDistribution(NamedTuple):
    """Distribution of the length of an indifference interval over repetitions of a study.

    It is the median, the ends of the ranges of 90 % and 95 %, and the shares of repetitions with an
    infinite length, which have no root, and with a length of 0. A length is 0 if the closures drawn
    at the base do not scatter, as where they are all of the same surface. A range leaves out the
    same probability at both ends. A range that ends at infinity covers more than its nominal
    probability.
    """

    median: float
    low_90: float
    high_90: float
    low_95: float
    high_95: float
    share_without_root: float
    share_zero: float


def length_distribution(lengths: np.ndarray) -> LengthDistribution:
    """Return the distribution of the lengths (R,) of R repetitions, infinite without a root."""
    middle = np.quantile(lengths, 0.5, method="inverted_cdf")
    low = np.quantile(lengths, [0.05, 0.025], method="lower")
    high = np.quantile(lengths, [0.95, 0.975], method="higher")
    without = np.mean(np.isinf(lengths))
    zero = np.mean(lengths == 0.0)
    ends = low[0], high[0], low[1], high[1]
    return LengthDistribution(*map(float, (middle, *ends, without, zero)))


def two_sided_p(lengths: np.ndarray, observed: float) -> float:
    """Compute the two-sided mid-p value of a published length among those of repetitions (R,).

    An ``observed`` NaN is a dash in the published table, an infinite length.
    """
    observed = np.inf if np.isnan(observed) else observed
    shorter = np.count_nonzero(lengths < observed)
    equal = np.count_nonzero(lengths == observed)
    below = (shorter + 0.5 * (equal + 1)) / (lengths.size + 1)
    return float(2.0 * min(below, 1.0 - below))


def share_as_short(lengths: np.ndarray, observed: float) -> float:
    """Return the probability that a repetition has a length of at most the published one.

    ``lengths`` (R,) are those of the repetitions. An ``observed`` NaN, a dash, gives 1.
    """
    observed = np.inf if np.isnan(observed) else observed
    return float((1 + np.count_nonzero(lengths <= observed)) / (lengths.size + 1))


class JointTest(NamedTuple):
    """Composite log-likelihood of a published table, and its rank among repetitions.

    ``standard_error`` is that of the log-likelihood due to the finite number of repetitions.
    """

    log_likelihood: float
    standard_error: float
    p: float  # share of repetitions that are equally or less likely


def joint_test(lengths: np.ndarray, observed: np.ndarray) -> JointTest:
    """Test whether a published table is one of the repetitions of a study.

    ``observed`` (entries,) are its lengths, NaN for a dash, and ``lengths`` (R, entries) those of
    the repetitions.

    Densities are Gaussian kernel estimates of log(length) (Silverman's bandwidth) with a heavy tail
    of weight `TAIL_SHARE`. For p the repetitions are divided into two halves. Each half, and the
    published table with it, is evaluated with the densities of the other half, so that no
    repetition is evaluated with a density to which it contributed. The log-likelihood itself uses
    all repetitions; its standard error is from a jackknife over `GROUPS` groups of repetitions.
    """
    return jackknifed_likelihood(lengths, observed).test(crossed_likelihoods(lengths, observed))


def p_of_table(lengths: np.ndarray, observed: np.ndarray) -> float:
    """Return the p of `joint_test` of a published table, without the log-likelihood.

    Arguments are as for `joint_test`.
    """
    return crossed_likelihoods(lengths, observed).p()


class CrossedLikelihoods(NamedTuple):
    """Log-likelihoods (1 + R/2, entries) of the published table and of a half of the repetitions.

    Each of the two halves is evaluated with the densities of the other one.
    """

    first: np.ndarray
    second: np.ndarray

    def of(self, entries: list[int]) -> "CrossedLikelihoods":
        """Return the log-likelihoods of some entries of the table, by their indices."""
        return CrossedLikelihoods(self.first[:, entries], self.second[:, entries])

    def p(self) -> float:
        """Return the share of repetitions that are at most as likely as the published table.

        NaN if a log-likelihood is NaN.
        """
        if np.isnan(self.first).any() or np.isnan(self.second).any():
            return np.nan
        as_unlikely = repetitions = 0
        for half in self:
            published, *drawn = _entry_sums(half)
            as_unlikely += int(np.count_nonzero(drawn <= published))
            repetitions += len(drawn)
        return float((1 + as_unlikely) / (repetitions + 1))


class JackknifedLikelihood(NamedTuple):
    """Log-likelihoods of the published entries by all repetitions, and without each group."""

    whole: np.ndarray  # (1, entries)
    left_out: np.ndarray  # (GROUPS, entries)

    def of(self, entries: list[int]) -> "JackknifedLikelihood":
        """Return the log-likelihoods of some entries of the table, by their indices."""
        return JackknifedLikelihood(self.whole[:, entries], self.left_out[:, entries])

    def test(self, crossed: CrossedLikelihoods) -> JointTest:
        """Return the test of a table of these entries, with the p of their ``crossed`` ones."""
        error = jackknife_error(_entry_sums(self.left_out))
        return JointTest(float(_entry_sums(self.whole)[0]), float(error), crossed.p())


def crossed_likelihoods(lengths: np.ndarray, observed: np.ndarray) -> CrossedLikelihoods:
    """Evaluate a published table (entries,) and both halves of the repetitions (R, entries).

    ``observed`` is the table, with NaN for a dash.
    """
    halves = lengths[::2], lengths[1::2]
    return CrossedLikelihoods(
        *(
            entry_log_likelihoods(other, np.vstack([observed, half]))
            for half, other in (halves, halves[::-1])
        )
    )


def jackknifed_likelihood(lengths: np.ndarray, observed: np.ndarray) -> JackknifedLikelihood:
    """Evaluate a published table (entries,) by all repetitions and without each group of them.

    ``lengths`` (R, entries) are those of the repetitions, ``observed`` is the table.
    """
    group = np.arange(lengths.shape[0]) % GROUPS
    left_out = [entry_log_likelihoods(lengths[group != i], observed[None]) for i in range(GROUPS)]
    return JackknifedLikelihood(
        entry_log_likelihoods(lengths, observed[None]), np.concatenate(left_out)
    )


def log_likelihoods(lengths: np.ndarray, tables: np.ndarray) -> np.ndarray:
    """Return the composite log-likelihoods (m,) of tables of lengths (m, entries).

    ``lengths`` (R, entries) are those of the repetitions from which the densities are estimated.
    """
    return _entry_sums(entry_log_likelihoods(lengths, tables))


def _entry_sums(logs: np.ndarray) -> np.ndarray:
    """Return sums (m,) of log-likelihoods (m, entries), whose rounding is always the same.

    It does not depend on how the entries were selected.
    """
    return np.ascontiguousarray(logs).sum(axis=1)


def entry_log_likelihoods(lengths: np.ndarray, tables: np.ndarray) -> np.ndarray:
    """Return the log-likelihood of each entry (m, entries) of tables of lengths (m, entries).

    ``lengths`` (R, entries) are those of the repetitions from which the densities are estimated.
    All of an entry is NaN if a length of it is 0, which is of closures without any scatter.
    """
    logs = np.full(tables.shape, np.nan)
    for i, (drawn, published) in enumerate(zip(lengths.T, tables.T, strict=True)):
        if np.any(drawn == 0.0) or np.any(published == 0.0):
            continue
        roots = np.isfinite(drawn)
        without = (np.count_nonzero(~roots) + 0.5) / (drawn.size + 1.0)
        dash = ~np.isfinite(published)
        density = _log_density(np.log(drawn[roots]), np.log(published[~dash]))
        logs[dash, i] = np.log(without)
        logs[~dash, i] = np.log1p(-without) + density
    return logs


def _log_density(draws: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the log density of log(length) at some places (m,), estimated from its draws.

    It is 0 if there are fewer than `FEWEST_ROOTS` draws.
    """
    if draws.size < FEWEST_ROOTS or at.size == 0:
        return np.zeros(at.size)
    quarters = np.quantile(draws, [0.25, 0.5, 0.75])
    scale = (quarters[2] - quarters[0]) / 1.349
    width = 0.9 * min(draws.std(ddof=1), scale) * draws.size**-0.2
    low = draws.min() - 4.0 * width
    high = draws.max() + 4.0 * width
    grid = np.linspace(low, high, GRID) if at.size > GRID else np.sort(at)
    kernel = _mean_kernels(grid, draws, width) / (width * np.sqrt(2.0 * np.pi))
    # density of Student's t with 3 degrees of freedom
    beyond = (at - quarters[1]) / scale
    tail = 2.0 / (np.pi * np.sqrt(3.0) * (1.0 + beyond * beyond / 3.0) ** 2) / scale
    kernel = np.interp(at, grid, kernel, left=0.0, right=0.0)
    return np.log((1.0 - TAIL_SHARE) * kernel + TAIL_SHARE * tail)


def _mean_kernels(grid: np.ndarray, draws: np.ndarray, width: float) -> np.ndarray:
    """Return the means (m,) over all draws of exp(-z^2/2), with z = (grid - draw)/width.

    ``grid`` is (m,). The computation is in blocks, which stay in the cache of a processor.
    """
    means = np.empty(grid.size)
    grid = grid / (np.sqrt(2.0) * width)
    draws = draws / (np.sqrt(2.0) * width)
    rows = max(BLOCK // draws.size, 1)
    for start in range(0, grid.size, rows):
        exponents = grid[start : start + rows, None] - draws
        exponents *= exponents
        np.negative(exponents, out=exponents)
        means[start : start + rows] = np.exp(exponents, out=exponents).mean(axis=1)
    return means
