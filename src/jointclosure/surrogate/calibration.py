"""Calibration of the bearing-area law: constants fitted to some joints and tested on others."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.config.typed import Grid, Surface
from jointclosure.ensemble.aggregation import succeeded
from jointclosure.ensemble.surfaces import walls_of_seed
from jointclosure.inputs import InputError
from jointclosure.joint.protocol import LOADING
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surface.roughness import z2_of_jrc
from jointclosure.surrogate.estimate import ALL_ROCKS, BearingLaw, WallMeasures, wall_measures

RATIOS = (0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.125, 0.15)
"""Stresses over compressive strength at which closures are compared, besides the maximum."""
FITTED_FROM = 0.05
"""Smallest ratio to which the constants are fitted; below, few asperities carry the load."""
ALLOWED = 4.0
"""Standard deviations about the mean of the joints' walls within which each measure of other walls
must be for these to count as the same kind. 99.99 % of walls of this kind satisfy this if measures
are normal."""
_BOUNDED = ("slope_ratio", "correlation")
"""Measures of walls that are bounded by their values, not by logarithms."""
_FRACTIONS = np.geomspace(1e-4, 0.6, 200)
_START = BearingLaw(0.3, 0.8)


class _Joints(NamedTuple):
    """First loadings of one case.

    ``ratios`` (s,): stresses over strength; ``closures`` (n, s) [m]; ``depths`` (n, f) [m] of the
    bearing-area curves at `_FRACTIONS`; ``fitted`` (n,): whether constants are fitted to a joint;
    ``walls``: the measures of each joint's walls.
    """

    case: int
    ratios: np.ndarray
    closures: np.ndarray
    depths: np.ndarray
    fitted: np.ndarray
    walls: list[WallMeasures]

    def errors(self, law: BearingLaw, which: np.ndarray, ratios: np.ndarray) -> np.ndarray:
        """Return relative errors (joints, ratios) of the law's closures."""
        at = np.log(np.clip(law.fraction(self.ratios[ratios]), _FRACTIONS[0], _FRACTIONS[-1]))
        estimated = [np.interp(at, np.log(_FRACTIONS), depths) for depths in self.depths[which]]
        return np.array(estimated) / self.closures[np.ix_(which, ratios)] - 1.0


def calibrate(ensemble: xr.Dataset, grid: Grid, surface: Surface) -> pd.DataFrame:
    """Fit the constants of the bearing-area law, and compute its errors on other joints.

    Parameters
    ----------
    ensemble : Dataset
        Closed joints with walls synthesised from a JRC, such as a study's pool. Constants are
        fitted to realisations of even number, and tested on those of odd number.
    grid, surface
        Settings of their walls.

    Returns
    -------
    DataFrame
        A row for each rock and JRC, stress over strength, and constants: those of "all" rocks,
        fitted to all cases, and "own", fitted to all cases of the rock. ``rms_percent``
        and ``mean_percent`` are those of the relative errors of closures on ``joints`` single
        joints. ``roll_off_mm``: that of the walls, or NaN. ``least_`` and ``most_`` are the bounds
        of a measure for walls of this kind, see `ALLOWED`.

    Raises
    ------
    InputError
        If no rock has walls synthesised from a JRC.
    """
    cases = _cases(ensemble, grid, surface)
    if not cases:
        raise InputError(
            "surrogate: at least one rock of the study must have walls made from a JRC"
        )
    names = ensemble.rock.values
    every = _fitted(cases)
    by_rock = {
        rock: _fitted([joints for joints in cases if names[joints.case] == rock])
        for rock in dict.fromkeys(names[joints.case] for joints in cases)
    }
    stiff = ensemble.youngs_modulus.values / ensemble.compressive_strength.values
    stiff = stiff[[joints.case for joints in cases]]
    about = {
        "roll_off_mm": np.nan if surface.roll_off is None else 1e3 * surface.roll_off,
        "spacing_m": grid.spacing,
        "length_m": grid.spacing * min(grid.shape),
        "least_modulus_over_strength": stiff.min(),
        "most_modulus_over_strength": stiff.max(),
    }
    allowed = bounds_of([walls for joints in cases for walls in joints.walls])
    for end in ("least", "most"):
        about[f"{end}_height_over_slope_m"] = allowed[f"{end}_height_over_slope"]
        about |= {f"{end}_{name}": allowed[f"{end}_{name}"] for name in _BOUNDED}
    rows: list[dict] = []
    for joints in cases:
        case = ensemble.isel(case=joints.case)
        if str(case.parameter.values) not in ("base", "jrc"):
            continue
        rock, jrc = str(case.rock.values), float(case.jrc)
        slope = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
        for constants, law in ((ALL_ROCKS, every), ("own", by_rock[rock])):
            row = {"constants": constants, "rock": rock, "jrc": jrc, "rms_slope": slope}
            row |= law._asdict() | about
            rows += _tested(joints, law, row, float(case.compressive_strength))
    return pd.DataFrame(rows)


