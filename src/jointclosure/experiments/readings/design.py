"""Readings of the paper, and the rounds in which they are closed.

A reading is a set of keys that are merged over those of the study. It belongs to an aspect, such as
the Hurst exponent or the maximum stress. Readings of different aspects make pairs. The first round
closes all readings, later ones those that are not yet clearly worse than the best.
"""

import itertools
import json
from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from jointclosure.config.configuration import (
    Configured,
    checked_with,
    merged,
    problem_lines,
    refuse,
)
from jointclosure.config.keys.readings import ReadingsKeys
from jointclosure.config.typed import StudyRock
from jointclosure.inputs import InputError

AS_CONFIGURED = "as_configured"
"""The reading in which no aspect is changed."""
CLOSURES = {
    "max_closure": "closure",
    "max_closure_seated": "closure_seated",
    "max_closure_net": "closure_net",
}
"""Quantities of `jointclosure.ensemble.quantities.QUANTITIES` by key of the closure."""
SINGLES, PAIRS, KEPT = "singles", "pairs", "kept"


class Reading(NamedTuple):
    """A reading of the paper.

    ``keys`` are merged over those of the study; ``closure`` is one of `CLOSURES`; ``allowed``:
    whether the paper's text allows the reading. ``run`` is the reading whose joints it uses:
    itself, or an earlier one with the same keys.
    """

    name: str
    title: str
    aspects: tuple[str, ...]
    keys: dict
    closure: str
    allowed: bool
    run: str


class Round(NamedTuple):
    """Round of readings, with the rocks and the number of surfaces that it closes.

    ``candidates``: "singles" (all readings of the design), "kept" (those kept by the round before)
    or "pairs" (these, and all their pairs). At most ``most`` of those kept enter.
    A reading is kept unless it is behind the best by more than ``margin`` standard errors.
    """

    name: str
    candidates: str
    rocks: tuple[str, ...]
    realizations: int
    most: int
    margin: float


class Readings(NamedTuple):
    """Readings by name, their pairs, and rounds.

    ``block`` is the number of realisations of a job; ``reference_realizations`` that of the
    configured reading, in all ``rocks``, from the first round on.
    """

    singles: dict[str, Reading]
    pairs: dict[str, Reading]
    rounds: tuple[Round, ...]
    rocks: tuple[str, ...]
    block: int
    reference_realizations: int

    def reading(self, name: str) -> Reading:
        """Return a reading or a pair by its name."""
        return self.singles.get(name) or self.pairs[name]

    def all(self) -> list[Reading]:
        """Return all readings and pairs."""
        return [*self.singles.values(), *self.pairs.values()]

    def blocks(self, realizations: int) -> list[range]:
        """Split a number of realisations into the blocks of jobs."""
        return [range(i, i + self.block) for i in range(0, realizations, self.block)]

    def realizations_of(self, reading: str, number: int, rock: str) -> int:
        """Return the number of realisations of a reading and rock in a round."""
        count = self.rounds[number].realizations if rock in self.rounds[number].rocks else 0
        return max(count, self.reference_realizations) if reading == AS_CONFIGURED else count


def readings_of(keys: dict) -> Readings:
    """Return the readings and rounds of a configuration's ``readings`` section.

    Parameters
    ----------
    keys : dict
        Keys of a checked configuration, see `jointclosure.config.configuration.Configured`.

    Raises
    ------
    ConfigurationError
        If a round cannot be run; names all such rounds.
    """
    section = ReadingsKeys.model_validate(keys["readings"]).model_dump()
    rocks = tuple(keys["study"]["rocks"])
    singles = _singles(section["aspects"])
    readings = Readings(
        singles=singles,
        pairs=_pairs(singles),
        rounds=tuple(
            Round(**one | {"rocks": tuple(one["rocks"] or rocks)}) for one in section["rounds"]
        ),
        rocks=rocks,
        block=keys["study"]["realizations_per_job"] or keys["study"]["realizations"],
        reference_realizations=section["reference_realizations"],
    )
    refuse(_round_problems(readings))
    if keys["study"]["cycles"] != 2:
        refuse([f"study.cycles = {keys['study']['cycles']}: must be 2, as in Table 3"])
    return readings


def check_readings(configured: Configured) -> None:
    """Raise `ConfigurationError` if the model refuses readings; names all of them."""
    refuse(_reading_problems(readings_of(configured.keys), configured.keys))


def can_be_run(readings: Readings, keys: dict, reading: str) -> bool:
    """Return whether the model accepts a reading; some pairs contradict themselves."""
    try:
        checked_with(keys, readings.reading(reading).keys)
    except InputError:
        return False
    return True


