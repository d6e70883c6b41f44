"""Readings of the paper, and the rounds in which they are closed.

A reading is a set of keys that are merged over the study's. It belongs to an aspect, what
it is a reading of: the Hurst exponent, the maximum stress. Readings of different aspects
make pairs. Rounds spend surfaces on them: the first on all, later ones on those that are
not yet clearly worse than the best.
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
"""Quantities of `jointclosure.ensemble.quantities.QUANTITIES` by the closure that is read."""
SINGLES, PAIRS, KEPT = "singles", "pairs", "kept"


class Reading(NamedTuple):
    """A reading of the paper.

    ``keys`` are merged over the study's; ``closure`` is the variable that is read;
    ``allowed`` whether the paper's text allows it. ``run`` names the reading whose closures
    it reads: its own, or one with the same keys.
    """

    name: str
    title: str
    aspects: tuple[str, ...]
    keys: dict
    closure: str
    allowed: bool
    run: str


class Round(NamedTuple):
    """A round: which readings enter, and how many surfaces of which rocks it closes.

    ``candidates``: "singles" (all readings of the design), "kept" (those that the round
    before kept) or "pairs" (these, and all their pairs). At most ``most`` of those kept enter.
    A reading is kept unless it is behind the best by more than ``margin`` standard errors.
    """

    name: str
    candidates: str
    rocks: tuple[str, ...]
    realizations: int
    most: int
    margin: float


class Readings(NamedTuple):
    """Readings by name, the pairs that they make, and rounds.

    ``block`` is the number of realisations that a job closes; ``reference_realizations``
    those of the configured reading, in all ``rocks``, from the first round on.
    """

    singles: dict[str, Reading]
    pairs: dict[str, Reading]
    rounds: tuple[Round, ...]
    rocks: tuple[str, ...]
    block: int
    reference_realizations: int

    def reading(self, name: str) -> Reading:
        """A reading or a pair by its name."""
        return self.singles.get(name) or self.pairs[name]

    def all(self) -> list[Reading]:
        """All readings and pairs."""
        return [*self.singles.values(), *self.pairs.values()]

    def blocks(self, realizations: int) -> list[range]:
        """The blocks of so many realisations."""
        return [range(i, i + self.block) for i in range(0, realizations, self.block)]

    def realizations_of(self, reading: str, number: int, rock: str) -> int:
        """Realisations that a reading in a round has of a rock."""
        own = self.rounds[number].realizations if rock in self.rounds[number].rocks else 0
        return max(own, self.reference_realizations) if reading == AS_CONFIGURED else own


def readings_of(keys: dict) -> Readings:
    """The readings and rounds in a configuration's ``readings`` section.

    Parameters
    ----------
    keys : dict
        Of a configuration that was checked, see `jointclosure.config.configuration.Configured`.

    Raises
    ------
    ConfigurationError
        Naming each round that cannot be run.
    """
    section = ReadingsKeys.model_validate(keys["readings"]).model_dump()
    rocks = tuple(keys["study"]["rocks"])
    singles = _singles(section["aspects"])
    readings = Readings(
        singles=singles,
        pairs=_pairs(singles),
        rounds=tuple(
            Round(**each | {"rocks": tuple(each["rocks"] or rocks)}) for each in section["rounds"]
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
    """Raise `ConfigurationError` for each reading that the model cannot take."""
    refuse(_reading_problems(readings_of(configured.keys), configured.keys))


def can_be_run(readings: Readings, keys: dict, reading: str) -> bool:
    """Whether the model takes a reading; some pairs contradict each other."""
    try:
        checked_with(keys, readings.reading(reading).keys)
    except InputError:
        return False
    return True


def entering(readings: Readings, keys: dict, number: int, judged: pd.DataFrame | None) -> list[str]:
    """Readings that enter a round, the configured one first; pairs only where they can be run.

    Parameters
    ----------
    readings : Readings
    keys : dict
        As for `readings_of`.
    number : int
        Of the round, from 0.
    judged : DataFrame, optional
        Outcome of the round before, best first: columns reading, kept.

    Returns
    -------
    list of str
        Empty where nothing is left to be told apart.
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
        possible = {frozenset(names): pair_name(*names) for names in _pairs_of(readings.singles)}
        chosen = (frozenset(names) for names in itertools.combinations(kept, 2))
        pairs = (possible[names] for names in chosen if names in possible)
        answer += [name for name in pairs if can_be_run(readings, keys, name)]
    return answer


