"""Covariates of surface pairs, and what many surfaces tell of them.

They are depths on the bearing-area curve of the summed heights, over the RMS slope Z2 of the
walls' JRC. Walls of other JRC are the same walls, scaled by Z2: so these depths are distributed
alike in all cases of a study, and surfaces made once tell their means for all.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.config.typed import Grid, Surface
from jointclosure.ensemble.surfaces import walls_of_seed
from jointclosure.statistics.control_variates import Known
from jointclosure.statistics.randomness import seed_of
from jointclosure.surface.bearing import bearing_depths, bearing_excess
from jointclosure.surface.roughness import z2_of_jrc

OF_FIRST_CYCLE, OF_LATER_CYCLES = ("depth_1", "depth_5"), ("excess_5",)
"""Covariates by which closures of the cycles are adjusted (docs/accuracy.md)."""
COVARIATES = (*OF_FIRST_CYCLE, *OF_LATER_CYCLES)
_REFERENCE_JRC = 10.0
"""Of the surfaces that tell the means; any other gives the same."""


class Covariates(NamedTuple):
    """Covariates of what was simulated, and what is known of them.

    ``values``: array (case, realization, covariate) [m per unit slope], NaN for scanned walls;
    ``known``: of all `COVARIATES`. ``tell_scatter``: whether standard deviations are adjusted
    too; those of later cycles are worse for it (docs/accuracy.md).
    """

    values: np.ndarray
    known: Known
    tell_scatter: bool = True

    def of_cycle(self, cycle: int) -> "Covariates":
        """Those by which closures of a cycle are adjusted."""
        names = OF_FIRST_CYCLE if cycle == 1 else OF_LATER_CYCLES
        chosen = [COVARIATES.index(name) for name in names]
        means, covariance, surfaces = self.known
        known = Known(means[chosen], covariance[np.ix_(chosen, chosen)], surfaces)
        return Covariates(self.values[..., chosen], known, tell_scatter=cycle == 1)


def covariates_of_pair(upper: np.ndarray, lower: np.ndarray, z2: float) -> np.ndarray:
    """`COVARIATES` (3,) of two walls (y, x) [m] whose JRC stands for a slope Z2 [m]."""
    summed = upper + lower
    depths = bearing_depths(summed, [0.01, 0.05])
    return np.array([*depths, bearing_excess(summed, 0.05)]) / z2


def measure_covariates(study: xr.Dataset, grid: Grid, surface: Surface) -> np.ndarray:
    """Covariates (case, realization, covariate) of all that a study closed, from its seeds.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.ensemble.aggregation.join_cases`.
    grid : Grid
    surface : Surface
        Those that its walls were made with.
    """
    values = np.full((*study.seed.shape, len(COVARIATES)), np.nan)
    for i, jrc in enumerate(study.jrc.values.tolist()):
        if np.isnan(jrc):  # scanned walls: no surfaces tell their means
            continue
        if i and jrc == study.jrc.values[i - 1] and (study.seed[i] == study.seed[i - 1]).all():
            values[i] = values[i - 1]
            continue
        seeds = [int(seed, 16) for seed in study.seed.values[i]]
        values[i] = _of_surfaces(seeds, jrc, grid, surface)
    return values


def known_covariates(surfaces: int, root_seed: int, grid: Grid, surface: Surface) -> Known:
    """What surfaces of their own, of no study, tell of the covariates.

    Parameters
    ----------
    surfaces : int
        How many.
    root_seed : int
    grid : Grid
    surface : Surface
    """
    seeds = [seed_of(root_seed, "covariates", number) for number in range(surfaces)]
    values = _of_surfaces(seeds, _REFERENCE_JRC, grid, surface)
    return Known(values.mean(axis=0), np.cov(values.T), surfaces)


def as_dataset(covariates: Covariates, study: xr.Dataset) -> xr.Dataset:
    """Covariates of a study, to be written; `from_dataset` is the way back."""
    unit = {"units": "m", "long_name": "covariate, over the RMS slope of the JRC"}
    known = covariates.known
    return xr.Dataset(
        {
            "covariate_value": (("case", "realization", "covariate"), covariates.values, unit),
            "known_mean": ("covariate", known.means, unit),
            "known_covariance": (("covariate", "other"), known.covariance, {"units": "m2"}),
        },
        coords={
            "case": study.case.values,
            "realization": study.realization.values,
            "covariate": np.array(COVARIATES, dtype=object),
        },
        attrs={"title": "covariates of simulated surfaces", "surfaces": known.surfaces},
    )


def from_dataset(dataset: xr.Dataset) -> Covariates:
    """Covariates as they were written by `as_dataset`."""
    known = Known(
        dataset.known_mean.values, dataset.known_covariance.values, int(dataset.attrs["surfaces"])
    )
    return Covariates(dataset.covariate_value.values, known)


def _of_surfaces(seeds: list[int], jrc: float, grid: Grid, surface: Surface) -> np.ndarray:
    z2 = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
    pairs = (walls_of_seed(seed, jrc, grid, surface) for seed in seeds)
    return np.array([covariates_of_pair(upper, lower, z2) for upper, lower in pairs])
