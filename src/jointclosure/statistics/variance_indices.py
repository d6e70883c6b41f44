"""Variance-based sensitivity indices of a mean over random surfaces.

An input u is uniform on [0, 1]. Fitted functions are orthonormal: for a continuous quantity
Legendre polynomials up to the third degree, for a quantity with k values (u falls into one of k
equal parts) k - 1 contrasts. A fit has the functions of each input, and products of the first
functions of two inputs. Its variance indices are exact sums of squared coefficients (polynomial
chaos; Sudret, Reliab. Eng. Syst. Saf. 93, 964, 2008).

The surfaces are noise in every simulation. A design has N rows of d + 2 points of the unit cube:
A, B, and A with one input of B each (Saltelli et al., Comput. Phys. Commun. 181, 259, 2010). Two
surfaces belong to a row, the same at all its points. With f_s the response on surface s, and m(x)
its mean over all surfaces, products of two *different* surfaces have no noise in the mean:

    total variance          V   = E[(A - B)_1 (A - B)_2]/2
    variance by i and more  V_Ti = E[(A - AB_i)_1 (A - AB_i)_2]/2
    variance by i alone     V_i = E[B_1 (AB_i - A)_2 + B_2 (AB_i - A)_1]/2

These are indices of m, without a surrogate. To reduce their error, the same sums over a fitted
function g are subtracted, and the variances of g, which are known exactly, are added (a control
variate; the g of each row is fitted to other rows).
"""

from collections.abc import Mapping
from itertools import combinations
from math import factorial
from typing import NamedTuple

import numpy as np
import scipy
from scipy.special import ndtr, ndtri

from jointclosure.inputs import InputError

_DEGREE = 3  # of the polynomials of a continuous input
FOLDS = 8
"""Number of parts of the rows; each part is left out of the fit that reduces its error."""


class Term(NamedTuple):
    """Product of functions of single inputs: (input, number of the function) of each factor."""

    factors: tuple[tuple[int, int], ...]

    @property
    def inputs(self) -> frozenset[int]:
        """Return the inputs that the term depends on."""
        return frozenset(factor for factor, _ in self.factors)


class FittedFunction(NamedTuple):
    """Sum of orthonormal terms of d inputs in [0, 1], fitted by least squares.

    ``values`` (d,) are the numbers of values of the inputs, 0 for continuous ones;
    ``coefficients`` (terms,) those of the ``terms``.
    """

    values: tuple[int, ...]
    terms: tuple[Term, ...]
    coefficients: np.ndarray

    def __call__(self, points) -> np.ndarray:
        """Evaluate the fitted function at points (..., d) of the unit cube."""
        return design_matrix(points, self.values, self.terms) @ self.coefficients

    def first(self, one: int) -> float:
        """Return the variance of the function due to one input alone, by its number."""
        return self._variance(lambda inputs: inputs == {one})

    def total(self, one: int) -> float:
        """Return the variance of the function due to one input, including its interactions."""
        return self._variance(lambda inputs: one in inputs)

    @property
    def variance(self) -> float:
        """Variance of the fitted function over the unit cube."""
        return self._variance(bool)

    def _variance(self, counts) -> float:
        """Return the variance due to the terms whose inputs the function ``counts`` accepts."""
        squares = zip(self.terms, self.coefficients**2, strict=True)
        return float(sum(square for term, square in squares if counts(term.inputs)))


def terms_of(values: tuple[int, ...]) -> tuple[Term, ...]:
    """Return the terms of a fit: a constant, functions of each input, and products of two inputs.

    ``values`` (d,) are the numbers of values of the inputs, 0 for continuous ones.
    """
    terms = [Term(())]
    for one, count in enumerate(values):
        terms += [Term(((one, number),)) for number in range(count - 1 if count else _DEGREE)]
    for one, other in combinations(range(len(values)), 2):
        for first in range(max(values[one] - 1, 1)):
            for second in range(max(values[other] - 1, 1)):
                terms.append(Term(((one, first), (other, second))))
    return tuple(terms)


