"""Efficiency of control variates: the number of plain simulations with the same errors.

Studies are drawn repeatedly from an ensemble's surfaces, as if these were all surfaces. Each is
evaluated without and with adjustment, with the uncertainty of the covariates' means. This gives the
scatter of the estimates, and how often their intervals contain the value of the ensemble.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.claims.findings import TARGET
from jointclosure.ensemble.covariates import Covariates
from jointclosure.sensitivity.responses import Response, responses
from jointclosure.statistics.control_variates import (
    Known,
    adjusted_and_coefficients,
    adjusted_deviations,
    fewest_surfaces,
    worth,
)
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import deviations_of, fit_matrix

REPETITIONS = 1000
"""Number of studies drawn for each response: an error is known to 2 %, a coverage to 1 %."""
_CONFIDENCE = 0.95
_COLUMNS: tuple[str, ...] = (
    "rock",
    "parameter",
    "response",
    "cycle",
    "draws",
    "surfaces",
    "value",
    "plain_error",
)
_COLUMNS += ("adjusted_error", "worth", "plain_simulations", "plain_coverage", "adjusted_coverage")


class _Drawn(NamedTuple):
    """Drawn studies: samples (R, k, n) and covariates (R, k, n, m) about their known means.

    ``known`` contains only the errors of these means; ``paired``: common draws; ``tell_scatter`` as
    in `Covariates`.
    """

    samples: np.ndarray
    covariates: np.ndarray
    known: Known
    paired: bool
    tell_scatter: bool


class _Estimates(NamedTuple):
    """Estimates (R,) of drawn studies, their standard errors (R,) and the true value."""

    values: np.ndarray
    errors: np.ndarray
    truth: float


def variance_reduction(
    ensemble: xr.Dataset,
    covariates: Covariates | None,
    surfaces: int,
    significance: float,
    root_seed: int,
    repetitions: int = REPETITIONS,
) -> pd.DataFrame:
    """Tabulate errors of plain and adjusted estimates, for every rock, parameter and cycle.

    Parameters
    ----------
    ensemble : Dataset
        A study or, better, its pool.
    covariates : Covariates or None
        Covariates of the ensemble; there are no rows without them.
    surfaces : int
        Surfaces of each case in drawn studies; no rows for fewer than `fewest_surfaces`.
    significance : float
        Significance level of the indifference intervals.

    Returns
    -------
    DataFrame
        ``response``: the mean and the standard deviation at the base (parameter "base"), the
        difference between the highest and lowest level, the slope at the base and the
        indifference interval. ``draws`` of the studies: common only if those of the ensemble are.
        ``value``: that of the ensemble; ``plain_error`` and ``adjusted_error``: root mean squares
        of the difference from it over studies, in m or m per SI unit of the parameter. Errors of
        intervals are those of 1/length, 0 without a root, in 1 over that unit. ``worth``: number
        of plain simulations that one adjusted one replaces; ``plain_simulations``: the same per
        case. Coverage is that of 95 % intervals.
    """
    rows: list[dict] = []
    seen = set()
    for response in responses(ensemble, TARGET, covariates):
        if response.covariates is None:
            continue
        if surfaces < fewest_surfaces(response.covariates.values.shape[-1]):
            continue
        random = generator(
            seed_of(root_seed, "variance", response.rock, response.parameter, response.cycle)
        )
        for draws in ("independent", "common") if response.paired else ("independent",):
            drawn = _draw(response, surfaces, repetitions, draws == "common", random)
            for parameter, name, pair in _estimates(response, drawn, significance):
                key = (response.rock, parameter, name, response.cycle, draws)
                if key in seen:  # the base is the same for all parameters
                    continue
                seen.add(key)
                rows.append(
                    {"rock": response.rock, "parameter": parameter, "response": name}
                    | {"cycle": response.cycle, "draws": draws, "surfaces": surfaces}
                    | _compared(name, surfaces, *pair, response, draws)
                )
    return pd.DataFrame(rows, columns=_COLUMNS)


def _draw(response: Response, n: int, repetitions: int, paired: bool, random) -> _Drawn:
    """Draw studies of n surfaces, with errors of the covariates' means."""
    values, (_, covariance, known_from), tell_scatter = response.covariates  # type: ignore[misc]
    k, size = response.samples.shape
    m = values.shape[-1]
    index = random.integers(size, size=(repetitions, 1 if paired else k, n))
    different = 1 + (np.diff(np.sort(index, axis=2), axis=2) > 0).sum(axis=2)
    # studies with too few different surfaces for a fit are left out
    index = index[(different >= 2 * m + 3).all(axis=1)]
    repetitions = len(index)
    index = np.broadcast_to(index, (repetitions, k, n))
    samples = np.take_along_axis(response.samples[None], index, axis=2)
    # shift and scale covariates, so that their means and covariances over these surfaces are the
    # known ones
    centred = values - values.mean(axis=1, keepdims=True)
    covariance_here = np.cov(np.concatenate(centred).T, ddof=0).reshape(m, m)
    centred = centred @ np.linalg.solve(
        np.linalg.cholesky(covariance_here).T, np.linalg.cholesky(covariance).T
    )
    chosen = np.take_along_axis(centred[None], index[..., None], axis=2)
    off = random.multivariate_normal(np.zeros(m), covariance / known_from, size=repetitions)
    known = Known(np.zeros(m), covariance, known_from)
    return _Drawn(samples, chosen + off[:, None, None, :], known, paired, tell_scatter)


