"""Covariates of surface pairs, and their means over many surfaces.

The covariates are depths on the bearing-area curve of the summed heights, over the RMS slope Z2 of
the walls' JRC. Walls of another JRC are the same walls scaled by Z2. Therefore these depths have
the same distribution in all cases of a study, and their means, computed once from surfaces of one
JRC, hold for all cases.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.settings import Grid, Surface, walls_of_seed
from jointclosure.statistics.control_variates import Known
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls.roughness import bearing_depths, bearing_excess, z2_of_jrc

OF_FIRST_CYCLE, OF_LATER_CYCLES = ("depth_1", "depth_5"), ("excess_5",)
"""Covariates by which closures of the first and of later cycles are adjusted (docs/accuracy.md)."""
COVARIATES = (*OF_FIRST_CYCLE, *OF_LATER_CYCLES)
_REFERENCE_JRC = 10.0
"""JRC of the surfaces from which the means are computed; any other JRC gives the same means."""


class Covariates(NamedTuple):
    """Covariates (case, realization, covariate) [m per unit slope], NaN for scans, and known means.

    ``tell_scatter``: deviations are adjusted too, which is less accurate on later cycles.
    """

    values: np.ndarray
    known: Known
    tell_scatter: bool = True

    def of_cycle(self, cycle: int) -> "Covariates":
        """Return the covariates by which closures of a cycle are adjusted."""
        names = OF_FIRST_CYCLE if cycle == 1 else OF_LATER_CYCLES
        chosen = [COVARIATES.index(name) for name in names]
        means, covariance, surfaces = self.known
        known = Known(means[chosen], covariance[np.ix_(chosen, chosen)], surfaces)
        return Covariates(self.values[..., chosen], known, tell_scatter=cycle == 1)


def covariates_of_pair(upper: np.ndarray, lower: np.ndarray, z2: float) -> np.ndarray:
    """Compute `COVARIATES` (3,) [m] of two walls (y, x) [m] whose JRC corresponds to a slope Z2."""
    summed = upper + lower
    depths = bearing_depths(summed, [0.01, 0.05])
    return np.array([*depths, bearing_excess(summed, 0.05)]) / z2


def measure_covariates(study: xr.Dataset, grid: Grid, surface: Surface) -> np.ndarray:
    """Compute covariates (case, realization, covariate) of all surfaces of a study from seeds."""
    values = np.full((*study.seed.shape, len(COVARIATES)), np.nan)
    for i, jrc in enumerate(study.jrc.values.tolist()):
        if np.isnan(jrc):  # scanned walls: the means of their covariates are unknown
            continue
        if i and jrc == study.jrc.values[i - 1] and (study.seed[i] == study.seed[i - 1]).all():
            values[i] = values[i - 1]
            continue
        seeds = [int(seed, 16) for seed in study.seed.values[i]]
        values[i] = _of_surfaces(seeds, jrc, grid, surface)
    return values


def known_covariates(surfaces: int, root_seed: int, grid: Grid, surface: Surface) -> Known:
    """Estimate the means of the covariates from separate surfaces that belong to no study."""
    seeds = [seed_of(root_seed, "covariates", number) for number in range(surfaces)]
    values = _of_surfaces(seeds, _REFERENCE_JRC, grid, surface)
    return Known(values.mean(axis=0), np.cov(values.T), surfaces)


def _of_surfaces(seeds: list[int], jrc: float, grid: Grid, surface: Surface) -> np.ndarray:
    z2 = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
    pairs = (walls_of_seed(seed, jrc, grid, surface) for seed in seeds)
    return np.array([covariates_of_pair(upper, lower, z2) for upper, lower in pairs])


def as_dataset(covariates: Covariates, study: xr.Dataset) -> xr.Dataset:
    """Convert covariates of a study to a dataset; `from_dataset` is the inverse."""
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
    """Read covariates from a dataset made by `as_dataset`."""
    means, covariance = dataset.known_mean.values, dataset.known_covariance.values
    known = Known(means, covariance, int(dataset.attrs["surfaces"]))
    return Covariates(dataset.covariate_value.values, known)
