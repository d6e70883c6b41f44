"""Inputs that vary together, the points of the sampling, and the settings of their joints."""

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.parameters import PROPERTIES, key_of
from jointclosure.statistics.randomness import seed_of
from jointclosure.statistics.variance_indices import level_of, sampled_rows
from studies.frame.cases import base_case, block_settings
from studies.frame.configuration import Configuration, configured, read_stored
from studies.frame.settings import ClosureSettings
from studies.frame.yaml_files import merged, overlaid, refuse
from studies.global_sensitivity.section import ROCK, GlobalSensitivitySection, Input

SURFACES = 2
"""Number of surface pairs of a row, the same for all its points."""


class Sampling(NamedTuple):
    """Sampling of a study: its section, the stated keys of its rocks by name, the seed of rows."""

    section: GlobalSensitivitySection
    rocks: dict[str, dict]
    seed: int

    @property
    def inputs(self) -> dict[str, Input]:
        """Return the inputs by name."""
        return self.section.inputs

    @property
    def values(self) -> tuple[int, ...]:
        """Return the number of values of each input; 0: it varies continuously."""
        return tuple(len(one.values or ()) for one in self.inputs.values())

    @property
    def correlations(self) -> dict[tuple[int, int], float]:
        """Return the correlations of pairs of inputs, by their places."""
        place = {name: number for number, name in enumerate(self.inputs)}
        return {
            (place[one], place[other]): pair.correlation
            for pair in self.section.dependent
            for one, other in [pair.inputs]
        }

    def points(self) -> np.ndarray:
        """Return points (rows, inputs + 2, inputs) of the unit cube; added rows change none."""
        return _points(len(self.inputs), self.section.rows, self.seed)

    def blocks(self) -> list[range]:
        """Return the rows of each job."""
        rows = self.section.rows
        step = self.section.rows_per_job
        return [range(i, min(i + step, rows)) for i in range(0, rows, step)]


_points = lru_cache(maxsize=None)(sampled_rows)


def sampling_of(study: Configuration) -> Sampling:
    """Return the sampling of a configuration; raise `InputError` without its section."""
    rocks = {rock: study.stated["rocks"][rock] for rock in study.rocks}
    seed = seed_of(study.study.root_seed, "global sensitivity")
    return Sampling(study.section(GlobalSensitivitySection), rocks, seed)


def check_sampling(study: Configuration) -> None:
    """Raise `ConfigurationError` if the configuration is refused at an end or value of an input.

    Each input is first changed alone, then with the other inputs in the middle of their ranges.
    """
    sampling = sampling_of(study)
    keys = study.stated
    refuse(_refused(sampling, keys, together=False))
    refuse(_refused(sampling, keys, together=True))


def keys_at(sampling: Sampling, rock: str, point, only: Collection[str] = ()) -> dict:
    """Return the nested keys of a study of one rock at a point (d,) of the unit cube.

    They are to be merged over the study's keys. If ``only`` is not empty, it has the names of the
    inputs whose keys are returned.
    """
    answer: dict = {}
    for (name, one), u in zip(sampling.inputs.items(), point, strict=True):
        if only and name not in only:
            continue
        *path, last = (rock if part == ROCK else part for part in one.parts)
        within = answer
        for part in path:
            within = within.setdefault(part, {})
        within[last] = value_at(one, sampling.rocks[rock], float(u))
    return answer


def value_at(one: Input, rock: Mapping, u: float):
    """Return the value of an input at u in [0, 1], in the unit of its key, for keys of a rock."""
    if one.values:
        return one.values[int(level_of(u, len(one.values)))]
    low, high = range_of(one, rock)
    return float(low * (high / low) ** u if one.logarithmic else low + (high - low) * u)


def range_of(one: Input, rock: Mapping) -> tuple[float, float]:
    """Return the ends of the range of a continuous input in the unit of its key."""
    if isinstance(one.between, tuple):
        low, high = one.between
        return low, high
    base, levels = (of[one.parts[-1]] for of in (rock, rock["levels"]))
    return float(min(*levels, base)), float(max(*levels, base))


def _alone(rock: str) -> dict:
    """Return the keys that reduce a study to one rock without levels, on common surfaces."""
    return {
        "study": {"rocks": [rock], "draws": "common"},
        "rocks": {rock: {"levels": dict.fromkeys(map(key_of, PROPERTIES))}},
    }


def settings_of_rock(
    sampling: Sampling, study: Configuration, rock: str
) -> Callable[[int, np.ndarray], ClosureSettings]:
    """Return a function of a row and a point (d,) that gives the settings of a rock's joints."""
    alone = _alone(rock)
    keys = study.stated
    plain = overlaid(keys, alone) | {
        "rocks": {rock: overlaid(keys["rocks"][rock], alone["rocks"][rock])}
    }

    def settings(row: int, point: np.ndarray) -> ClosureSettings:
        typed = read_stored(overlaid(plain, keys_at(sampling, rock, point)))
        block = range(SURFACES * row, SURFACES * (row + 1))
        case = base_case(typed, rock)
        return block_settings(typed, case, block)

    return settings


def is_positive(one: Input, rock: Mapping) -> bool:
    """Return whether an input varies over positive numbers, which an elasticity needs."""
    return not one.values and range_of(one, rock)[0] > 0.0


def _refused(sampling: Sampling, keys: dict, together: bool) -> Iterator[str]:
    """Generate errors at the ends or values of each input, alone or with the others."""
    for rock, (place, name) in itertools.product(sampling.rocks, enumerate(sampling.inputs)):
        where = f"global_sensitivity.inputs.{name}"
        count = sampling.values[place]
        for u in [(value + 0.5) / count for value in range(count)] or [0.0, 1.0]:
            point = np.full(len(sampling.inputs), 0.5)
            point[place] = u
            try:
                changed = keys_at(sampling, rock, point, () if together else {name})
                configured(merged(keys, changed, _alone(rock)))
            except InputError as error:
                lines = str(error).removeprefix("configuration:\n").splitlines()
                yield f"{where}: {'; '.join(map(str.strip, lines))}"
            except KeyError as error:
                yield f"{where}: {error}: there is no such key"