def design_matrix(points, values: tuple[int, ...], terms: tuple[Term, ...]) -> np.ndarray:
    """Return the values (..., terms) of the terms at points (..., d) of the unit cube.

    ``values`` (d,) are the numbers of values of the inputs, 0 for continuous ones.
    """
    points = np.asarray(points, dtype=float)
    functions = [
        _contrasts(points[..., one], count) if count else _legendre(points[..., one])
        for one, count in enumerate(values)
    ]
    columns = np.ones((*points.shape[:-1], len(terms)))
    for place, term in enumerate(terms):
        for one, number in term.factors:
            columns[..., place] *= functions[one][..., number]
    return columns


def fit_function(points, response, values: tuple[int, ...]) -> FittedFunction:
    """Fit a function to a response (n,) at points (n, d) of the unit cube, by least squares.

    ``values`` (d,) are the numbers of values of the inputs, 0 for continuous ones.
    """
    terms = terms_of(values)
    matrix = design_matrix(points, values, terms)
    return FittedFunction(
        values, terms, np.linalg.lstsq(matrix, np.asarray(response, float), rcond=None)[0]
    )


def level_of(u, count: int):
    """Return the number, from 0, of the level for which u in [0, 1] stands.

    Each of the ``count`` levels of a factor has an equal part of this range, in their order.
    """
    return np.minimum((np.asarray(u) * count).astype(int), count - 1)


def _legendre(u: np.ndarray) -> np.ndarray:
    """Return the Legendre polynomials (..., 3) of degrees 1 to 3 at u (...), normed on [0, 1]."""
    basis = np.polynomial.legendre.Legendre.basis
    degrees = range(1, _DEGREE + 1)
    return np.stack([np.sqrt(2.0 * k + 1.0) * basis(k)(2.0 * u - 1.0) for k in degrees], axis=-1)


def _contrasts(u: np.ndarray, count: int) -> np.ndarray:
    """Return the Helmert contrasts (..., count - 1) of the level for which u (...) stands.

    They have mean 0 and variance 1 over the ``count`` levels.
    """
    contrasts = np.zeros((count, count - 1))
    for number in range(count - 1):
        contrasts[: number + 1, number] = -1.0
        contrasts[number + 1, number] = number + 1.0
        contrasts[:, number] /= np.sqrt(np.mean(contrasts[:, number] ** 2))
    return contrasts[level_of(u, count)]


class Indices(NamedTuple):
    """Sensitivity indices (d,) of the mean over surfaces to d inputs, and their standard errors."""

    first: np.ndarray  # relative to the variance, like total; both NaN if it is not above 0
    first_error: np.ndarray
    total: np.ndarray
    total_error: np.ndarray
    variance: float
    variance_error: float
    surfaces: float  # share of the variance of a single simulation that is due to the surfaces
    surfaces_error: float
    fit_share: float  # share of the variance that the fitted functions explain


def sampled_rows(inputs: int, rows: int, seed: int) -> np.ndarray:
    """Return Saltelli's design (rows, inputs + 2, inputs) of scrambled Sobol points.

    A row has the points A and B, and for each input the point A with this input taken from B. The
    number of rows should be a power of two.
    """
    a, b = _sobol_points(2 * inputs, rows, seed).reshape(rows, 2, inputs).swapaxes(0, 1)
    points = np.repeat(a[:, None, :], inputs + 2, axis=1)
    points[:, 1] = b
    for one in range(inputs):
        points[:, 2 + one, one] = b[:, one]
    return points


def _sobol_points(inputs: int, rows: int, seed: int) -> np.ndarray:
    """Return scrambled Sobol points (rows, inputs) of the unit cube."""
    random = np.random.default_rng(seed)
    return scipy.stats.qmc.Sobol(inputs, scramble=True, rng=random).random(rows)


