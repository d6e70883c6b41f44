"""Closures of readings from the table of all joints, and the ranking of a round."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.experiments.readings.design import AS_CONFIGURED, CLOSURES, Readings
from jointclosure.experiments.readings.likelihood import Question, answer_of, ranking
from jointclosure.experiments.readings.pools import Closures


def round_table(
    readings: Readings, number: int, entrants: list[str], joints: pd.DataFrame, question: Question
) -> pd.DataFrame:
    """Ranking of the readings that entered a round, the best first.

    Parameters
    ----------
    readings : Readings
    number : int
        Of the round.
    entrants : list of str
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, of all readings that entered, and of
        the configured one in all rocks.
    question : Question
    """
    if not entrants:
        return ranking({}, readings.rounds[number].margin)
    reference = closures_of(readings, AS_CONFIGURED, joints, dict.fromkeys(readings.rocks))
    answers = {}
    for name in entrants:
        answers[name] = answer_of(question, in_round(readings, number, name, joints), reference)
    return ranking(answers, readings.rounds[number].margin)


def in_round(readings: Readings, number: int, reading: str, joints: pd.DataFrame) -> Closures:
    """What a round closed of a reading: its rocks, and no more than its realisations."""
    this = readings.rounds[number]
    return closures_of(readings, reading, joints, dict.fromkeys(this.rocks, this.realizations))


def closures_of(
    readings: Readings, reading: str, joints: pd.DataFrame, most: Mapping[str, int | None]
) -> Closures:
    """Closures of a reading by rock, of the realisations below ``most`` (None: of all)."""
    one = readings.reading(reading)
    found = {}
    for rock, last in most.items():
        here = (joints.run == one.run) & (joints.rock == rock)
        whole = on_cases(joints[here], CLOSURES[one.closure])
        numbers = whole.realization.values
        found[rock] = whole.isel(realization=np.flatnonzero(numbers < (last or np.inf)))
    return found


def on_cases(joints: pd.DataFrame, quantity: str) -> xr.DataArray:
    """A quantity (case, realization, cycle) of the joints of a rock in a reading.

    ``parameter`` and ``value`` [SI, NaN at the base] are coordinates of the cases. Surfaces on
    which a simulation failed at any case are left out at all.
    """
    cases = joints[["parameter", "value"]].drop_duplicates()
    case = joints.groupby(["parameter", "value"], dropna=False, sort=False).ngroup()
    place, numbers = pd.factorize(joints.realization)
    values = np.full((len(cases), numbers.size, joints.cycle.max()), np.nan)
    values[case, place, joints.cycle - 1] = joints[quantity]
    whole = xr.DataArray(
        values,
        dims=("case", "realization", "cycle"),
        coords={
            "realization": numbers,
            "cycle": np.arange(1, values.shape[-1] + 1),
            "parameter": ("case", cases.parameter.to_numpy()),
            "value": ("case", cases.value.to_numpy()),
        },
    )
    return whole.isel(realization=np.flatnonzero(np.isfinite(values).all(axis=(0, 2))))
