"""Least squares in functions that are orthonormal over a unit cube, and their variance indices.

An input u is uniform on [0, 1]. Of a quantity that varies continuously the functions are
Legendre polynomials to the third degree; of one with k values (u falls into one of k equal
parts) they are k - 1 contrasts. A fit has the functions of each input and products of the first
functions of two. Its variance indices are sums of squared coefficients, exactly (polynomial
chaos; Sudret, Reliab. Eng. Syst. Saf. 93, 964, 2008).
"""

import itertools
from typing import NamedTuple

import numpy as np

_DEGREE = 3


class Term(NamedTuple):
    """A product of functions: (input, number of the function) of each factor."""

    factors: tuple[tuple[int, int], ...]

    @property
    def inputs(self) -> frozenset[int]:
        """The inputs that it depends on."""
        return frozenset(each for each, _ in self.factors)


class Fit(NamedTuple):
    """Terms and their coefficients; ``values`` (d,) are the numbers of values, 0: continuous."""

    values: tuple[int, ...]
    terms: tuple[Term, ...]
    coefficients: np.ndarray

    def __call__(self, points) -> np.ndarray:
        """The fitted function at points (..., d) of the unit cube."""
        return design_matrix(points, self.values, self.terms) @ self.coefficients

    def first(self, one: int) -> float:
        """Variance by one input alone."""
        return self._variance(lambda inputs: inputs == {one})

    def total(self, one: int) -> float:
        """Variance in which an input has a part."""
        return self._variance(lambda inputs: one in inputs)

    @property
    def variance(self) -> float:
        """Of the fitted function over the cube."""
        return self._variance(bool)

    def _variance(self, counts) -> float:
        squares = zip(self.terms, self.coefficients**2, strict=True)
        return float(sum(square for term, square in squares if counts(term.inputs)))


def terms_of(values: tuple[int, ...]) -> tuple[Term, ...]:
    """The terms of a fit for inputs with so many values (0: continuous)."""
    terms = [Term(())]
    for one, count in enumerate(values):
        terms += [Term(((one, number),)) for number in range(count - 1 if count else _DEGREE)]
    for one, other in itertools.combinations(range(len(values)), 2):
        for first in range(max(values[one] - 1, 1)):
            for second in range(max(values[other] - 1, 1)):
                terms.append(Term(((one, first), (other, second))))
    return tuple(terms)


def design_matrix(points, values: tuple[int, ...], terms: tuple[Term, ...]) -> np.ndarray:
    """The terms (..., terms) at points (..., d) of the unit cube."""
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
    """Least squares fit of a response (n,) at points (n, d) of the unit cube."""
    terms = terms_of(values)
    matrix = design_matrix(points, values, terms)
    return Fit(values, terms, np.linalg.lstsq(matrix, np.asarray(response, float), rcond=None)[0])


def part_of(u, count: int):
    """Into which of ``count`` equal parts of [0, 1] numbers fall, from 0 on."""
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
    """Helmert contrasts of the parts, of mean 0 and variance 1 over the parts."""
    contrasts = np.zeros((count, count - 1))
    for number in range(count - 1):
        contrasts[: number + 1, number] = -1.0
        contrasts[number + 1, number] = number + 1.0
        contrasts[:, number] /= np.sqrt(np.mean(contrasts[:, number] ** 2))
    return contrasts[part_of(u, count)]