def variance_indices(points, responses, values: tuple[int, ...]) -> Indices:
    """Estimate the first and total sensitivity indices of d inputs (see the module).

    ``points`` (N, d + 2, d) are as from `sampled_rows`, ``responses`` (N, d + 2, 2) are the results
    there on two surfaces, and ``values`` (d,) are the numbers of values of the inputs, 0 for
    continuous ones. Raise `InputError` for other shapes, fewer than 16 rows, or responses that are
    not finite.
    """
    points = np.asarray(points, float)
    responses = np.asarray(responses, float)
    n, columns, d = points.shape
    if responses.shape != (n, columns, 2) or columns != d + 2 or len(values) != d:
        raise InputError(
            f"points {points.shape}, responses {responses.shape}, values ({len(values)},): must be "
            "(N, d + 2, d), (N, d + 2, 2) and (d,)"
        )
    if n < 2 * FOLDS:
        raise InputError(f"{n} rows: must be {2 * FOLDS} or more")
    if not np.isfinite(responses).all():
        raise InputError("responses: must be finite")
    centred = responses - responses.mean()
    terms = _row_terms(centred)
    explained = 0.0
    for first in range(FOLDS):
        part = np.arange(first, n, FOLDS)
        others = np.setdiff1d(np.arange(n), part)
        fit = fit_function(points[others].reshape(-1, d), centred[others].mean(-1).ravel(), values)
        model = fit(points[part])
        # the same products of the fit, which has no noise, and their exact means
        both = np.stack([model, model], axis=-1)
        exact = [fit.variance, *map(fit.first, range(d)), *map(fit.total, range(d))]
        terms[part] += np.array(exact, float) - _row_terms(both)
        explained += fit.variance * part.size / n
    noise = 0.5 * np.mean((responses[..., 0] - responses[..., 1]) ** 2, axis=1)
    whole = terms[:, 0].mean()
    with np.errstate(invalid="ignore", divide="ignore"):
        errors = _jackknife_errors(terms, noise)
    if not whole > 0.0:  # below the noise of the surfaces: shares are undefined
        terms[:, 1:] = np.nan
        errors[1:-1] = np.nan
        explained = np.nan
        whole = max(whole, 0.0)
    joint = whole + noise.mean()
    over = whole or np.nan
    return Indices(
        first=terms[:, 1 : d + 1].mean(axis=0) / over,
        first_error=errors[1 : d + 1],
        total=terms[:, d + 1 :].mean(axis=0) / over,
        total_error=errors[d + 1 : -1],
        variance=float(whole),
        variance_error=float(errors[0]),
        surfaces=float(noise.mean() / joint) if joint else 0.0,
        surfaces_error=float(errors[-1]),
        fit_share=float(explained / over),
    )


def shapley_effects(
    values: tuple[int, ...],
    coefficients,
    correlations: Mapping[tuple[int, int], float] | None = None,
    draws: int = 2048,
) -> np.ndarray:
    """Compute the Shapley effects (d, ...) of inputs: shares of a variance that sum to 1.

    The variance is that of fitted functions, whose ``coefficients`` (terms, ...) are those of the
    terms from `terms_of`. ``values`` (d,) are the numbers of values of the inputs, 0 for continuous
    ones. ``correlations`` are those of pairs of inputs as normal variables, by their numbers; other
    pairs are independent (Owen and Prieur, SIAM/ASA J. Uncertain. Quantif. 5, 986, 2017).

    The variance of a term of independent inputs is shared equally by its inputs. The other terms
    are grouped by the independent inputs that they contain, and each group is a game. The variance
    due to inputs J is there the covariance of responses that have only x_J in common, from
    ``draws`` points. Raise `InputError` if the correlations are not those of normal variables.
    """
    d = len(values)
    coefficients = np.asarray(coefficients, dtype=float)
    bound = frozenset(one for pair in correlations or {} for one in pair)
    effects = np.zeros((d, *coefficients.shape[1:]))
    games: dict[frozenset[int], list[int]] = {}
    for number, term in enumerate(terms_of(values)):
        if term.inputs & bound:
            games.setdefault(term.inputs - bound, []).append(number)
            continue
        for one in term.inputs:
            effects[one] += coefficients[number] ** 2 / len(term.inputs)
    for apart, numbers in games.items():
        players = sorted(bound | apart)
        effects[players] += _shapley_values(
            players, values, numbers, coefficients[numbers], correlations or {}, draws
        )
    return effects / effects.sum(axis=0)


