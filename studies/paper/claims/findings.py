"""Results of many studies at once, judged as in the paper by point estimates.

Studies are those of `jointclosure.statistics.drawn_studies.draw_studies`: lengths and means of R
repetitions. A real study is a study with R = 1, judged by the same rules.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.drawn_studies import DrawnResponse

TARGET, NET = "max_closure", "max_closure_net"
"""Names of the maximum closure, and of the maximum closure net of bulk indentation."""
LOOP = "loop"
"""Name of the loop: closure of unloading less that of loading, at half the maximum stress."""
EXCESS = "excess"
"""Name of the excess at low stress: closure of loading to half the maximum stress, since the start
of the cycle, less half of the maximum closure."""


class Findings(NamedTuple):
    """Studies (R) of some rocks: responses by (rock, parameter), and names of the targets."""

    drawn: dict[tuple[str, str], DrawnResponse]
    names: tuple[tuple[str, int], ...]

    def rocks(self) -> list[str]:
        """Return the names of the rocks, in order."""
        return list(dict.fromkeys(rock for rock, _ in self.drawn))

    def parameters(self, rock: str) -> list[str]:
        """Return the parameters of a rock that are varied."""
        return [parameter for name, parameter in self.drawn if name == rock]

    def percents(self, rock: str, cycle: int, variable: str = TARGET) -> dict[str, np.ndarray]:
        """Return lengths (R,) in percent of the rock's value, by parameter; infinite if no root."""
        target = self.names.index((variable, cycle))
        return {
            parameter: 100.0 * response.lengths[:, target] / abs(response.base)
            for parameter in self.parameters(rock)
            if (response := self.drawn[rock, parameter]).base != 0.0
        }

    def lengths(self, rock: str, parameter: str, cycle: int, variable: str = TARGET) -> np.ndarray:
        """Return lengths (R,) [SI]."""
        return self.drawn[rock, parameter].lengths[:, self.names.index((variable, cycle))]

    def means(self, rock: str, parameter: str, variable: str, cycle: int) -> np.ndarray:
        """Return means (R, levels)."""
        return self.drawn[rock, parameter].means[:, self.names.index((variable, cycle))]

    def base_means(self, rock: str, variable: str, cycle: int) -> np.ndarray:
        """Return means (R,) of the base case of the rock."""
        parameter = self.parameters(rock)[0]
        response = self.drawn[rock, parameter]
        at_base = int(np.flatnonzero(response.levels == response.base)[0])
        return self.means(rock, parameter, variable, cycle)[:, at_base]


def widest(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Return whether no other interval is longer, and some are finite."""
    every = np.array(list(percents.values()))
    return (percents[parameter] >= every.max(axis=0)) & np.isfinite(every).any(axis=0)


def in_place(percents: dict[str, np.ndarray], parameter: str, place: int) -> np.ndarray:
    """Return whether ``place`` other intervals are shorter, and this one is finite."""
    every = np.array(list(percents.values()))
    shorter = (every < percents[parameter]).sum(axis=0)
    return (shorter == place) & np.isfinite(percents[parameter])


def monotone(means: np.ndarray, sign: int) -> np.ndarray:
    """Return whether means (R, levels) rise (sign 1) or fall (-1) at every step of the levels."""
    return np.all(sign * np.diff(means, axis=1) > 0.0, axis=1)
