"""Closures of readings by rock, and pools from which the paper's study is drawn again."""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.findings import LOOP
from jointclosure.ensemble.cases import BASE
from jointclosure.experiments.readings.design import AS_CONFIGURED, CLOSURES, Readings
from jointclosure.inputs import InputError
from jointclosure.statistics.drawn_studies import Pool, Sensitivity

Closures = Mapping[str, xr.DataArray]
"""A closure (case, realization, cycle) [m] by rock."""
Parameters = Mapping[str, Mapping[str, tuple[tuple[float, ...], float]]]
"""By rock and parameter: its levels, ascending, and the base value of the rock [SI]."""


def closures_of(
    readings: Readings, reading: str, joints: pd.DataFrame, most: Mapping[str, int | None]
) -> Closures:
    """Return the closures of a reading by rock, of realisations below ``most`` (None: of all)."""
    one = readings.reading(reading)
    closures = {}
    for rock, last in most.items():
        here = (joints.run == one.run) & (joints.rock == rock)
        of_rock = on_cases(joints[here], CLOSURES[one.closure])
        closures[rock] = of_rock[:, of_rock.realization.values < (last or np.inf)]
    return closures


def in_round(readings: Readings, number: int, reading: str, joints: pd.DataFrame) -> Closures:
    """Return the closures of a reading in a round: of its rocks and number of realisations."""
    this = readings.rounds[number]
    return closures_of(readings, reading, joints, dict.fromkeys(this.rocks, this.realizations))


def as_configured(readings: Readings, joints: pd.DataFrame) -> Closures:
    """Return all closures of the configured reading, in all rocks."""
    return closures_of(readings, AS_CONFIGURED, joints, dict.fromkeys(readings.rocks))


def samples_of_surfaces(closures: Closures, groups: int) -> list[Callable]:
    """Return rules that keep all surfaces, and all but each group of a jackknife.

    A rule is a function of the numbers of surfaces that returns whether each is kept. There are at
    most as many groups as surfaces.
    """
    groups = min(groups, *(of_rock.sizes["realization"] for of_rock in closures.values()))
    rules: list[Callable] = [lambda number: number >= 0]
    return rules + [lambda number, group=i: number % groups != group for i in range(groups)]


def kept_surfaces(closures: Closures, kept: Callable) -> Closures:
    """Return closures on the surfaces whose number a rule keeps."""
    return {
        rock: of_rock[:, kept(of_rock.realization.values)] for rock, of_rock in closures.items()
    }


def on_cases(joints: pd.DataFrame, quantity: str) -> xr.DataArray:
    """Arrange a quantity of the joints of a rock in a reading over (case, realization, cycle).

    ``parameter`` and ``value`` [SI, NaN at the base] are coordinates of the cases, ``loop``
    (realization, cycle) [m] that of the base case. Surfaces with a failed simulation in any case
    are left out.
    """
    cases = joints[["parameter", "value"]].drop_duplicates()
    case = joints.groupby(["parameter", "value"], dropna=False, sort=False).ngroup()
    place, numbers = pd.factorize(joints.realization)
    values = np.full((len(cases), numbers.size, joints.cycle.max()), np.nan)
    loops = values.copy()
    values[case, place, joints.cycle - 1] = joints[quantity]
    loops[case, place, joints.cycle - 1] = joints[LOOP]
    closures = xr.DataArray(
        values,
        dims=("case", "realization", "cycle"),
        coords={
            "realization": numbers,
            "cycle": np.arange(1, values.shape[-1] + 1),
            "parameter": ("case", cases.parameter.to_numpy()),
            "value": ("case", cases.value.to_numpy()),
            LOOP: (("realization", "cycle"), loops[(cases.parameter == BASE).values][0]),
        },
    )
    return closures[:, np.isfinite(values).all(axis=(0, 2))]


def at_levels(closures: xr.DataArray, parameter: str, levels: tuple, base: float) -> xr.DataArray:
    """Return the closures (case, realization, cycle) of a rock at all levels of a parameter."""
    of_parameter = (closures.parameter == parameter).values
    at_base = (closures.parameter == BASE).values
    cases = (
        at_base if level == base else of_parameter & (closures.value == level).values
        for level in levels
    )
    return closures[[int(np.flatnonzero(case)[0]) for case in cases]]


def sensitivities_of(
    closures: Closures, parameters: Parameters
) -> dict[tuple[str, str], Sensitivity]:
    """Return pools by (rock, parameter), whose targets are the cycles.

    The cases of a rock have common surfaces, so that its pools have one name.
    """
    sensitivities = {}
    for rock, of_rock in parameters.items():
        for parameter, (levels, base) in of_rock.items():
            values = at_levels(closures[rock], parameter, levels, base).values
            pools = tuple(Pool(at_level.T, rock) for at_level in values)
            sensitivities[rock, parameter] = Sensitivity(np.array(levels), base, pools)
    return sensitivities


def transferred(changed: Closures, reference: Closures, parameters: Parameters) -> Closures:
    """Estimate closures of all rocks in a reading in which only some rocks were closed.

    All rocks are assumed to change alike: at each level, low to high, of each parameter, the mean
    changes by the mean factor of the closed rocks, on the surfaces closed in both readings; the
    coefficient of variation of each cycle by their factor over all levels.

    Parameters
    ----------
    changed : mapping
        Closures of the rocks closed in the reading.
    reference : mapping
        Closures of all rocks as configured, on the same surfaces and more.
    parameters : mapping

    Returns
    -------
    mapping
        Closures of all rocks, on the surfaces of the reference.
    """
    means, variations = [], []
    for rock, closures in changed.items():
        common = np.intersect1d(closures.realization, reference[rock].realization)
        if common.size < 2:
            raise InputError(
                f"{rock}: {common.size} surfaces closed in a reading and as configured, "
                "needs two or more"
            )
        new, old = (
            _ordered(both.sel(realization=common), parameters[rock]).values
            for both in (closures, reference[rock])
        )
        means.append(new.mean(axis=1) / old.mean(axis=1))
        variations.append(np.stack([_square_variation(values) for values in (new, old)]))
    factor = np.mean(means, axis=0)[:, None, :]
    squares = np.mean(variations, axis=0)
    spread = np.sqrt(squares[0] / squares[1])
    answer = {}
    for rock, of_rock in parameters.items():
        ordered = _ordered(reference[rock], of_rock)
        middle = ordered.values.mean(axis=1, keepdims=True)
        answer[rock] = ordered.copy(
            data=middle * factor * (1.0 + (ordered.values / middle - 1.0) * spread)
        )
    return answer


def _ordered(closures: xr.DataArray, of_rock: Mapping) -> xr.DataArray:
    """Return closures with the base case first, then the other levels of all parameters."""
    cases = [closures[(closures.parameter == BASE).values]]
    for name, (levels, base) in of_rock.items():
        others = tuple(level for level in levels if level != base)
        cases.append(at_levels(closures, name, others, base))
    return xr.concat(cases, "case")


def _square_variation(values: np.ndarray) -> np.ndarray:
    """Compute the squared coefficient of variation (cycle,), over all cases."""
    return np.mean(values.var(axis=1, ddof=1) / values.mean(axis=1) ** 2, axis=0)