def _shapley_values(players, values, numbers, coefficients, correlations, draws) -> np.ndarray:
    """Return the Shapley values (players, ...) of the variance of some terms of the ``players``.

    The players are the inputs of these terms. ``numbers`` are the places of the terms in
    `terms_of`, ``coefficients`` (numbers, ...) their coefficients.
    """
    place = {one: at for at, one in enumerate(players)}
    terms = terms_of(values)
    factors = (terms[number].factors for number in numbers)
    player_terms = tuple(Term(tuple((place[i], k) for i, k in pairs)) for pairs in factors)
    among = {(place[one], place[other]): value for (one, other), value in correlations.items()}
    d = len(players)
    subsets = [frozenset(some) for size in range(d + 1) for some in combinations(range(d), size)]
    counts = tuple(values[one] for one in players)
    variances = dict(_sampled_variances(counts, player_terms, coefficients, among, draws, subsets))
    shares = np.zeros((d, *coefficients.shape[1:]))
    for some in subsets[:-1]:
        weight = factorial(len(some)) * factorial(d - len(some) - 1) / factorial(d)
        for one in set(range(d)) - some:
            shares[one] += weight * (variances[some | {one}] - variances[some])
    return shares


def _sampled_variances(values, terms, coefficients, correlations, draws, subsets):
    """Generate each of the ``subsets`` of dependent inputs, and the variance (...) due to it.

    The variance is the covariance of two responses at points that have the inputs of the subset in
    common. The other inputs of the second point are drawn from their normal distribution given
    those in common.
    """
    d = len(values)
    matrix = np.eye(d)
    for (one, other), correlation in correlations.items():
        matrix[one, other] = matrix[other, one] = correlation
    if np.linalg.eigvalsh(matrix)[0] <= 0.0:
        raise InputError(
            f"correlations {dict(correlations)}: must be correlations of normal variables"
        )
    random = _sobol_points(2 * d, draws, 0)
    normal = ndtri(random[:, :d])
    other = ndtri(random[:, d:])
    first = normal @ np.linalg.cholesky(matrix).T
    response = design_matrix(ndtr(first), values, terms) @ coefficients
    centred = response - response.mean(axis=0)
    for some in subsets:
        held = sorted(some)
        free = [i for i in range(d) if i not in some]
        if not some or not free:
            yield some, (centred**2).mean(axis=0) if some else np.zeros(response.shape[1:])
            continue
        # conditional normal distribution of the free inputs: mean and covariance
        slopes = np.linalg.solve(matrix[np.ix_(held, held)], matrix[np.ix_(held, free)])
        left = matrix[np.ix_(free, free)] - matrix[np.ix_(free, held)] @ slopes
        second = first.copy()
        second[:, free] = first[:, held] @ slopes
        second[:, free] += other[:, : len(free)] @ np.linalg.cholesky(left).T
        again = design_matrix(ndtr(second), values, terms) @ coefficients
        yield some, (centred * (again - again.mean(axis=0))).mean(axis=0)


def _row_terms(responses: np.ndarray) -> np.ndarray:
    """Return the products (N, 1 + 2 d) of each row whose means are V, every V_i and every V_Ti.

    ``responses`` (N, d + 2, 2) are those of the design, with mean 0.
    """
    a = responses[:, 0]
    b = responses[:, 1]
    mixed = responses[:, 2:]
    change = mixed - a[:, None, :]
    first = 0.5 * (b[:, None, 0] * change[..., 1] + b[:, None, 1] * change[..., 0])
    total = 0.5 * change[..., 0] * change[..., 1]
    whole = 0.5 * np.prod(a - b, axis=-1)
    return np.concatenate([whole[:, None], first, total], axis=1)


def _jackknife_errors(terms: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the standard errors (2 + 2 d,) of V, of all V_i/V and V_Ti/V, and of the noise.

    ``terms`` (N, 1 + 2 d) are as from `_row_terms`. ``noise`` (N,) are variances due to the
    surfaces; its error is that of its share in the variance of a single simulation. Each row is
    left out once.
    """
    n = noise.size
    left = (terms.sum(axis=0) - terms) / (n - 1)
    quiet = (noise.sum() - noise) / (n - 1)
    whole = left[:, :1]
    surfaces = (quiet / (whole[:, 0] + quiet))[:, None]
    values = np.concatenate([whole, left[:, 1:] / whole, surfaces], axis=1)
    return np.sqrt((n - 1) / n * ((values - values.mean(axis=0)) ** 2).sum(axis=0))