def entering(readings: Readings, keys: dict, number: int, judged: pd.DataFrame | None) -> list[str]:
    """Return the readings that enter a round, the configured one first.

    Parameters
    ----------
    readings : Readings
    keys : dict
        As for `readings_of`.
    number : int
        Number of the round, from 0.
    judged : DataFrame, optional
        Ranking of the round before, best first: columns reading, kept.

    Returns
    -------
    list of str
        Empty if no readings are left to compare. Pairs that contradict themselves are left out.
    """
    this = readings.rounds[number]
    if this.candidates == SINGLES:
        return list(readings.singles)
    if judged is None or judged.empty:
        return []
    kept = judged.reading[judged.kept].tolist()[: this.most]
    before = readings.rounds[number - 1]
    if this.candidates == KEPT and this.rocks == before.rocks and len(kept) < 2:
        return []
    answer = list(dict.fromkeys([AS_CONFIGURED, *kept]))
    if this.candidates == PAIRS:
        order = list(readings.singles).index
        pairs = (pair_name(*sorted(names, key=order)) for names in itertools.combinations(kept, 2))
        possible = (name for name in pairs if name in readings.pairs)
        answer += [name for name in possible if can_be_run(readings, keys, name)]
    return answer


def pair_name(one: str, other: str) -> str:
    """Return the name of a pair of readings, which is never parsed."""
    return f"{one}-{other}"


def _singles(aspects: dict) -> dict[str, Reading]:
    plain = Reading(AS_CONFIGURED, "as configured", (), {}, "max_closure", True, AS_CONFIGURED)
    singles = {AS_CONFIGURED: plain}
    for aspect, ways in aspects.items():
        for name, way in ways.items():
            reading = Reading(
                name, way["title"], (aspect,), way["set"], way["closure"], way["allowed"], name
            )
            singles[name] = reading._replace(run=_run_of(reading, singles))
    return singles


def _run_of(reading: Reading, singles: dict[str, Reading]) -> str:
    """Return the first reading with the same keys, or the name of the reading."""
    keys = json.dumps(reading.keys, sort_keys=True)
    same = (one.run for one in singles.values() if json.dumps(one.keys, sort_keys=True) == keys)
    return next(same, reading.name)


def _pairs(singles: dict[str, Reading]) -> dict[str, Reading]:
    """Return the pairs of readings of two aspects that do not read two different closures."""
    pairs = {}
    for one, other in itertools.combinations(singles.values(), 2):
        closures = {one.closure, other.closure} - {"max_closure"}
        if not one.aspects or not other.aspects or one.aspects == other.aspects:
            continue
        if len(closures) == 2:
            continue
        name = pair_name(one.name, other.name)
        pair = Reading(
            name,
            f"{one.title}, {other.title}",
            one.aspects + other.aspects,
            merged(one.keys, other.keys),
            closures.pop() if closures else "max_closure",
            one.allowed and other.allowed,
            name,
        )
        pairs[name] = pair._replace(run=_run_of(pair, singles))
    return pairs


def _round_problems(readings: Readings) -> Iterator[str]:
    """Generate contradictions in the rounds."""
    pair_rounds = [one.name for one in readings.rounds if one.candidates == PAIRS]
    for number, one in enumerate(readings.rounds):
        where = f"readings.rounds.{one.name}"
        if one.candidates == PAIRS and one.name != pair_rounds[0]:
            yield f"{where}.candidates = {PAIRS!r}: must be so in one round at most"
        if (one.candidates == SINGLES) != (number == 0):
            yield (
                f"{where}.candidates = {one.candidates!r}: must be {SINGLES} in the first round "
                "and in no other"
            )
        for rock in one.rocks:
            if rock not in readings.rocks:
                yield f"{where}.rocks = {rock!r}: must be one of {', '.join(readings.rocks)}"
        for name, count in (
            (f"{where}.realizations", one.realizations),
            ("readings.reference_realizations", readings.reference_realizations),
        ):
            if count % readings.block:
                yield f"{name} = {count}: must be a multiple of {readings.block}, those of a job"
        if one.realizations > readings.reference_realizations and one.rocks != readings.rocks:
            yield (
                f"{where}.realizations = {one.realizations}: must be at most "
                f"reference_realizations = {readings.reference_realizations}"
            )


def _reading_problems(readings: Readings, keys: dict) -> Iterator[str]:
    """Generate the problems of readings that the model refuses."""
    plain = checked_with(keys)
    for name, reading in readings.singles.items():
        where = f"readings: {name}"
        for section in reading.keys:
            if section not in _SECTIONS:
                yield f"{where}: {section}: must be one of {', '.join(_SECTIONS)}"
        try:
            typed = checked_with(keys, reading.keys, {"study": {"rocks": list(readings.rocks)}})
        except InputError as error:
            yield from (f"{where}: {line}" for line in problem_lines(error))
            continue
        for rock, of_rock in typed.rocks.items():
            if _varied(of_rock) != _varied(plain.rocks[rock]):
                yield f"{where}: rocks.{rock}: a reading may not change properties or levels"


def _varied(rock: StudyRock) -> tuple:
    """Return the fields of a rock that the paper's tables give."""
    return rock.intact, rock.jrc, rock.levels


_SECTIONS = ("effects", "choices", "numerics", "grid", "surface", "rocks", "seating_stress_MPa")
"""Sections that a reading may change."""
