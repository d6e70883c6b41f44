"""Runs of an accuracy study: the same surfaces closed at all levels of a rock property, timed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.ensemble.timing import timed_simulation


class Run(NamedTuple):
    """Closures of the same surfaces at all levels of a rock property.

    ``levels`` are their settings, the property's values ascending; ``values`` these
    values and ``base`` the rock's own [SI].
    """

    levels: tuple[ClosureSettings, ...]
    values: tuple[float, ...]
    base: float


def close_run(run: Run, report: Callable[[str], None] = lambda line: None) -> xr.Dataset:
    """Close the surfaces of a run at all levels of a rock property.

    Returns
    -------
    Dataset
        ``max_closure`` and ``max_closure_net`` [m] over (level, realization, cycle), ``status``,
        ``timing_simulation`` [s] and ``timing_pair`` [s], the time of one FFT pair
        (`scipy.fft.rfft2` and `irfft2` of 200 x 200) beside each simulation.
    """
    first = run.levels[0]
    shape = (len(run.levels), first.surfaces.realizations)
    closure, net = np.full((2, *shape, first.cycles), np.nan)
    status = np.zeros(shape, np.int16)
    seconds, pairs = np.zeros(shape), np.zeros(shape)
    for realization, walls in enumerate(walls_of(first.surfaces)):
        for level, settings in enumerate(run.levels):
            timed = timed_simulation(walls, settings.conditions())
            closure[level, realization] = timed.closed.max_closure.values
            bulk = timed.closed.max_bulk_indentation.values
            net[level, realization] = timed.closed.max_closure.values - bulk
            status[level, realization] = timed.closed.status
            seconds[level, realization] = timed.seconds
            pairs[level, realization] = timed.pair
        report(f"realisation {realization}: {seconds[:, realization].sum():.2f} s")
    dimensions = ("level", "realization")
    return xr.Dataset(
        {
            "max_closure": ((*dimensions, "cycle"), closure, {"units": "m"}),
            "max_closure_net": ((*dimensions, "cycle"), net, {"units": "m"}),
            "status": (dimensions, status),
            "timing_simulation": (dimensions, seconds, {"units": "s"}),
            "timing_pair": (dimensions, pairs, {"units": "s"}),
        },
        coords={
            "level": list(run.values),
            "cycle": np.arange(1, first.cycles + 1),
        },
        attrs={"base": run.base},
    )


def one_joint(run: Run) -> Run:
    """The run with its first realisation only."""
    surfaces = run.levels[0].surfaces._replace(realizations=1)
    return run._replace(levels=tuple(each._replace(surfaces=surfaces) for each in run.levels))
