"""From closures to the pools that repetitions of the paper's study are drawn from."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from jointclosure.ensemble.cases import BASE
from jointclosure.inputs import InputError
from jointclosure.statistics.drawn_studies import Pool, Sensitivity

Closures = Mapping[str, xr.DataArray]
"""A closure (case, realization, cycle) [m] by rock."""
Parameters = Mapping[str, Mapping[str, tuple[tuple[float, ...], float]]]
"""By rock and parameter: its levels, ascending, and the rock's own value [SI]."""


def levels_closed(closures: xr.DataArray, parameter: str, levels: tuple, base: float) -> np.ndarray:
    """Closures (levels, realization, cycle) of a rock at the levels of a parameter, ascending."""
    of_parameter = (closures.parameter == parameter).values
    rows = []
    for level in levels:
        here = of_parameter & (closures.value == level).values
        if level == base:
            here = (closures.parameter == BASE).values
        rows.append(int(np.flatnonzero(here)[0]))
    return closures.values[rows]


def sensitivities_of(
    closures: Closures, parameters: Parameters
) -> dict[tuple[str, str], Sensitivity]:
    """Pools by (rock, parameter), the targets being the cycles.

    A rock's cases have common surfaces, so that its pools bear one name.
    """
    found = {}
    for rock, of_rock in parameters.items():
        for parameter, (levels, base) in of_rock.items():
            values = levels_closed(closures[rock], parameter, levels, base)
            pools = tuple(Pool(at_level.T, rock) for at_level in values)
            found[rock, parameter] = Sensitivity(np.array(levels), base, pools)
    return found


def transferred(changed: Closures, reference: Closures, parameters: Parameters) -> Closures:
    """Closures of all rocks in a reading of which only some rocks were closed.

    The reading is taken to change every rock alike: at each level, low to high, of each
    parameter, the mean by the mean factor of the rocks closed, on the surfaces closed in both;
    the coefficient of variation of each cycle by the factor of theirs, over all levels.

    Parameters
    ----------
    changed : mapping
        The rocks closed in the reading.
    reference : mapping
        All rocks as configured, on these surfaces and more.
    parameters : mapping

    Returns
    -------
    mapping
        All rocks, on the surfaces of the reference.
    """
    means, variations = [], []
    for rock, closures in changed.items():
        common = np.intersect1d(closures.realization, reference[rock].realization)
        if common.size < 2:
            raise InputError(
                f"{rock}: {common.size} surfaces closed in a reading and as configured, "
                "needs two or more"
            )
        new = _ordered(closures.sel(realization=common), parameters[rock])
        old = _ordered(reference[rock].sel(realization=common), parameters[rock])
        means.append(new.mean(axis=1) / old.mean(axis=1))
        variations.append(np.stack([_square_variation(each) for each in (new, old)]))
    factor = np.mean(means, axis=0)[:, None, :]
    squares = np.mean(variations, axis=0)
    spread = np.sqrt(squares[0] / squares[1])
    answer = {}
    for rock, of_rock in parameters.items():
        values = _ordered(reference[rock], of_rock)
        middle = values.mean(axis=1, keepdims=True)
        answer[rock] = xr.DataArray(
            middle * factor * (1.0 + (values / middle - 1.0) * spread),
            dims=("case", "realization", "cycle"),
            coords={
                "realization": reference[rock].realization.values,
                "cycle": reference[rock].cycle.values,
                "parameter": ("case", [name for name, _ in _cases(of_rock)]),
                "value": ("case", [value for _, value in _cases(of_rock)]),
            },
        )
    return answer


def _cases(of_rock: Mapping) -> list[tuple[str, float]]:
    """(parameter, value) of all cases of a rock, the base first, levels ascending."""
    changed = [
        (name, level)
        for name, (levels, base) in of_rock.items()
        for level in levels
        if level != base
    ]
    return [(BASE, np.nan), *changed]


def _ordered(closures: xr.DataArray, of_rock: Mapping) -> np.ndarray:
    """Closures (case, realization, cycle) in the order of `_cases`."""
    rows = [(closures.parameter == BASE).values]
    rows += [
        ((closures.parameter == name) & (closures.value == value)).values
        for name, value in _cases(of_rock)[1:]
    ]
    return np.concatenate([closures.values[row] for row in rows])


def _square_variation(values: np.ndarray) -> np.ndarray:
    """Squared coefficient of variation (cycle,), over all cases."""
    return np.mean(values.var(axis=1, ddof=1) / values.mean(axis=1) ** 2, axis=0)
