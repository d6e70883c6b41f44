"""Inputs that vary together, the points at which joints are closed, and their settings."""

import itertools
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from jointclosure.config.configuration import (
    Configured,
    checked_with,
    complete,
    overlaid,
    problem_lines,
    refuse,
    with_keys,
)
from jointclosure.config.keys.global_sensitivity import GlobalSensitivityKeys
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import block_settings
from jointclosure.inputs import InputError
from jointclosure.parameters import PROPERTIES, key_of
from jointclosure.statistics.orthonormal import part_of
from jointclosure.statistics.randomness import seed_of
from jointclosure.statistics.variance_indices import sampled_rows

ROCK = "ROCK"
"""Stands in an input's key for the rock that is closed."""
VARIED = ("rocks", "surface", "effects", "choices", "numerics")
"""Sections of a configuration whose keys can vary: others change which surfaces there are."""
SURFACES = 2
"""Surface pairs that all points of a row are closed on."""


class Input(NamedTuple):
    """A key that varies: between two numbers, or over a few values.

    ``key`` is its path in a configuration. ``low`` and ``high`` are None where it has
    ``values``, or where its range are the levels of Table 2, of each rock its own.
    """

    name: str
    title: str
    key: tuple[str, ...]
    low: float | None
    high: float | None
    logarithmic: bool
    values: list

    @property
    def property(self) -> str | None:
        """The property of a rock that it is, if any."""
        keys = {f"rocks.{ROCK}.{key_of(name)}": name for name in PROPERTIES}
        return keys.get(".".join(self.key))


class Sampling(NamedTuple):
    """Inputs, the number of rows, and how many of these a job closes.

    ``dependent`` are pairs of inputs by name, with their correlation.
    """

    inputs: tuple[Input, ...]
    rows: int
    rows_per_job: int
    rocks: tuple[str, ...]
    seed: int
    dependent: list[tuple[str, str, float]]

    @property
    def values(self) -> tuple[int, ...]:
        """How many values each input has; 0: it varies continuously."""
        return tuple(len(each.values) for each in self.inputs)

    @property
    def correlations(self) -> dict[tuple[int, int], float]:
        """Of pairs of inputs, by their places."""
        place = {each.name: number for number, each in enumerate(self.inputs)}
        return {(place[one], place[other]): value for one, other, value in self.dependent}

    def points(self) -> np.ndarray:
        """Points (rows, inputs + 2, inputs) of the unit cube, the same in all rocks.

        Those of a row are the same whatever the number of rows.
        """
        return _points(len(self.inputs), self.rows, self.seed)

    def blocks(self) -> list[range]:
        """The rows of each job."""
        step = self.rows_per_job
        return [range(i, min(i + step, self.rows)) for i in range(0, self.rows, step)]


_points = lru_cache(maxsize=None)(sampled_rows)


def sampling_of(keys: dict) -> Sampling:
    """The inputs and rows of a configuration's ``global_sensitivity`` section.

    Raises
    ------
    ConfigurationError
        Inputs or rows that contradict each other.
    """
    section = GlobalSensitivityKeys.model_validate(keys["global_sensitivity"]).model_dump()
    sampling = Sampling(
        inputs=tuple(_inputs(section["inputs"])),
        rows=section["rows"],
        rows_per_job=section["rows_per_job"],
        rocks=tuple(keys["study"]["rocks"]),
        seed=seed_of(keys["study"]["root_seed"], "global sensitivity"),
        dependent=[(*each["inputs"], each["correlation"]) for each in section["dependent"]],
    )
    refuse(_problems(sampling, section))
    return sampling


def check_sampling(configured: Configured) -> None:
    """Raise `ConfigurationError` for each input that the model cannot take at an end of its range.

    First each input alone, all else as the study has it, so that what is wrong is the input's own;
    then with all others in the middle.
    """
    sampling, keys = sampling_of(configured.keys), configured.keys
    refuse(_unusable(sampling, keys))
    refuse(_clashing(sampling, keys))


def keys_at(sampling: Sampling, keys: dict, rock: str, point) -> dict:
    """The keys that a point (d,) of the unit cube sets, to be put over those of the study."""
    answer: dict = {}
    for each, u in zip(sampling.inputs, point, strict=True):
        *path, last = (rock if part == ROCK else part for part in each.key)
        within = answer
        for part in path:
            within = within.setdefault(part, {})
        within[last] = value_at(each, keys, rock, float(u))
    return answer


def value_at(each: Input, keys: Mapping, rock: str, u: float):
    """The value of an input at u of [0, 1], in the unit of its key."""
    if each.values:
        return each.values[int(part_of(u, len(each.values)))]
    low, high = range_of(each, keys, rock)
    if each.logarithmic:
        return float(low * (high / low) ** u)
    return float(low + (high - low) * u)


def range_of(each: Input, keys: Mapping, rock: str) -> tuple[float, float]:
    """Ends of an input that varies continuously, in the unit of its key."""
    if each.low is not None and each.high is not None:
        return each.low, each.high
    levels = keys["rocks"][rock]["levels"][each.key[-1]]
    own = keys["rocks"][rock][each.key[-1]]
    return float(min(*levels, own)), float(max(*levels, own))


