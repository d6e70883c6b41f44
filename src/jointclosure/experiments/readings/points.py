"""Points of a study of readings: all cases of a rock in a reading, by blocks of surfaces."""

from collections.abc import Callable, Iterable, Sequence

from jointclosure.config.configuration import Configured, complete, with_keys
from jointclosure.config.typed import Configuration
from jointclosure.ensemble.cases import base_case, cases_of
from jointclosure.ensemble.points import Jobs, Point, Sample
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import block_settings
from jointclosure.experiments.readings.design import (
    AS_CONFIGURED,
    PAIRS,
    SINGLES,
    Readings,
    can_be_run,
)
from jointclosure.joint.warmup import kernels_of


def job_name(run: str, rock: str, block: range) -> str:
    """Return the name of the job that closes a block of a rock; it is never parsed."""
    return f"{run}.{rock}.{block.start}"


def points_of_jobs(
    readings: Readings, configured: Configured
) -> tuple[dict[str, tuple[str, str, range]], Callable[[str, str, range], list[Point]]]:
    """Return all jobs of the rounds, as run, rock and block, and the maker of their points."""
    most = max(readings.reference_realizations, *(one.realizations for one in readings.rounds))
    runs = dict.fromkeys(one.run for one in readings.all())
    jobs = {
        job_name(run, rock, block): (run, rock, block)
        for run in runs
        for rock in readings.rocks
        for block in readings.blocks(most)
    }
    typed_in = _configurations(readings, configured)

    def points_of(run: str, rock: str, block: range) -> list[Point]:
        typed = typed_in(run, rock)
        cases = {case.label: case for case in cases_of(typed)}
        return [
            Point(
                {"run": run, "rock": rock, "parameter": case.parameter, "value": case.value},
                block_settings(typed, cases, label, block),
            )
            for label, case in cases.items()
        ]

    return jobs, points_of


def _configurations(
    readings: Readings, configured: Configured
) -> Callable[[str, str], Configuration]:
    """Return a maker of the unchecked configuration of a single rock in a reading."""
    keys = complete(configured.keys)

    def typed_in(reading: str, rock: str) -> Configuration:
        alone = {"study": {"rocks": [rock]}}
        return with_keys(configured.typed, keys, alone | readings.reading(reading).keys)

    return typed_in


def jobs_of_round(readings: Readings, number: int, entrants: Sequence[str]) -> list[str]:
    """Return the jobs that the entrants of a round and the configured reading need."""
    names = dict.fromkeys([AS_CONFIGURED, *entrants] if entrants else [])
    jobs = (
        job_name(readings.reading(name).run, rock, block)
        for name in names
        for rock in readings.rocks
        for block in readings.blocks(readings.realizations_of(name, number, rock))
    )
    return list(dict.fromkeys(jobs))


def settings_of_kernels(readings: Readings, configured: Configured) -> Iterable[ClosureSettings]:
    """Return settings of all kernels of the readings, and of the pairs that can be closed."""
    typed_in, settings_of = _configurations(readings, configured), {}
    for one in readings.all():
        for rock in readings.rocks:
            typed = typed_in(one.run, rock)
            case = base_case(rock, typed.rocks[rock])
            settings = block_settings(typed, {case.label: case}, case.label, range(1))
            kernel = str(kernels_of([(case.effects, settings.choices, settings.numerics)]))
            if kernel not in settings_of and can_be_run(readings, configured.keys, one.name):
                settings_of[kernel] = settings
    return settings_of.values()


def samples(readings: Readings, jobs: Jobs) -> dict[str, list[Sample]]:
    """Sample the joints of each round, if the largest possible number of readings enters.

    Surfaces closed in an earlier round are not counted again. For rounds after the first one the
    time of a joint is taken as that of the mean reading in the rocks of the first round, and of the
    configured one in the others.
    """
    first = readings.blocks(readings.block)[0]
    runs = [name for name, one in readings.singles.items() if one.run == name]
    cases = len(jobs[job_name(AS_CONFIGURED, readings.rocks[0], first)])

    def point(run: str, rock: str) -> Point:
        return jobs[job_name(run, rock, first)][0]

    parts = {
        "as configured": [
            Sample([point(AS_CONFIGURED, rock)], cases * readings.reference_realizations)
            for rock in readings.rocks
        ]
    }
    closed = dict.fromkeys(readings.rocks, 0)
    for this in readings.rounds:
        parts[this.name] = []
        for rock in this.rocks:
            new = this.realizations - (0 if this.candidates == PAIRS else closed[rock])
            joints = cases * max(new, 0)
            if this.candidates == SINGLES:
                parts[this.name] += [
                    Sample([point(run, rock)], joints) for run in runs if run != AS_CONFIGURED
                ]
            else:
                kept = min(this.most, len(readings.singles) - 1)
                count = kept * (kept - 1) // 2 if this.candidates == PAIRS else kept
                tried = runs if rock in readings.rounds[0].rocks else [AS_CONFIGURED]
                parts[this.name].append(Sample([point(run, rock) for run in tried], count * joints))
            closed[rock] = max(closed[rock], this.realizations)
    return parts
