"""Responses of closures to the parameters of rocks, and pools from which repetitions are drawn."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.indifference import (
    IndifferenceInterval,
    PairedInterval,
    indifference_interval,
    paired_indifference_interval,
)
from jointclosure.statistics.repetitions import Pool, Sensitivity
from studies.frame.joint_tables import succeeded
from studies.frame.settings import BASE
from studies.paper.covariates import Covariates, adjustment


def percent_of_value(length, base: float):
    """Return a length, a number or array, in percent of the rock's value ``base`` (same unit).

    It is NaN if the value is 0, as that of Poisson's ratio may be.
    """
    return 100.0 * length / abs(base) if base else np.nan * length


class Response(NamedTuple):
    """Response of a closure, in one rock and cycle, to a parameter."""

    rock: str
    parameter: str
    cycle: int
    base: float  # the rock's value of the parameter [SI]
    levels: np.ndarray  # values (k,) of the parameter [SI], ascending
    samples: np.ndarray  # closures (k, realization) [m]
    paired: bool  # whether a realisation has the same surfaces at all levels
    covariates: Covariates | None = None  # of the samples

    @property
    def means(self) -> np.ndarray:
        """Mean closures (k,) [m] at the levels."""
        return self.samples.mean(axis=1)

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations (k,) [m] of the closures at the levels."""
        return self.samples.std(axis=1, ddof=1)

    def interval(
        self, significance: float, surfaces: int | None = None
    ) -> PairedInterval | IndifferenceInterval:
        """Return the indifference interval [SI] by the paired test if samples are paired.

        Otherwise it is that by the unpaired test. ``surfaces`` is the number of surfaces in the
        test, by default that of the samples.
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
        """Return a length [SI] in percent of the rock's value; NaN if the value is 0."""
        return percent_of_value(length, self.base)


class Levels(NamedTuple):
    """Levels of a parameter of a rock, the rock's own value among them."""

    values: np.ndarray  # (k,) [SI], ascending
    cases: np.ndarray  # places (k,) of the cases with these values
    base: float  # the rock's own value [SI]


class RockSample(NamedTuple):
    """Closures of all cases of a rock, for the realisations that succeeded in every case.

    A target is a variable in one cycle.
    """

    rock: str
    names: tuple[tuple[str, int], ...]  # variable and cycle of each target
    levels: dict[str, Levels]  # by varied parameter; places of cases are those in ``values``
    values: np.ndarray  # (targets, cases, realisations) [m]
    paired: bool  # whether a realisation has the same surfaces in all cases

    def target(self, variable: str, cycle: int) -> int:
        """Return the index of a target, a variable in a cycle, in `names`."""
        return self.names.index((variable, cycle))


def rocks_of(study: xr.Dataset) -> list[str]:
    """Return the rocks of a dataset, in its order."""
    return list(dict.fromkeys(study.rock.values.tolist()))


def levels_of(study: xr.Dataset, rock: str) -> dict[str, Levels]:
    """Return the levels of every varied parameter of a rock, by parameter in Table 3's order."""
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


def responses(
    study: xr.Dataset, target: str, covariates: Covariates | None = None
) -> Iterator[Response]:
    """Generate the responses of a variable of a study, for each rock, parameter and cycle.

    ``target`` is its name; it is over case, realization and cycle. Realisations that failed at a
    level are left out.
    """
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
    """Return the ``variables`` (case, realization, cycle) of all cases of a rock.

    Realisations are left out that failed in a case, or have a value that is not finite.
    """
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
    """Return the pools from which repetitions of a study are drawn, by rock and parameter.

    Pools of cases with the same surfaces have the same name.
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
