"""A rock's model as a study knows it: mean closures of its cases, and what claims ask of them."""

from collections.abc import Callable, Hashable, Mapping
from typing import TypeVar

import numpy as np

from jointclosure.claims.found import LOOP, TARGET
from jointclosure.sensitivity.responses import RockSample
from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.standard_errors import Estimate

SQUARE = "squared deviation"
"""Target whose mean is the variance of the maximum closure, ddof 1 [m2]."""

Means = np.ndarray
"""Means (targets, cases) of a `RockSample`."""
Name = TypeVar("Name", bound=Hashable)


class ClosedModel:
    """Mean closures of all cases of a rock, as `jointclosure.claims.statements.Closed`.

    ``critical``: t sqrt(2/n) of a study's test, by which a mean must change in standard
    deviations of a closure to be significant.
    """

    def __init__(self, sample: RockSample, means: Means, critical: float) -> None:
        self.sample = sample
        self.means = means
        self.critical = critical
        self._fits: dict[tuple[str, int, str], Quadratic] = {}

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> float:
        """d ln(closure)/d ln(parameter) at the rock's own value, of the quadratic of Eq. (24)."""
        fit = self._fit(parameter, cycle, variable)
        return fit.c / fit.d * self.sample.levels[parameter].base / fit.half_range

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[float]:
        """Elasticity from each level to the next, about their middle."""
        levels, target = self.sample.levels[parameter], self.sample.target(variable, cycle)
        means = self.means[target, levels.cases]
        return [
            float((after - before) / (after + before) * (upper + lower) / (upper - lower))
            for before, after, lower, upper in zip(
                means, means[1:], levels.values, levels.values[1:], strict=False
            )
        ]

    def change(self, parameter: str, cycle: int, change: float) -> float:
        """Relative change of the mean closure with a change of the parameter [SI]."""
        fit = self._fit(parameter, cycle, TARGET)
        return float(fit.at(self.sample.levels[parameter].base + change) / fit.d - 1.0)

    def loop(self, cycle: int) -> float:
        """Mean loop over the mean closure, of the rock as it is."""
        return float(self._at_base(LOOP, cycle) / self._at_base(TARGET, cycle))

    def significant(self, cycle: int) -> float:
        """Relative change of a mean that a study finds, of joints that scatter as the rock's."""
        return float(
            self.critical * np.sqrt(self._at_base(SQUARE, cycle)) / self._at_base(TARGET, cycle)
        )

    def _at_base(self, variable: str, cycle: int) -> float:
        return self.means[self.sample.target(variable, cycle), 0]

    def _fit(self, parameter: str, cycle: int, variable: str) -> Quadratic:
        key = parameter, cycle, variable
        if key not in self._fits:
            levels, target = self.sample.levels[parameter], self.sample.target(variable, cycle)
            means = self.means[target, levels.cases]
            self._fits[key] = fit_quadratic(levels.values, means, levels.base)
        return self._fits[key]


def estimated(
    numbers: Callable[[Means], Mapping[Name, float]], sample: RockSample
) -> dict[Name, Estimate]:
    """Numbers that follow from means, with their standard errors.

    The errors are to first order in those of the means, whose covariance is that over surfaces:
    what surfaces of a pool have in common at all levels cancels in differences.
    """
    targets, cases, n = sample.values.shape
    means = sample.values.mean(axis=2)
    covariance = np.atleast_2d(np.cov(sample.values.reshape(targets * cases, n))) / n
    if not sample.paired:
        same_case = np.tile(np.eye(cases, dtype=bool), (targets, targets))
        covariance = np.where(same_case, covariance, 0.0)
    errors = np.sqrt(np.diag(covariance))
    found = numbers(means)
    gradients = np.zeros((len(found), errors.size))
    for i in np.flatnonzero(errors):
        step = np.zeros(errors.size)
        step[i] = 0.1 * errors[i]
        up, down = (
            np.array(list(numbers(means + sign * step.reshape(means.shape)).values()))
            for sign in (1.0, -1.0)
        )
        gradients[:, i] = (up - down) / (2.0 * step[i])
    variances = np.einsum("qi,ij,qj->q", gradients, covariance, gradients)
    return {
        name: Estimate(float(value), float(np.sqrt(max(variance, 0.0))))
        for (name, value), variance in zip(found.items(), variances, strict=True)
    }
