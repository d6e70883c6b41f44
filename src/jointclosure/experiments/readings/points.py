"""Points of a study of readings: all cases of a rock in a reading, block by block."""

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
    """Name of the job that closes a block of a rock; never taken apart."""
    return f"{run}.{rock}.{block.start}"


def points_of_jobs(
    readings: Readings, configured: Configured
) -> tuple[dict[str, tuple[str, str, range]], Callable[[str, str, range], list[Point]]]:
    """Every job that a round may need, as run, rock and block, and what makes its points."""
    most = max(readings.reference_realizations, *(each.realizations for each in readings.rounds))
    runs = dict.fromkeys(each.run for each in readings.all())
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
    """The configuration of a rock alone in a reading, of which nothing is checked."""
    keys = complete(configured.keys)

    def typed_in(reading: str, rock: str) -> Configuration:
        alone = {"study": {"rocks": [rock]}}
        return with_keys(configured.typed, keys, alone | readings.reading(reading).keys)

    return typed_in


def jobs_of_round(readings: Readings, number: int, entrants: Sequence[str]) -> list[str]:
    """Jobs that the readings of a round need, and the configured one."""
    names = dict.fromkeys([AS_CONFIGURED, *entrants] if entrants else [])
    jobs = (
        job_name(readings.reading(name).run, rock, block)
        for name in names
        for rock in readings.rocks
        for block in readings.blocks(readings.realizations_of(name, number, rock))
    )
    return list(dict.fromkeys(jobs))


def settings_of_kernels(readings: Readings, configured: Configured) -> Iterable[ClosureSettings]:
    """Settings of every kernel that a reading, or a pair that can be closed, needs."""
    typed_in, found = _configurations(readings, configured), {}
    for each in readings.all():
        for rock in readings.rocks:
            typed = typed_in(each.run, rock)
            case = base_case(rock, typed.rocks[rock])
            settings = block_settings(typed, {case.label: case}, case.label, range(1))
            kernel = str(kernels_of([(case.effects, settings.choices, settings.numerics)]))
            if kernel not in found and can_be_run(readings, configured.keys, each.name):
                found[kernel] = settings
    return found.values()


def samples(readings: Readings, jobs: Jobs) -> dict[str, list[Sample]]:
    """Points that stand for the joints of each round, if as many readings enter as may.

    Surfaces that an earlier round closed are not counted again. Rounds after the first one take
    a joint to last as the mean reading in the rocks of the first round, and as the configured one
    in the others.
    """
    first = readings.blocks(readings.block)[0]
    runs = [name for name, each in readings.singles.items() if each.run == name]
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
    for each in readings.rounds:
        parts[each.name] = []
        for rock in each.rocks:
            new = each.realizations - (0 if each.candidates == PAIRS else closed[rock])
            joints = cases * max(new, 0)
            if each.candidates == SINGLES:
                parts[each.name] += [
                    Sample([point(run, rock)], joints) for run in runs if run != AS_CONFIGURED
                ]
            else:
                kept = min(each.most, len(readings.singles) - 1)
                count = kept * (kept - 1) // 2 if each.candidates == PAIRS else kept
                tried = runs if rock in readings.rounds[0].rocks else [AS_CONFIGURED]
                parts[each.name].append(Sample([point(run, rock) for run in tried], count * joints))
            closed[rock] = max(closed[rock], each.realizations)
    return parts