def pair_name(one: str, other: str) -> str:
    """Name of a pair of readings; never taken apart."""
    return f"{one}-{other}"


def _singles(aspects: dict) -> dict[str, Reading]:
    singles = {
        AS_CONFIGURED: Reading(
            AS_CONFIGURED, "as configured", (), {}, "max_closure", True, AS_CONFIGURED
        )
    }
    for aspect, ways in aspects.items():
        for name, way in ways.items():
            reading = Reading(
                name, way["title"], (aspect,), way["set"], way["closure"], way["allowed"], name
            )
            singles[name] = reading._replace(run=_run_of(reading, singles))
    return singles


def _run_of(reading: Reading, singles: dict[str, Reading]) -> str:
    """The first reading that has the same keys, or its own."""
    own = json.dumps(reading.keys, sort_keys=True)
    same = (each.run for each in singles.values() if json.dumps(each.keys, sort_keys=True) == own)
    return next(same, reading.name)


def _pairs_of(singles: dict[str, Reading]) -> Iterator[tuple[str, str]]:
    """Names of readings of two aspects."""
    for one, other in itertools.combinations(singles.values(), 2):
        closures = {one.closure, other.closure} - {"max_closure"}
        if one.aspects and other.aspects and one.aspects != other.aspects and len(closures) < 2:
            yield one.name, other.name


def _pairs(singles: dict[str, Reading]) -> dict[str, Reading]:
    pairs = {}
    for names in _pairs_of(singles):
        one, other = (singles[name] for name in names)
        closures = {one.closure, other.closure} - {"max_closure"}
        pair = Reading(
            pair_name(*names),
            f"{one.title}, {other.title}",
            one.aspects + other.aspects,
            merged(one.keys, other.keys),
            closures.pop() if closures else "max_closure",
            one.allowed and other.allowed,
            pair_name(*names),
        )
        pairs[pair.name] = pair._replace(run=_run_of(pair, singles))
    return pairs


def _round_problems(readings: Readings) -> Iterator[str]:
    for number, each in enumerate(readings.rounds):
        where = f"readings.rounds.{each.name}"
        if each.candidates == PAIRS and each is not _first_of_pairs(readings):
            yield f"{where}.candidates = {PAIRS!r}: must be so in one round at most"
        if (each.candidates == SINGLES) != (number == 0):
            yield (
                f"{where}.candidates = {each.candidates!r}: must be {SINGLES} in the first round "
                "and in no other"
            )
        for rock in each.rocks:
            if rock not in readings.rocks:
                yield f"{where}.rocks = {rock!r}: must be one of {', '.join(readings.rocks)}"
        for name, count in (
            (f"{where}.realizations", each.realizations),
            ("readings.reference_realizations", readings.reference_realizations),
        ):
            if count % readings.block:
                yield f"{name} = {count}: must be a multiple of {readings.block}, those of a job"
        if each.realizations > readings.reference_realizations and each.rocks != readings.rocks:
            yield (
                f"{where}.realizations = {each.realizations}: must be at most "
                f"reference_realizations = {readings.reference_realizations}"
            )


def _first_of_pairs(readings: Readings) -> Round | None:
    return next((each for each in readings.rounds if each.candidates == PAIRS), None)


def _reading_problems(readings: Readings, keys: dict) -> Iterator[str]:
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
        for rock, own in typed.rocks.items():
            if _varied(own) != _varied(plain.rocks[rock]):
                yield f"{where}: rocks.{rock}: a reading may not change properties or levels"


def _varied(rock: StudyRock) -> tuple:
    """What the paper's tables say of a rock."""
    return rock.intact, rock.jrc, rock.levels


_SECTIONS = ("effects", "choices", "numerics", "grid", "surface", "rocks", "seating_stress_MPa")
"""Sections that a reading may change."""
