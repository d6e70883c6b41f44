"""Closure curves for the figure that can be explored: numbers that a script of the page draws."""

import math

import numpy as np
import xarray as xr

from jointclosure.study.cases import PARAMETERS
from jointclosure.study.ensemble import succeeded
from jointclosure.study.sensitivity import SHOWN_UNITS
from jointclosure.tables import PARAMETER_TITLES

MOST_JOINTS = 20
"""Joints of a case whose own curves are in the page; means are over all of them."""

_MM = 1e3


def explorer_data(study: xr.Dataset, titles: dict[str, str], seating_stress: float) -> dict:
    """Curves of all cases, for JSON: closures in mm, stresses in MPa, absent numbers as None.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.study.ensemble.join_cases`.
    titles : dict
        Titles of the rocks, in order.
    seating_stress : float
        From which each cycle's loading can be counted [Pa].

    Returns
    -------
    dict
        ``cycles``, ``seating``, and ``rocks``: each a name, its ``stress`` axis up to its maximum,
        its ``parameters`` and its ``cases`` (see `_case`).
    """
    rocks = []
    for rock, title in titles.items():
        own = study.isel(case=np.flatnonzero(study.rock.values == rock))
        largest = float(own.max_normal_stress.max()) * (1.0 + 1e-9)
        own = own.sel(stress=study.stress[study.stress <= largest])
        varied = [p for p in PARAMETERS if p in own.parameter.values]
        rocks.append(
            {
                "title": title,
                "stress": np.round(1e-6 * own.stress.values, 6).tolist(),
                "parameters": [{"name": p, "title": PARAMETER_TITLES[p]} for p in varied],
                "cases": [_case(own.sel(case=case), varied) for case in own.case.values],
            }
        )
    return {
        "cycles": study.cycle.values.tolist(),
        "seating": 1e-6 * seating_stress,
        "rocks": rocks,
    }


def _case(case: xr.Dataset, varied: list[str]) -> dict:
    """One case: its values of the parameters, means, deviations, and curves of single joints.

    ``mean`` and ``deviation`` are [origin][cycle][branch][stress], with closures from first touch
    (origin 0) or from seating (1), absent where a joint that is used has no state at that
    stress; ``joints`` have a ``number``, ``curves`` [cycle][branch][stress] from first touch and
    the closures ``seats`` [cycle] at seating.
    """
    used = case.isel(realization=np.flatnonzero(succeeded(case).values))
    closure = used.closure.transpose("realization", "cycle", "branch", "stress")
    start = used.residual_closure.shift(cycle=1, fill_value=0.0)
    seats = start + used.max_closure - used.max_closure_seated
    both = [_MM * closure, _MM * (closure - seats)]
    digits = _digits(both[0].values)
    shown = used.isel(realization=slice(MOST_JOINTS))
    return {
        "parameter": case.parameter.item(),
        "level": case.level.item(),
        "values": {p: _value(p, float(case[p])) for p in varied},
        "used": used.sizes["realization"],
        "of": case.sizes["realization"],
        "mean": [_listed(_over_all(np.mean, part.values), digits) for part in both],
        "deviation": [_listed(_over_all(_deviation, part.values), digits) for part in both],
        "joints": [
            {
                "number": int(number),
                "curves": _listed(_MM * closure.values[i], digits),
                "seats": _listed(_MM * seats.transpose("realization", "cycle").values[i], digits),
            }
            for i, number in enumerate(shown.realization.values)
        ],
    }


def _value(parameter: str, value: float) -> str:
    """A parameter's value with its unit, as Table 1 has it."""
    unit, size = SHOWN_UNITS[parameter]
    return f"{value / size:.6g}" + ("" if unit == "1" else f" {unit}")


def _over_all(measure, curves: np.ndarray) -> np.ndarray:
    """A measure over the first axis, NaN where not all along it are known, or there are none."""
    if not len(curves):
        return np.full(curves.shape[1:], np.nan)
    known = np.isfinite(curves).all(axis=0)
    return np.where(known, measure(np.where(known, curves, 0.0), axis=0), np.nan)


def _deviation(values: np.ndarray, axis: int) -> np.ndarray:
    """Standard deviation of a sample, NaN of fewer than two."""
    if values.shape[axis] < 2:
        return np.full(values.shape[1:], np.nan)
    return np.std(values, axis=axis, ddof=1)


def _digits(values: np.ndarray) -> int:
    """Decimals that keep five figures of the largest number."""
    largest = np.max(np.abs(values), initial=0.0, where=np.isfinite(values))
    return 4 - math.floor(math.log10(largest)) if largest > 0.0 else 0


def _listed(values: np.ndarray, digits: int) -> list:
    """Nested lists of rounded numbers, None for what is not known."""
    rounded = np.round(values, digits).astype(object)
    return np.where(np.isfinite(values), rounded, None).tolist()
