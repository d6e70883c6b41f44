"""Surfaces closed at all cases of a rock in one reading, and put together again."""

import time
from collections.abc import Callable, Iterable

import numpy as np
import xarray as xr

from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.joint.protocol import FAILURE

CLOSURES = ("max_closure", "max_closure_seated", "max_bulk_indentation")


def close_block(
    settings: tuple[ClosureSettings, ...], report: Callable[[str], None] = lambda line: None
) -> xr.Dataset:
    """Close the surfaces of a block at all cases of a rock.

    Parameters
    ----------
    settings : tuple of ClosureSettings
        One for each case, with the same realisations.
    report : callable
        Receives a line for each case.

    Returns
    -------
    Dataset
        Over (case, realization, cycle): ``max_closure``, ``max_closure_seated``,
        ``max_closure_net`` [m]; ``status`` and ``seconds`` (of the processor) of each simulation.
        Coordinates
        ``parameter`` and ``value`` [SI, NaN at the base] along case.
    """
    first = settings[0].surfaces
    numbers = np.arange(first.first_realization, first.first_realization + first.realizations)
    shape = (len(settings), numbers.size)
    found = {name: np.full((*shape, settings[0].cycles), np.nan) for name in CLOSURES}
    status, seconds = np.zeros(shape, np.int16), np.zeros(shape)
    for row, each in enumerate(settings):
        conditions = each.conditions()
        for column, walls in enumerate(walls_of(each.surfaces)):
            start = time.process_time()
            closed = close_walls(*walls, conditions)
            seconds[row, column] = time.process_time() - start
            status[row, column] = closed.status
            for name in CLOSURES:
                found[name][row, column] = closed[name].values
        report(f"{each.case.label}: {seconds[row].sum():.2f} s")
    found["max_closure_net"] = found["max_closure"] - found.pop("max_bulk_indentation")
    dimensions = ("case", "realization")
    return xr.Dataset(
        {name: ((*dimensions, "cycle"), values, {"units": "m"}) for name, values in found.items()}
        | {"status": (dimensions, status), "seconds": (dimensions, seconds, {"units": "s"})},
        coords={
            "realization": numbers,
            "cycle": np.arange(1, settings[0].cycles + 1),
            "parameter": ("case", [each.case.parameter for each in settings]),
            "value": ("case", [each.case.value for each in settings]),
        },
    )


def one_simulation(settings: tuple[ClosureSettings, ...]) -> tuple[ClosureSettings, ...]:
    """The first case with its first realisation only."""
    surfaces = settings[0].surfaces._replace(realizations=1)
    return (settings[0]._replace(surfaces=surfaces),)


def joined(blocks: Iterable[xr.Dataset], closure: str) -> xr.DataArray:
    """A closure (case, realization, cycle) [m] of all blocks of a rock.

    Surfaces on which a simulation failed at any case are left out at all.
    """
    whole = xr.concat(list(blocks), "realization")
    good = (whole.status < FAILURE).all("case") & (abs(whole[closure]) < np.inf).all(
        ("case", "cycle")
    )
    return whole[closure].isel(realization=np.flatnonzero(good.values))
