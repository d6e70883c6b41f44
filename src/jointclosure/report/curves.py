"""Closure curves for the interactive figure of the page, as numbers for its script."""

import math

import numpy as np
import xarray as xr

from jointclosure.config.properties import PARAMETER_TITLES, PARAMETERS, PROPERTIES
from jointclosure.ensemble.aggregation import seats, succeeded

MOST_JOINTS = 20
"""Largest number of joints of a case whose curves are in the page; means are over all joints."""

_MM = 1e3
_BLOCK = 512
"""Number of joints in memory at a time."""
_READ = ("closure", "max_closure", "max_closure_seated", "residual_closure")


def explorer_data(study: xr.Dataset, titles: dict[str, str], seating_stress: float) -> dict:
    """Return curves of all cases for JSON: closures in mm, stresses in MPa, None if missing.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.ensemble.aggregation.join_cases`.
    titles : dict
        Titles of the rocks, in order.
    seating_stress : float
        Stress from which closure of each cycle can count [Pa].

    Returns
    -------
    dict
        ``cycles``, ``seating``, and ``rocks``: for each rock its name, ``stress`` axis up to its
        maximum, ``parameters`` and ``cases`` (see `_case`).
    """
    rocks = []
    for rock, title in titles.items():
        of_rock = study.isel(case=np.flatnonzero(study.rock.values == rock))
        largest = float(of_rock.max_normal_stress.max()) * (1.0 + 1e-9)
        of_rock = of_rock.sel(stress=study.stress[study.stress <= largest])
        varied = [p for p in PARAMETERS if p in of_rock.parameter.values]
        rocks.append(
            {
                "title": title,
                "stress": np.round(1e-6 * of_rock.stress.values, 6).tolist(),
                "parameters": [{"name": p, "title": PARAMETER_TITLES[p]} for p in varied],
                "cases": [_case(of_rock.sel(case=case), varied) for case in of_rock.case.values],
            }
        )
    return {
        "cycles": study.cycle.values.tolist(),
        "seating": 1e-6 * seating_stress,
        "rocks": rocks,
    }


def _case(case: xr.Dataset, varied: list[str]) -> dict:
    """Return one case: its values of the parameters, means, deviations, and curves of joints.

    ``mean`` and ``deviation`` are [origin][cycle][branch][stress], with closures from first touch
    (origin 0), from seating (1) or from the start of the cycle (2). They are missing if a joint has
    no state at that stress. ``joints`` have a ``number``, ``curves`` [cycle][branch][stress] from
    first touch, and the closures ``seats`` [cycle] at seating and ``starts`` [cycle].
    """
    used = np.flatnonzero(succeeded(case).values)
    moments = [_Moments(), _Moments(), _Moments()]
    digits, joints = None, []
    for start in range(0, used.size, _BLOCK):
        block = case[list(_READ)].isel(realization=used[start : start + _BLOCK]).load()
        closure = _MM * block.closure.transpose("realization", "cycle", "branch", "stress")
        seated = _MM * seats(block).transpose("realization", "cycle")
        starts = _MM * _starts(block)
        moments[0].add(closure.values)
        moments[1].add((closure - seated).values)
        moments[2].add((closure - starts).values)
        if start == 0:
            digits = _digits(closure.values)
            joints = [_joint(closure[i], seated[i], starts[i], digits) for i in range(len(closure))]
    shape = (case.sizes["cycle"], case.sizes["branch"], case.sizes["stress"])
    return {
        "parameter": case.parameter.item(),
        "level": case.level.item(),
        "values": {p: _value(p, float(case[p])) for p in varied},
        "used": int(used.size),
        "of": case.sizes["realization"],
        "mean": [_listed(part.mean(shape), digits) for part in moments],
        "deviation": [_listed(part.deviation(shape), digits) for part in moments],
        "joints": joints[:MOST_JOINTS],
    }


def _starts(block: xr.Dataset) -> xr.DataArray:
    """Return closures (realization, cycle) [m] from first touch at the start of cycles."""
    start = block.residual_closure.shift(cycle=1, fill_value=0.0)
    return start.transpose("realization", "cycle")


def _joint(closure: xr.DataArray, seats: xr.DataArray, starts: xr.DataArray, digits: int) -> dict:
    return {
        "number": int(closure.realization),
        "curves": _listed(closure.values, digits),
        "seats": _listed(seats.values, digits),
        "starts": _listed(starts.values, digits),
    }


class _Moments:
    """Mean and standard deviation over joints in blocks, NaN where a joint lacks a number."""

    def __init__(self):
        self.count, self.known, self.centre, self.squares = 0, True, 0.0, 0.0

    def add(self, block: np.ndarray) -> None:
        """Add curves (joint, ...), at least one, by the rule of Chan, Golub & LeVeque 1983."""
        self.known = self.known & np.isfinite(block).all(axis=0)
        block = np.where(self.known, block, 0.0)
        mean, size = block.mean(axis=0), len(block)
        total = self.count + size
        step = mean - self.centre
        self.squares += np.square(block - mean).sum(axis=0)
        self.squares += np.square(step) * self.count * size / total
        self.centre += step * size / total
        self.count = total

    def mean(self, shape: tuple) -> np.ndarray:
        """Return the mean; the shape is used if there are no curves."""
        return np.where(self.known, self.centre, np.nan) if self.count else np.full(shape, np.nan)

    def deviation(self, shape: tuple) -> np.ndarray:
        """Return the sample standard deviation, NaN for fewer than two curves."""
        if self.count < 2:
            return np.full(shape, np.nan)
        return np.where(self.known, np.sqrt(self.squares / (self.count - 1)), np.nan)


def _value(parameter: str, value: float) -> str:
    """Format a parameter's value with its unit, as in Table 1."""
    unit, size = PROPERTIES[parameter].unit, PROPERTIES[parameter].size
    return f"{value / size:.6g}" + ("" if unit == "1" else f" {unit}")


def _digits(values: np.ndarray) -> int:
    """Return the decimals that keep five digits of the largest number."""
    largest = np.max(np.abs(values), initial=0.0, where=np.isfinite(values))
    return 4 - math.floor(math.log10(largest)) if largest > 0.0 else 0


def _listed(values: np.ndarray, digits: int | None) -> list:
    """Return nested lists of rounded numbers, with None for unknown ones."""
    rounded = np.round(values, digits or 0).astype(object)
    unknown = np.array(None, dtype=object)
    return np.where(np.isfinite(values), rounded, unknown).tolist()
