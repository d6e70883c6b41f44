"""Covariates of pairs of walls, by which means and standard deviations of closures are adjusted.

Covariates are depths on the bearing-area curve of the summed heights of both walls, over the RMS
slope Z2 of the walls' JRC. Walls of another JRC are the same walls times a factor, by which Z2
changes too. Covariates therefore have the same distribution in all cases, and their means, which
are computed once from surfaces of one JRC, hold for all cases.
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
"""Names of all covariates: depths at which 1 % and 5 % of the cells are above, and the mean height
of the highest 5 % above the latter depth."""

_REFERENCE_JRC = 10.0
"""JRC of the surfaces from which the means are computed; any other JRC gives the same means."""


class Covariates(NamedTuple):
    """Covariates of the pairs of walls of a study, and what is known of their distribution."""

    values: np.ndarray  # (case, realization, covariate) [m per unit slope], NaN for scanned walls
    known: Known  # means and covariance of the covariates, from other surfaces
    tell_scatter: bool = True  # whether standard deviations of closures are adjusted too

    def of_cycle(self, cycle: int) -> "Covariates":
        """Return those covariates by which closures of a cycle are adjusted.

        Standard deviations are adjusted on the first cycle only.
        """
        names = OF_FIRST_CYCLE if cycle == 1 else OF_LATER_CYCLES
        chosen = [COVARIATES.index(name) for name in names]
        means, covariance, surfaces = self.known
        known = Known(means[chosen], covariance[np.ix_(chosen, chosen)], surfaces)
        return Covariates(self.values[..., chosen], known, tell_scatter=cycle == 1)


def covariates_of_pair(upper: np.ndarray, lower: np.ndarray, z2: float) -> np.ndarray:
    """Return the covariates (3,) [m per unit slope] of walls (y, x) [m], in the order `COVARIATES`.

    ``z2`` is the RMS slope of the walls' JRC.
    """
    summed = upper + lower
    depths = bearing_depths(summed, [0.01, 0.05])
    level = np.max(summed) - depths[1]
    excess = np.mean(summed[summed >= level] - level)
    return np.array([*depths, excess]) / z2


def measure_covariates(study: xr.Dataset, grid: JointGrid, surface: Synthesis) -> np.ndarray:
    """Return the covariates (case, realization, covariate) of all surfaces of a study.

    The surfaces are made again from their seeds. Covariates of scanned walls are NaN.
    """
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
    """Return means and covariance of the covariates, estimated from surfaces of no study.

    ``surfaces`` is their number; they are made from ``root_seed``.
    """
    seeds = [seed_of(root_seed, "covariates", number) for number in range(surfaces)]
    values = _of_surfaces(seeds, _REFERENCE_JRC, grid, surface)
    return Known(values.mean(axis=0), np.cov(values.T), surfaces)


def _of_surfaces(seeds: list[int], jrc: float, grid: JointGrid, surface: Synthesis) -> np.ndarray:
    z2 = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
    pairs = (walls_of_seed(seed, jrc, grid, surface) for seed in seeds)
    return np.array([covariates_of_pair(upper, lower, z2) for upper, lower in pairs])


def as_dataset(covariates: Covariates, study: xr.Dataset) -> xr.Dataset:
    """Return the covariates of a study's surfaces as a dataset, which `from_dataset` reads."""
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
    """Read the covariates of a study's surfaces from a file of `as_dataset`; None for the file "".

    Errors are as for `studies.frame.checked_files.read_checked`.
    """
    return from_dataset(read_checked(file, study.attrs["key"])) if file else None


def adjustment(covariates: Covariates | None, chosen: tuple, cycle: int) -> Covariates | None:
    """Return the covariates of a cycle for the ``chosen`` cases and realisations.

    ``chosen`` are indices of `numpy.ix_`. None without covariates, if there are too few surfaces,
    or if a covariate is not finite.
    """
    if covariates is None:
        return None
    of_cycle = covariates.of_cycle(cycle)
    values = of_cycle.values[chosen]
    enough = values.shape[-2] >= fewest_surfaces(values.shape[-1])
    return of_cycle._replace(values=values) if enough and np.isfinite(values).all() else None
