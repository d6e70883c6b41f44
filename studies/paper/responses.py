"""Responses of closures to the parameters of a rock, and covariates of pairs of walls.

Covariates are depths on the bearing-area curve of the summed heights, over the RMS slope Z2 of the
walls' JRC. Walls of another JRC are the same walls scaled by Z2, so that these depths have the same
distribution in all cases, and their means, computed once from surfaces of one JRC, hold for all.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.control_variates import Known, fewest_surfaces
from jointclosure.statistics.indifference import (
    IndifferenceInterval,
    PairedInterval,
    indifference_interval,
    paired_indifference_interval,
)
from jointclosure.statistics.randomness import seed_of
from jointclosure.statistics.repetitions import Pool, Sensitivity
from jointclosure.walls.bearing_area import bearing_depths
from jointclosure.walls.jrc import z2_of_jrc
from studies.frame.checked_files import read_checked
from studies.frame.settings import BASE, JointGrid, Synthesis, walls_of_seed
from studies.frame.tables import succeeded

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


def percent_of(length, base: float):
    """Return a length in percent of a rock's value; NaN where that is 0, as Poisson's ratio may."""
    return 100.0 * length / abs(base) if base else np.nan * length


class Response(NamedTuple):
    """Closures ``samples`` (level, realization) [m] of a rock and cycle over a parameter.

    ``base`` is the rock's value and ``levels`` are the values of the parameter [SI]. The samples
    are ``paired`` if a realisation has the same surfaces at all levels.
    """

    rock: str
    parameter: str
    cycle: int
    base: float
    levels: np.ndarray
    samples: np.ndarray
    paired: bool
    covariates: Covariates | None = None

    @property
    def means(self) -> np.ndarray:
        return self.samples.mean(axis=1)

    @property
    def deviations(self) -> np.ndarray:
        return self.samples.std(axis=1, ddof=1)

    def interval(
        self, significance: float, surfaces: int | None = None
    ) -> PairedInterval | IndifferenceInterval:
        """Compute the indifference interval [SI] by the paired or the unpaired test.

        ``surfaces`` is the number of surfaces of the test, by default that of the samples.
        """
        about = (significance, self.base)
        levels = self.levels
        base = self.base
        if self.paired:
            samples = np.ascontiguousarray(self.samples)  # one order of sums, whatever was selected
            return paired_indifference_interval(levels, samples, *about, surfaces=surfaces)
        n = surfaces or self.samples.shape[1]
        return indifference_interval(levels, self.means, self.deviations, n, significance, base)

    def percent(self, length):
        """Return a length [SI] in percent of the rock's value; NaN where that is 0."""
        return percent_of(length, self.base)


class Levels(NamedTuple):
    """Ascending levels (k,) [SI] of a parameter, places of their cases, and the rock's value."""

    values: np.ndarray
    cases: np.ndarray
    base: float


class RockSample(NamedTuple):
    """Values (targets, cases, n) [m] of a rock, of the realisations that have all of them.

    ``names`` are the variable and cycle of each target, ``levels`` those of each varied parameter.
    """

    rock: str
    names: tuple[tuple[str, int], ...]
    levels: dict[str, Levels]
    values: np.ndarray
    paired: bool

    def target(self, variable: str, cycle: int) -> int:
        """Return the index of a target in `names`."""
        return self.names.index((variable, cycle))


def rocks_of(study: xr.Dataset) -> list[str]:
    """Return the rocks of a dataset, in its order."""
    return list(dict.fromkeys(study.rock.values.tolist()))


def levels_of(study: xr.Dataset, rock: str) -> dict[str, Levels]:
    """Return the levels of every varied parameter of a rock, in the order of Table 3."""
    of_rock = (study.rock == rock).values
    base_case = of_rock & (study.parameter == BASE).values
    levels = {}
    for parameter in PROPERTIES:
        varied = of_rock & (study.parameter == parameter).values
        if varied.any():
            index = np.flatnonzero(base_case | varied)
            values = study[parameter].values[index]
            order = np.argsort(values)
            base = float(study[parameter].values[base_case][0])
            levels[parameter] = Levels(values[order], index[order], base)
    return levels


def same_surfaces(study: xr.Dataset, rock: str) -> bool:
    """Return whether a realisation has the same seed, thus the same surface, in all cases."""
    seeds = study.seed.values[(study.rock == rock).values]
    return seeds.ndim == 2 and bool((seeds == seeds[0]).all())


def adjustment(covariates: Covariates | None, chosen: tuple, cycle: int) -> Covariates | None:
    """Select covariates of a cycle at ``chosen`` cases and realisations; None if too few."""
    if covariates is None:
        return None
    of_cycle = covariates.of_cycle(cycle)
    values = of_cycle.values[chosen]
    enough = values.shape[-2] >= fewest_surfaces(values.shape[-1])
    return of_cycle._replace(values=values) if enough and np.isfinite(values).all() else None


def responses(
    study: xr.Dataset, target: str, covariates: Covariates | None = None
) -> Iterator[Response]:
    """Generate all responses of a target (over case, realization, cycle) of a study."""
    good = succeeded(study).values
    for rock in rocks_of(study):
        paired = same_surfaces(study, rock)
        for parameter, levels in levels_of(study, rock).items():
            kept = good[levels.cases].all(axis=0)
            for cycle in study.cycle.values.tolist():
                chosen = np.ix_(levels.cases, np.flatnonzero(kept))
                samples = study[target].sel(cycle=cycle).values[levels.cases][:, kept]
                yield Response(
                    rock, parameter, int(cycle), levels.base, levels.values, samples, paired,
                    adjustment(covariates, chosen, int(cycle)),
                )  # fmt: skip


def rock_sample(study: xr.Dataset, rock: str, variables: dict[str, xr.DataArray]) -> RockSample:
    """Return variables of all cases of a rock, of realisations that succeeded in every case."""
    cases = np.flatnonzero((study.rock == rock).values)
    names = []
    values = []
    for name, variable in variables.items():
        part = variable.transpose("case", "realization", "cycle").values[cases]
        names += [(name, int(cycle)) for cycle in study.cycle.values]
        values += list(np.moveaxis(part, -1, 0))
    kept = succeeded(study).values[cases].all(axis=0)
    kept &= np.isfinite(values).all(axis=(0, 1))
    place = {int(case): i for i, case in enumerate(cases)}
    levels = {
        parameter: levels._replace(cases=np.array([place[i] for i in levels.cases.tolist()]))
        for parameter, levels in levels_of(study, rock).items()
    }
    return RockSample(
        rock, tuple(names), levels, np.stack(values)[..., kept], same_surfaces(study, rock)
    )


def sensitivities(samples: list[RockSample]) -> dict[tuple[str, str], Sensitivity]:
    """Return the pools from which studies are drawn, by rock and parameter.

    Pools of cases on the same surfaces have the same name.
    """
    by_parameter = {}
    for sample in samples:
        for parameter, levels in sample.levels.items():
            pools = tuple(
                Pool(sample.values[:, i], sample.rock if sample.paired else f"{sample.rock} {i}")
                for i in levels.cases
            )
            by_parameter[sample.rock, parameter] = Sensitivity(levels.values, levels.base, pools)
    return by_parameter
