"""What a study's dataset says of the response of a closure to the parameters of a rock."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.config.properties import PARAMETERS
from jointclosure.ensemble.aggregation import succeeded
from jointclosure.ensemble.cases import BASE
from jointclosure.ensemble.covariates import Covariates
from jointclosure.statistics.control_variates import fewest_surfaces
from jointclosure.statistics.drawn_studies import Pool, Sensitivity


class Response(NamedTuple):
    """A target (level, realization) [m] against one parameter of one rock, in SI.

    Realisations that failed at any level are left out at all levels. ``paired``: whether a
    realisation is the same surface at all levels. ``covariates`` (level, realization, covariate)
    are those by which means and deviations can be adjusted, or None.
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


class Levels(NamedTuple):
    """The levels (k,) of one parameter of one rock [SI], ascending, and the cases that have them.

    ``cases`` (k,) are the indices of the cases in the dataset; ``base`` the rock's own value.
    """

    values: np.ndarray
    cases: np.ndarray
    base: float


class RockSample(NamedTuple):
    """Some targets (targets, cases, n) [m] of all cases of one rock.

    Realisations that failed, or lack a target, in any of its cases are left out. ``names``
    (targets) are pairs of a variable and a cycle; ``levels`` has the parameters that are
    varied, their indices among these cases. ``paired`` as of `Response`.
    """

    rock: str
    names: tuple[tuple[str, int], ...]
    levels: dict[str, Levels]
    values: np.ndarray
    paired: bool

    def target(self, variable: str, cycle: int) -> int:
        """The place of a target among `names`."""
        return self.names.index((variable, cycle))


def rocks_of(study: xr.Dataset) -> list[str]:
    """The rocks of a dataset, in its order."""
    return list(dict.fromkeys(study.rock.values.tolist()))


def levels_of(study: xr.Dataset, rock: str) -> dict[str, Levels]:
    """The levels of every parameter of a rock that is varied, in the order of Table 3."""
    own = (study.rock == rock).values
    base_case = own & (study.parameter == BASE).values
    found = {}
    for parameter in PARAMETERS:
        varied = own & (study.parameter == parameter).values
        if varied.any():
            index = np.flatnonzero(base_case | varied)
            values = study[parameter].values[index]
            order = np.argsort(values)
            base = float(study[parameter].values[base_case][0])
            found[parameter] = Levels(values[order], index[order], base)
    return found


def same_surfaces(study: xr.Dataset, rock: str) -> bool:
    """Whether a realisation is of the same random numbers in all cases: its seeds say so."""
    seeds = study.seed.values[(study.rock == rock).values]
    return seeds.ndim == 2 and bool((seeds == seeds[0]).all())


def adjustment(covariates: Covariates | None, chosen: tuple, cycle: int) -> Covariates | None:
    """Covariates of some values of a cycle; None where there are none, or too few values.

    Parameters
    ----------
    covariates : Covariates or None
        Of a whole study.
    chosen : tuple
        Indices of cases and realisations, as for `numpy.ix_`.
    cycle : int
    """
    if covariates is None:
        return None
    own = covariates.of_cycle(cycle)
    values = own.values[chosen]
    enough = values.shape[-2] >= fewest_surfaces(values.shape[-1])
    return own._replace(values=values) if enough and np.isfinite(values).all() else None


def responses(
    study: xr.Dataset, target: str, covariates: Covariates | None = None
) -> Iterator[Response]:
    """All responses of a target (a variable over case, realization, cycle).

    ``covariates`` are those of the same study.
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
    """Targets of all cases of a rock, on the realisations that have them in all of these.

    Parameters
    ----------
    study : Dataset
    rock : str
    variables : dict
        Each over (case, realization, cycle) of the dataset.
    """
    cases = np.flatnonzero((study.rock == rock).values)
    names, values = [], []
    for name, variable in variables.items():
        part = variable.transpose("case", "realization", "cycle").values[cases]
        names += [(name, int(cycle)) for cycle in study.cycle.values]
        values += list(np.moveaxis(part, -1, 0))
    kept = succeeded(study).values[cases].all(axis=0)
    kept &= np.isfinite(values).all(axis=(0, 1))
    place = {int(case): i for i, case in enumerate(cases)}
    levels = {
        parameter: each._replace(cases=np.array([place[i] for i in each.cases.tolist()]))
        for parameter, each in levels_of(study, rock).items()
    }
    return RockSample(
        rock, tuple(names), levels, np.stack(values)[..., kept], same_surfaces(study, rock)
    )


def sensitivities(samples: list[RockSample]) -> dict[tuple[str, str], Sensitivity]:
    """Pools to draw studies from, by (rock, parameter); all targets of a case go together.

    Cases on the same surfaces have pools of one name, and so are resampled together.
    """
    found = {}
    for sample in samples:
        for parameter, levels in sample.levels.items():
            pools = tuple(
                Pool(sample.values[:, i], sample.rock if sample.paired else f"{sample.rock} {i}")
                for i in levels.cases
            )
            found[sample.rock, parameter] = Sensitivity(levels.values, levels.base, pools)
    return found