def bounds_of(walls: list[WallMeasures]) -> dict[str, float]:
    """Return the bounds of measures of one kind of walls; of heights and slopes by logarithm."""
    ends = {}
    for name in ("height_over_slope", "rms_slope"):
        ends[name] = np.exp(_ends(np.log([getattr(measures, name) for measures in walls])))
    for name in _BOUNDED:
        ends[name] = _ends(np.array([getattr(measures, name) for measures in walls]))
    return {
        f"{end}_{name}": float(both[i])
        for name, both in ends.items()
        for i, end in enumerate(("least", "most"))
    }


def _ends(values: np.ndarray) -> np.ndarray:
    return values.mean() + ALLOWED * values.std(ddof=1) * np.array([-1.0, 1.0])


def _tested(joints: _Joints, law: BearingLaw, row: dict, strength: float) -> list[dict]:
    """Return errors on the joints that were not fitted, at every stress."""
    others = np.flatnonzero(~joints.fitted)
    errors = 100.0 * joints.errors(law, others, np.arange(joints.ratios.size))
    return [
        row
        | {
            "stress_over_strength": ratio,
            "stress_MPa": 1e-6 * ratio * strength,
            "joints": others.size,
            "rms_percent": float(np.sqrt(np.mean(errors[:, i] ** 2))),
            "mean_percent": float(np.mean(errors[:, i])),
        }
        for i, ratio in enumerate(joints.ratios.tolist())
    ]


def _cases(ensemble: xr.Dataset, grid: Grid, surface: Surface) -> list[_Joints]:
    """Return the first loadings of all cases with walls synthesised from a JRC."""
    loading = ensemble.closure.sel(cycle=1, branch=LOADING)
    loading = loading.transpose("case", "realization", "stress").values
    highest = ensemble.max_closure.sel(cycle=1).values
    good, cases = succeeded(ensemble).values, []
    known: dict[tuple[str, float], tuple[np.ndarray, WallMeasures]] = {}
    for i, jrc in enumerate(ensemble.jrc.values.tolist()):
        kept = np.flatnonzero(good[i])
        if np.isnan(jrc) or kept.size < 2:
            continue
        for seed in ensemble.seed.values[i, kept]:
            if (seed, jrc) not in known:
                upper, lower = walls_of_seed(int(seed, 16), jrc, grid, surface)
                depths = bearing_depths(upper + lower, _FRACTIONS)
                known[seed, jrc] = depths, wall_measures(upper, lower, grid.spacing)
        known_walls = [known[seed, jrc] for seed in ensemble.seed.values[i, kept]]
        curves = np.array([curve for curve, _ in known_walls])
        strength = float(ensemble.compressive_strength[i])
        maximum = float(ensemble.max_normal_stress[i])
        ratios = np.array([r for r in RATIOS if r < 0.999 * maximum / strength])
        ratios = np.append(ratios, maximum / strength)
        closures = []
        for curve, top in zip(loading[i, kept], highest[i, kept], strict=True):
            # a maximum reached from below leaves the last point of the axis without a closure
            read = np.isfinite(curve) & (ensemble.stress.values < maximum)
            stresses = np.append(ensemble.stress.values[read], maximum)
            closures.append(np.interp(ratios * strength, stresses, np.append(curve[read], top)))
        numbers = ensemble.realization.values[kept]
        walls = [measures for _, measures in known_walls]
        cases.append(_Joints(i, ratios, np.array(closures), curves, numbers % 2 == 0, walls))
    return cases


def _fitted(cases: list[_Joints]) -> BearingLaw:
    """Fit constants by least squares of the relative errors of the joints to be fitted."""

    def errors(logs: np.ndarray) -> np.ndarray:
        law = BearingLaw(float(np.exp(logs[0])), float(logs[1]))
        return np.concatenate([_to_fit(joints, law).ravel() for joints in cases])

    start = np.array([np.log(_START.at_strength), _START.exponent])
    logs = scipy.optimize.least_squares(errors, start).x
    return BearingLaw(float(np.exp(logs[0])), float(logs[1]))


def _to_fit(joints: _Joints, law: BearingLaw) -> np.ndarray:
    ratios = np.flatnonzero(joints.ratios >= FITTED_FROM)
    return joints.errors(law, np.flatnonzero(joints.fitted), ratios)
