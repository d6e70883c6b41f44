"""Least squares in functions that are orthonormal over a unit cube, and their variance indices.

An input u is uniform on [0, 1]. For a continuous quantity the functions are Legendre polynomials up
to the third degree. For a quantity with k values (u falls into one of k equal parts) they are k - 1
contrasts. A fit contains the functions of each input, and products of the first functions of two
inputs. Its variance indices are exact sums of squared coefficients (polynomial chaos; Sudret,
Reliab. Eng. Syst. Saf. 93, 964, 2008).
"""

import itertools
from typing import NamedTuple

import numpy as np

_DEGREE = 3


class Term(NamedTuple):
    """Product of functions: (input, number of the function) of each factor."""

    factors: tuple[tuple[int, int], ...]

    @property
    def inputs(self) -> frozenset[int]:
        """Inputs that the term depends on."""
        return frozenset(factor for factor, _ in self.factors)


class Fit(NamedTuple):
    """Terms and coefficients; ``values`` (d,) are the numbers of values (0: continuous input)."""

    values: tuple[int, ...]
    terms: tuple[Term, ...]
    coefficients: np.ndarray

    def __call__(self, points) -> np.ndarray:
        """Evaluate the fitted function at points (..., d) of the unit cube."""
        return design_matrix(points, self.values, self.terms) @ self.coefficients

    def first(self, one: int) -> float:
        """Return the variance due to one input alone."""
        return self._variance(lambda inputs: inputs == {one})

    def total(self, one: int) -> float:
        """Return the variance due to an input, including its interactions."""
        return self._variance(lambda inputs: one in inputs)

    @property
    def variance(self) -> float:
        """Variance of the fitted function over the cube."""
        return self._variance(bool)

    def _variance(self, counts) -> float:
        squares = zip(self.terms, self.coefficients**2, strict=True)
        return float(sum(square for term, square in squares if counts(term.inputs)))


def terms_of(values: tuple[int, ...]) -> tuple[Term, ...]:
    """Return the terms of a fit for inputs with given numbers of values (0: continuous)."""
    terms = [Term(())]
    for one, count in enumerate(values):
        terms += [Term(((one, number),)) for number in range(count - 1 if count else _DEGREE)]
    for one, other in itertools.combinations(range(len(values)), 2):
        for first in range(max(values[one] - 1, 1)):
            for second in range(max(values[other] - 1, 1)):
                terms.append(Term(((one, first), (other, second))))
    return tuple(terms)


def design_matrix(points, values: tuple[int, ...], terms: tuple[Term, ...]) -> np.ndarray:
    """Evaluate the terms (..., terms) at points (..., d) of the unit cube."""
    points = np.asarray(points, dtype=float)
    functions = [
        _contrasts(points[..., one], count) if count else _legendre(points[..., one])
        for one, count in enumerate(values)
    ]
    columns = []
    for term in terms:
        column = np.ones(points.shape[:-1])
        for one, number in term.factors:
            column = column * functions[one][..., number]
        columns.append(column)
    return np.stack(columns, axis=-1)


def fitted(points, response, values: tuple[int, ...]) -> Fit:
    """Fit a response (n,) at points (n, d) of the unit cube by least squares."""
    terms = terms_of(values)
    matrix = design_matrix(points, values, terms)
    return Fit(values, terms, np.linalg.lstsq(matrix, np.asarray(response, float), rcond=None)[0])


def part_of(u, count: int):
    """Return the index, from 0, of the one of ``count`` equal parts of [0, 1] that contains u."""
    return np.minimum((np.asarray(u) * count).astype(int), count - 1)


def _legendre(u: np.ndarray) -> np.ndarray:
    t = 2.0 * u - 1.0
    return np.stack(
        [
            np.sqrt(2.0 * degree + 1.0) * np.polynomial.legendre.Legendre.basis(degree)(t)
            for degree in range(1, _DEGREE + 1)
        ],
        axis=-1,
    )


def _contrasts(u: np.ndarray, count: int) -> np.ndarray:
    """Return Helmert contrasts of the parts, with mean 0 and variance 1 over the parts."""
    contrasts = np.zeros((count, count - 1))
    for number in range(count - 1):
        contrasts[: number + 1, number] = -1.0
        contrasts[number + 1, number] = number + 1.0
        contrasts[:, number] /= np.sqrt(np.mean(contrasts[:, number] ** 2))
    return contrasts[part_of(u, count)]
