"""Repetitions of a published study, drawn from pools of closed surfaces.

A study draws n surfaces for every level of every parameter, independently, as the paper did, and
publishes the lengths of its indifference intervals. A pool of N surfaces per case is itself a
sample; therefore a repetition first resamples the pool (N of N, with replacement) and then draws n
surfaces from this. To correct the smaller scatter of a finite pool, values are moved away from its
mean by the factor N/(N - 1). The mean of a repetition at a level then has the variance
s^2/n + s^2/(N - 1) about the mean of the pool (s: its standard deviation, ddof 1), as a new study's
mean has, including the error of the pool. The variance within a repetition is s^2.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeVar

import numpy as np
import scipy

from jointclosure.inputs import InputError, check_number, real_array
from jointclosure.statistics.indifference import indifference_lengths

RESAMPLED_POOLS = 40
"""Number of resampled pools; the relative error of a probability's error is then a ninth."""
_FEWEST_REPETITIONS = 100
Key = TypeVar("Key", bound=tuple[str, ...] | str)


class Pool(NamedTuple):
    """Results (targets, N) on the surfaces of one case; pools of one name are resampled together.

    Pools with the same name of their surfaces have the same surfaces in the same order.
    """

    values: np.ndarray
    surfaces: str


class Sensitivity(NamedTuple):
    """One parameter of one rock: levels (k,), ascending, from ``base``, and a pool for each."""

    levels: np.ndarray
    base: float
    pools: tuple[Pool, ...]


class Design(NamedTuple):
    """Design of a published study: n surfaces per level, and the significance of its t test.

    The parameters of a rock share the surfaces drawn at the base level; the paper does not say.
    """

    draws: int = 20
    significance: float = 0.05

    @property
    def critical_change(self) -> float:
        """Smallest significant difference of two means, in standard deviations: t sqrt(2/n)."""
        t = scipy.stats.t.ppf(1.0 - 0.5 * self.significance, 2 * self.draws - 2)
        return float(t * np.sqrt(2.0 / self.draws))


class DrawnResponse(NamedTuple):
    """Results for one parameter in R repetitions of a study; no root: an infinite length."""

    levels: np.ndarray
    base: float
    means: np.ndarray  # (R, targets, k)
    deviations: np.ndarray
    lengths: np.ndarray  # (R, targets)


def draw_studies(
    sensitivities: Mapping[Key, Sensitivity],
    design: Design,
    repetitions: int,
    random: np.random.Generator,
) -> dict[Key, DrawnResponse]:
    """Draw repetitions of a study with independent draws at every level."""
    _check(sensitivities, design, repetitions)
    resampled: dict[str, np.ndarray] = {}
    at_base: dict[str, np.ndarray] = {}
    drawn = {}
    for key, sensitivity in sensitivities.items():
        chosen = []
        for level, pool in zip(sensitivity.levels, sensitivity.pools, strict=True):
            size, name = pool.values.shape[1], pool.surfaces
            if name not in resampled:
                smallest = np.min_scalar_type(size)
                resampled[name] = random.integers(size, size=(repetitions, size), dtype=smallest)
            index = random.integers(size, size=(repetitions, design.draws))
            if level == sensitivity.base:
                index = at_base.setdefault(name, index)
            chosen.append(np.take_along_axis(resampled[name], index, axis=1))
        drawn[key] = _responses(sensitivity, chosen, design)
    return drawn


def without_effect(sensitivities: Mapping[Key, Sensitivity]) -> dict[Key, Sensitivity]:
    """Return the parameters without any effect: every level draws from the base pool."""
    return {
        key: Sensitivity(levels, base, (pools[list(levels).index(base)],) * len(pools))
        for key, (levels, base, pools) in sensitivities.items()
    }


def resampled_pools(
    sensitivities: Mapping[Key, Sensitivity], random: np.random.Generator, pools: int
) -> Iterator[dict[Key, Sensitivity]]:
    """Generate bootstrap samples of pools."""
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
    """Return the number of repetitions drawn from each resampled pool."""
    return max(repetitions // 8, _FEWEST_REPETITIONS)


def pool_error(shares, repetitions: int, again=()) -> np.ndarray:
    """Return standard errors (...) of shares of repetitions due to the surfaces of the pool."""
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


def _responses(sensitivity, chosen, design) -> DrawnResponse:
    of_pools: list[tuple[np.ndarray, np.ndarray]] = []
    for pool, index in zip(sensitivity.pools, chosen, strict=True):
        size, centre = pool.values.shape[1], pool.values.mean(axis=1, keepdims=True)
        values = (centre + (pool.values - centre) * (size / (size - 1)))[:, index]
        of_pools.append((values.mean(axis=-1).T, values.std(axis=-1, ddof=1).T))
    means, deviations = (np.stack(part, axis=-1) for part in zip(*of_pools, strict=True))
    lengths = indifference_lengths(
        sensitivity.levels, means, deviations, design.draws, design.significance, sensitivity.base
    )
    levels, lengths = np.asarray(sensitivity.levels, float), np.nan_to_num(lengths, nan=np.inf)
    return DrawnResponse(levels, sensitivity.base, means, deviations, lengths)


def _check(sensitivities, design, repetitions) -> None:
    for name, value, least in (("draws", design.draws, 2), ("repetitions", repetitions, 1)):
        check_number(name, value, whole=True)
        if value < least:
            raise InputError(f"{name} = {value}: must be a whole number from {least} on")
    sizes: dict[str, int] = {}
    for key, (levels, base, pools) in sensitivities.items():
        if len(levels) != len(pools) or base not in levels:
            raise InputError(
                f"{key}: {len(pools)} pools for {len(levels)} levels, base = {base!r}: must be "
                "one pool for each level, and base one of the levels"
            )
        for pool in pools:
            values = real_array(f"{key}, pool of {pool.surfaces}", pool.values)
            if values.ndim != 2 or values.shape[1] < 2:
                raise InputError(
                    f"{key}, pool of {pool.surfaces}: shape {values.shape}, must be (targets, N) "
                    "with at least two surfaces"
                )
            if sizes.setdefault(pool.surfaces, values.shape[1]) != values.shape[1]:
                raise InputError(
                    f"{key}, pool of {pool.surfaces}: {values.shape[1]} surfaces, another pool of "
                    f"these surfaces has {sizes[pool.surfaces]}"
                )