def _estimates(
    response: Response, drawn: _Drawn, significance: float
) -> Iterator[tuple[str, str, tuple[_Estimates, _Estimates]]]:
    """Generate parameter, name, and the plain and adjusted estimates of every response."""
    levels, base = response.levels, response.base
    adjusted, coefficients = adjusted_and_coefficients(
        drawn.samples, drawn.covariates, drawn.known.means
    )
    at_base = (levels == base).astype(float)
    ends = np.zeros(levels.size)
    ends[[0, -1]] = -1.0, 1.0
    slope = fit_matrix(levels, base)[1] / (0.5 * (levels[-1] - levels[0]))
    contrasts = [(response.parameter, "difference", ends), (response.parameter, "slope", slope)]
    if not drawn.paired:
        contrasts = [("base", "mean", at_base), *contrasts]
    for parameter, name, weights in contrasts:
        truth = float(weights @ response.samples.mean(axis=1))
        plain = _contrast(drawn.samples, None, weights, drawn)
        better = _contrast(adjusted, coefficients, weights, drawn)
        yield parameter, name, (_Estimates(*plain, truth), _Estimates(*better, truth))
    if not drawn.paired:
        yield from _of_deviations(response, drawn, adjusted.mean(axis=2), significance)


def _contrast(samples, coefficients, weights, drawn: _Drawn) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum of weights (k,) times means, and its standard error: (R,) each."""
    n = samples.shape[2]
    if drawn.paired:
        variance = np.einsum("k,rkn->rn", weights, samples).var(axis=1, ddof=1) / n
    else:
        variance = samples.var(axis=2, ddof=1) @ weights**2 / n
    if coefficients is not None:
        both = np.einsum("k,rkm->rm", weights, coefficients.mean(axis=2))
        _, covariance, known_from = drawn.known
        variance = variance + np.einsum("rm,ml,rl->r", both, covariance, both) / known_from
    return samples.mean(axis=2) @ weights, np.sqrt(variance)


def _of_deviations(response: Response, drawn: _Drawn, means, significance):
    """Return the standard deviation at the base, and the length of the indifference interval."""
    n, levels, base = drawn.samples.shape[2], response.levels, response.base
    here = int(np.flatnonzero(levels == base)[0])
    plain, plain_errors = deviations_of(drawn.samples)
    adjusted, errors = adjusted_deviations(
        drawn.samples, drawn.covariates, drawn.known, drawn.tell_scatter
    )
    truth = float(response.samples[here].std())
    yield (
        "base",
        "standard deviation",
        (
            _Estimates(plain[:, here], plain_errors[:, here], truth),
            _Estimates(adjusted[:, here], errors[:, here], truth),
        ),
    )
    of = {"samples": n, "significance": significance, "base": base}
    of_ensemble = response.samples.mean(axis=1), response.samples.std(axis=1)
    drawn_means = drawn.samples.mean(axis=2)
    expected, first, second = (
        np.nan_to_num(1.0 / indifference_lengths(levels, *moments, **of))
        for moments in (of_ensemble, (drawn_means, plain), (means, adjusted))
    )
    unknown = np.full(first.size, np.nan)
    truth = float(expected)
    pair = _Estimates(first, unknown, truth), _Estimates(second, unknown, truth)
    yield response.parameter, "interval", pair


def _compared(name, surfaces, plain: _Estimates, adjusted: _Estimates, response, draws) -> dict:
    """Return both errors, and the worth from their ratio."""
    levels = 1 if name in ("mean", "standard deviation") else 2
    freedom = surfaces - 1 if draws == "common" else levels * (surfaces - 1)
    reach = float(scipy.stats.t.ppf(0.5 + 0.5 * _CONFIDENCE, freedom))
    row: dict[str, float] = {"value": plain.truth}
    for kind, estimates in (("plain", plain), ("adjusted", adjusted)):
        off = np.abs(estimates.values - estimates.truth)
        row[f"{kind}_error"] = float(np.sqrt(np.mean(off**2)))
        if name != "interval":
            row[f"{kind}_coverage"] = float(np.mean(off <= reach * estimates.errors))
    gain = worth(row["plain_error"], row["adjusted_error"])
    return row | {"worth": gain, "plain_simulations": surfaces * gain}
