"""What a study finds, judged as the paper judges: by point estimates, in many studies at once.

A study is what `jointclosure.statistics.drawn_studies.draw_studies` gives: lengths and means of
R repetitions. One that was made is a study with R = 1, judged by the same rules.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.drawn_studies import DrawnResponse
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.studies.sensitivity.responses import TARGET, RockSample


class Findings(NamedTuple):
    """Studies (R) of some rocks: responses by (rock, parameter), and the targets' names."""

    drawn: dict[tuple[str, str], DrawnResponse]
    names: tuple[tuple[str, int], ...]

    def parameters(self, rock: str) -> list[str]:
        """Those of a rock that are varied."""
        return [parameter for name, parameter in self.drawn if name == rock]

    def percents(self, rock: str, cycle: int, variable: str = TARGET) -> dict[str, np.ndarray]:
        """Lengths (R,) in percent of the rock's own value by parameter; infinite for no root."""
        target = self.names.index((variable, cycle))
        return {
            parameter: 100.0 * response.lengths[:, target] / abs(response.base)
            for parameter in self.parameters(rock)
            if (response := self.drawn[rock, parameter]).base != 0.0
        }

    def lengths(self, rock: str, parameter: str, cycle: int) -> np.ndarray:
        """Lengths (R,) [SI]."""
        return self.drawn[rock, parameter].lengths[:, self.names.index((TARGET, cycle))]

    def means(self, rock: str, parameter: str, variable: str, cycle: int) -> np.ndarray:
        """Means (R, levels)."""
        return self.drawn[rock, parameter].means[:, self.names.index((variable, cycle))]

    def base_means(self, rock: str, variable: str, cycle: int) -> np.ndarray:
        """Means (R,) of the rock as it is."""
        parameter = self.parameters(rock)[0]
        response = self.drawn[rock, parameter]
        at_base = int(np.flatnonzero(response.levels == response.base)[0])
        return self.means(rock, parameter, variable, cycle)[:, at_base]


def as_found(samples: list[RockSample], significance: float) -> Findings:
    """A study that was made, as one of many: its own means, and lengths as published."""
    drawn = {}
    for sample in samples:
        for parameter, levels in sample.levels.items():
            values = sample.values[:, levels.cases]
            means, deviations = values.mean(axis=2), values.std(axis=2, ddof=1)
            lengths = indifference_lengths(
                levels.values, means, deviations, values.shape[2], significance, levels.base
            )
            drawn[sample.rock, parameter] = DrawnResponse(
                levels.values,
                levels.base,
                means[None],
                deviations[None],
                np.where(np.isnan(lengths), np.inf, lengths)[None],
            )
    return Findings(drawn, samples[0].names if samples else ())


def widest(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Whether no other interval is longer, and some are finite."""
    every = np.array(list(percents.values()))
    return (percents[parameter] >= every.max(axis=0)) & np.isfinite(every).any(axis=0)


def shortest(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Whether no other interval is shorter, and it is finite."""
    every = np.array(list(percents.values()))
    return (percents[parameter] <= every.min(axis=0)) & np.isfinite(percents[parameter])


def second(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Whether exactly one other interval is shorter, and it is finite."""
    every = np.array(list(percents.values()))
    return ((every < percents[parameter]).sum(axis=0) == 1) & np.isfinite(percents[parameter])


def monotone(means: np.ndarray, sign: int) -> np.ndarray:
    """Whether means (R, levels) rise (sign 1) or fall (-1) from every level to the next."""
    return np.all(sign * np.diff(means, axis=1) > 0.0, axis=1)
