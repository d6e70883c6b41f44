"""Covariates of pairs of walls, by which means and scatters of closures are adjusted.

Covariates are depths on the bearing-area curve of the summed heights, over the RMS slope Z2 of the
walls' JRC. Walls of another JRC are the same walls scaled by Z2, so that these depths have the same
distribution in all cases, and their means, computed once from surfaces of one JRC, hold for all.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.statistics.control_variates import Known, fewest_surfaces
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls.bearing_area import bearing_depths
from jointclosure.walls.jrc import z2_of_jrc
from studies.frame.checked_files import read_checked
from studies.frame.settings import JointGrid, Synthesis, walls_of_seed

OF_FIRST_CYCLE, OF_LATER_CYCLES = ("depth_1", "depth_5"), ("excess_5",)
"""Covariates by which closures of the first and of later cycles are adjusted (docs/accuracy.md)."""

COVARIATES = (*OF_FIRST_CYCLE, *OF_LATER_CYCLES)

_REFERENCE_JRC = 10.0
"""JRC of the surfaces from which the means are computed; any other JRC gives the same means."""


class Covariates(NamedTuple):
    """Covariates (case, realization, covariate) [m per unit slope], and their known means.

    They are NaN for scanned walls. With ``tell_scatter``, standard deviations are adjusted too,
    which is less accurate on later cycles.
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
    """Compute `COVARIATES` (3,) [m per unit slope] of walls (y, x) [m]; ``z2`` is of their JRC."""
    summed = upper + lower
    depths = bearing_depths(summed, [0.01, 0.05])
    level = np.max(summed) - depths[1]
    excess = np.mean(summed[summed >= level] - level)
    return np.array([*depths, excess]) / z2


def measure_covariates(study: xr.Dataset, grid: JointGrid, surface: Synthesis) -> np.ndarray:
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


def known_covariates(surfaces: int, root_seed: int, grid: JointGrid, surface: Synthesis) -> Known:
    """Estimate means and covariance of the covariates from surfaces that belong to no study."""
    seeds = [seed_of(root_seed, "covariates", number) for number in range(surfaces)]
    values = _of_surfaces(seeds, _REFERENCE_JRC, grid, surface)
    return Known(values.mean(axis=0), np.cov(values.T), surfaces)


def _of_surfaces(seeds: list[int], jrc: float, grid: JointGrid, surface: Synthesis) -> np.ndarray:
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
        attrs={
            "title": "covariates of simulated surfaces",
            "surfaces": known.surfaces,
            "key": study.attrs["key"],
        },
    )


def from_dataset(dataset: xr.Dataset) -> Covariates:
    """Read covariates from a dataset made by `as_dataset`."""
    means = dataset.known_mean.values
    covariance = dataset.known_covariance.values
    known = Known(means, covariance, int(dataset.attrs["surfaces"]))
    return Covariates(dataset.covariate_value.values, known)


def read_covariates(file: str, study: xr.Dataset) -> Covariates | None:
    """Read the covariates of a study's surfaces in a file of `as_dataset`; None without a file.

    Errors are as for `studies.frame.checked_files.read_checked`.
    """
    return from_dataset(read_checked(file, study.attrs["key"])) if file else None


def adjustment(covariates: Covariates | None, chosen: tuple, cycle: int) -> Covariates | None:
    """Select covariates of a cycle at ``chosen`` cases and realisations; None if too few."""
    if covariates is None:
        return None
    of_cycle = covariates.of_cycle(cycle)
    values = of_cycle.values[chosen]
    enough = values.shape[-2] >= fewest_surfaces(values.shape[-1])
    return of_cycle._replace(values=values) if enough and np.isfinite(values).all() else None
