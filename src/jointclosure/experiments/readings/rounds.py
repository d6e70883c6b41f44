"""Readings judged after a round: closures by reading in, ranking out."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.experiments.readings.closing import joined
from jointclosure.experiments.readings.design import AS_CONFIGURED, Design
from jointclosure.experiments.readings.likelihood import Question, answer_of, ranking
from jointclosure.experiments.readings.pools import Closures

Blocks = Mapping[tuple[str, str], list[xr.Dataset]]
"""Blocks of closures by (run, rock), in the order of their realisations."""


def blocks_of(
    files: Iterable[tuple[str, str, str]], read: Callable[[str], xr.Dataset]
) -> dict[tuple[str, str], list[xr.Dataset]]:
    """Blocks by (run, rock), from `jointclosure.experiments.readings.design.files_of`."""
    blocks: dict[tuple[str, str], list[xr.Dataset]] = {}
    for run, rock, file in files:
        blocks.setdefault((run, rock), []).append(read(file))
    return blocks


def round_table(
    design: Design, number: int, readings: list[str], blocks: Blocks, question: Question
) -> pd.DataFrame:
    """Ranking of the readings that entered a round, the best first.

    Parameters
    ----------
    design : Design
    number : int
        Of the round.
    readings : list of str
    blocks : mapping
        Of all readings that entered, and of the configured one in all rocks.
    question : Question
    """
    if not readings:
        return ranking({}, design.rounds[number].margin)
    reference = closures_of(design, AS_CONFIGURED, blocks, dict.fromkeys(design.rocks))
    answers = {}
    for name in readings:
        answers[name] = answer_of(question, in_round(design, number, name, blocks), reference)
    return ranking(answers, design.rounds[number].margin)


def in_round(design: Design, number: int, reading: str, blocks: Blocks) -> Closures:
    """What a round closed of a reading: its rocks, and no more than its realisations."""
    this = design.rounds[number]
    return closures_of(design, reading, blocks, dict.fromkeys(this.rocks, this.realizations))


def closures_of(
    design: Design, reading: str, blocks: Blocks, most: Mapping[str, int | None]
) -> Closures:
    """Closures of a reading by rock, of the realisations below ``most`` (None: of all)."""
    one = design.reading(reading)
    found = {}
    for rock, last in most.items():
        whole = joined(blocks[one.run, rock], one.closure)
        numbers = whole.realization.values
        found[rock] = whole.isel(realization=np.flatnonzero(numbers < (last or np.inf)))
    return found