def _alone(rock: str) -> dict:
    """Keys of a study of one rock without levels, whose surfaces are the same at all points."""
    return {
        "study": {"rocks": [rock], "draws": "common"},
        "rocks": {rock: {"levels": dict.fromkeys(map(key_of, PROPERTIES))}},
    }


def settings_of_rock(
    sampling: Sampling, configured: Configured, rock: str
) -> Callable[[int, np.ndarray], ClosureSettings]:
    """Settings of the base case of a rock, from a row and a point (d,) on its surfaces.

    They are those of the configuration with other fields, which are not checked.
    """
    alone = _alone(rock)
    keys = complete(configured.keys)
    plain = overlaid(keys, alone)
    base = with_keys(configured.typed, keys, alone)

    def settings(row: int, point: np.ndarray) -> ClosureSettings:
        typed = with_keys(base, plain, keys_at(sampling, keys, rock, point))
        case = base_case(rock, typed.rocks[rock])
        block = range(SURFACES * row, SURFACES * (row + 1))
        return block_settings(typed, {case.label: case}, case.label, block)

    return settings


def settings_of_choices(
    sampling: Sampling, settings: Callable[[int, np.ndarray], ClosureSettings]
) -> list[ClosureSettings]:
    """Settings at all combinations of values of the inputs that have a few, others in the middle.

    Of the inputs that make walls none has another kernel, and one value stands for all.
    """
    places = [
        [0.5]
        if each.key[0] == "surface"
        else [(place + 0.5) / len(each.values) for place in range(len(each.values))] or [0.5]
        for each in sampling.inputs
    ]
    return [settings(0, np.array(point)) for point in itertools.product(*places)]


def is_positive(each: Input, keys: Mapping, rock: str) -> bool:
    """Whether an input varies continuously over positive numbers: it has elasticities."""
    return not each.values and range_of(each, keys, rock)[0] > 0.0


def _inputs(section: dict) -> Iterator[Input]:
    for name, each in section.items():
        between = each["between"]
        low, high = (None, None) if between in (None, "levels") else between
        values = each["values"] or []
        key = tuple(each["key"].split("."))
        yield Input(name, each["title"], key, low, high, each["logarithmic"], values)


def _problems(sampling: Sampling, section: dict) -> Iterator[str]:
    where = "global_sensitivity"
    for each in sampling.inputs:
        own = section["inputs"][each.name]
        if (own["between"] is None) == (not own["values"]):
            yield f"{where}.inputs.{each.name}: must have either between or values"
        if len(own["values"] or [0, 1]) < 2:
            yield f"{where}.inputs.{each.name}.values = {own['values']}: must be two or more"
        if each.key[0] not in VARIED:
            allowed = ", ".join(VARIED)
            yield f"{where}.inputs.{each.name}.key = {own['key']}: must begin with {allowed}"
        if each.logarithmic and each.low is not None and not each.low > 0.0:
            yield f"{where}.inputs.{each.name}.between = {own['between']}: must be positive"
        if each.low is not None and each.high is not None and not each.low < each.high:
            yield f"{where}.inputs.{each.name}.between = {own['between']}: must ascend"
        if own["between"] == "levels" and each.property is None:
            yield f"{where}.inputs.{each.name}.between = levels: {own['key']} has none"
    names = [each.name for each in sampling.inputs]
    for one, other, _ in sampling.dependent:
        for name in (one, other):
            if name not in names:
                yield f"{where}.dependent = {name!r}: must be one of {', '.join(names)}"
    if sampling.rows % 2 or sampling.rows & (sampling.rows - 1):
        yield f"{where}.rows = {sampling.rows}: must be a power of 2"


def _unusable(sampling: Sampling, keys: dict) -> Iterator[str]:
    """What the model says of the ends and values of each input, all else as the study has it."""
    for rock in sampling.rocks:
        for each in sampling.inputs:
            alone = sampling._replace(inputs=(each,), dependent=[])
            for u in _ends(each):
                yield from _refused(alone, keys, rock, np.array([u]), each)


def _clashing(sampling: Sampling, keys: dict) -> Iterator[str]:
    """What the model says of the ends of each input, all others in the middle."""
    middle = np.full(len(sampling.inputs), 0.5)
    for rock in sampling.rocks:
        for number, each in enumerate(sampling.inputs):
            for u in _ends(each):
                point = middle.copy()
                point[number] = u
                yield from _refused(sampling, keys, rock, point, each)


def _ends(each: Input) -> list[float]:
    """Where an input has each of its values, or the ends of its range."""
    count = len(each.values)
    return [(place + 0.5) / count for place in range(count)] or [0.0, 1.0]


def _refused(sampling: Sampling, keys: dict, rock: str, point, each: Input) -> Iterator[str]:
    try:
        checked_with(keys, keys_at(sampling, keys, rock, point), _alone(rock))
    except InputError as error:
        yield f"global_sensitivity.inputs.{each.name}: {'; '.join(problem_lines(error))}"
    except KeyError as error:
        yield f"global_sensitivity.inputs.{each.name}: {error}: there is no such key"
