"""Joints closed at the points of a design."""

import time
from collections.abc import Callable

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensemble.responses import cycle_responses
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.studies.global_sensitivity.design import SURFACES, Design, settings_at

RESPONSES = {
    "closure": "maximum closure",
    "closure_net": "maximum closure net of bulk indentation",
    "residual_seated_net": "net residual closure at seating",
    "stiffness_net": "net normal stiffness of loading, from half of the maximum to the landing",
}
"""What is read of each cycle. Of later cycles next to nothing stays."""
TRIED = 8
"""Joints of each rock by which the time is estimated."""
UNITS = dict.fromkeys(RESPONSES, "m") | {"stiffness_net": "Pa/m"}


def close_rows(
    design: Design,
    keys: dict,
    rock: str,
    rows: range,
    report: Callable[[str], None] = lambda line: None,
) -> xr.Dataset:
    """Close the joints of some rows of a design.

    Parameters
    ----------
    design : Design
    keys : dict
        Complete keys of the study.
    rock : str
    rows : range
    report : callable
        Receives a line for each row.

    Returns
    -------
    Dataset
        `RESPONSES` over (row, point, surface, cycle), NaN where a simulation failed; ``status``
        and ``seconds`` (of the processor) over (row, point, surface).
    """
    points = design.points()[rows.start : rows.stop]
    shape = (*points.shape[:2], SURFACES)
    found: dict[str, np.ndarray] = {}
    status, seconds = np.zeros(shape, np.int16), np.zeros(shape)
    for place, row in enumerate(rows):
        for column, point in enumerate(points[place]):
            settings = settings_at(design, keys, rock, row, point)
            for number, walls in enumerate(walls_of(settings.surfaces)):
                start = time.process_time()
                told, responses = cycle_responses(walls, settings.conditions())
                seconds[place, column, number] = time.process_time() - start
                status[place, column, number] = told
                for name in RESPONSES:
                    whole = found.setdefault(name, np.full((*shape, settings.cycles), np.nan))
                    whole[place, column, number] = responses[name]
        report(f"row {row}: {seconds[place].sum():.2f} s")
    over = ("row", "point", "surface")
    return xr.Dataset(
        {
            name: ((*over, "cycle"), values, {"long_name": RESPONSES[name], "units": UNITS[name]})
            for name, values in found.items()
        }
        | {"status": (over, status), "seconds": (over, seconds, {"units": "s"})},
        coords={
            "row": np.array(rows),
            "cycle": np.arange(1, next(iter(found.values())).shape[-1] + 1),
        },
    )


def costs(design: Design, keys: dict[str, dict]) -> pd.DataFrame:
    """Core-minutes of each rock, from the first point of the first `TRIED` rows.

    ``keys`` are those of each rock. Columns ``rock``, ``simulations``, ``seconds`` of one,
    ``core_minutes`` and its standard ``error``.
    """
    rows = []
    points = design.points()
    simulations = points.shape[0] * points.shape[1] * SURFACES
    for rock in design.rocks:
        taken = []
        for row in (0, *range(min(TRIED, len(points)))):
            settings = settings_at(design, keys[rock], rock, row, points[row, 0])
            start = time.process_time()
            cycle_responses(next(walls_of(settings.surfaces)), settings.conditions())
            taken.append(time.process_time() - start)
        del taken[0]  # loads the kernels
        seconds, error = mean_of(taken)
        rows.append({"rock": rock, "simulations": simulations, "seconds": seconds,
                     "core_minutes": simulations * seconds / 60.0,
                     "error": simulations * error / 60.0})  # fmt: skip
    return pd.DataFrame(rows)
