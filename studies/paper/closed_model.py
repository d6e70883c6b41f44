"""Model of a rock from a study: mean closures of its cases, and numbers that claims need."""

from collections.abc import Callable, Hashable, Mapping
from typing import TypeVar

import numpy as np

from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.standard_errors import Estimate
from studies.paper.claims.findings import TARGET
from studies.paper.responses import RockSample

SQUARE = "squared deviation"
"""Target whose mean is the variance of the maximum closure, ddof 1 [m2]."""

Means = np.ndarray
"""Means (targets, cases) of a `RockSample`."""
Name = TypeVar("Name", bound=Hashable)


class ClosedModel:
    """Mean closures of all cases of a rock, as `studies.paper.claims.statements.Closed`.

    ``critical`` is t sqrt(2/n) of a study's test: the smallest significant change of a mean in
    standard deviations of a closure.
    """

    def __init__(self, sample: RockSample, means: Means, critical: float) -> None:
        self.sample = sample
        self.means = means
        self.critical = critical
        self._fits: dict[tuple[str, int, str], Quadratic] = {}

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> float:
        """Return d ln(closure)/d ln(parameter) at the rock's value, from Eq. (24)."""
        return self._fit(parameter, cycle, variable).elasticity()

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[float]:
        """Return the elasticities between neighbouring levels, about their middle."""
        levels, target = self.sample.levels[parameter], self.sample.target(variable, cycle)
        means = self.means[target, levels.cases]
        return [
            float((after - before) / (after + before) * (upper + lower) / (upper - lower))
            for before, after, lower, upper in zip(
                means, means[1:], levels.values, levels.values[1:], strict=False
            )
        ]

    def change(self, parameter: str, cycle: int, change: float) -> float:
        """Return the relative change of the mean closure with a change of the parameter [SI]."""
        return float(self._fit(parameter, cycle, TARGET).relative_change(change))

    def share(self, variable: str, cycle: int) -> float:
        """Return the mean of a variable over the mean closure of the base case."""
        return float(self._at_base(variable, cycle) / self._at_base(TARGET, cycle))

    def significant(self, cycle: int) -> float:
        """Return the relative change of a mean that is significant with the scatter of the rock."""
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
    """Return numbers that depend on means, with their standard errors.

    The errors are to first order in the errors of the means, whose covariance is that over
    surfaces: contributions of a surface equal at all levels cancel in differences.
    """
    targets, cases, n = sample.values.shape
    means = sample.values.mean(axis=2)
    covariance = np.atleast_2d(np.cov(sample.values.reshape(targets * cases, n))) / n
    if not sample.paired:
        same_case = np.tile(np.eye(cases, dtype=bool), (targets, targets))
        covariance = np.where(same_case, covariance, 0.0)
    errors = np.sqrt(np.diag(covariance))
    values_by_name = numbers(means)
    gradients = np.zeros((len(values_by_name), errors.size))
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
        for (name, value), variance in zip(values_by_name.items(), variances, strict=True)
    }
