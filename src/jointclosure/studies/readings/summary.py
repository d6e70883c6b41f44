"""What a reading gives besides the likelihood: scatter, elasticities, and claims that stand."""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.statistics.drawn_studies import jackknife_error
from jointclosure.statistics.standard_errors import Estimate, elasticity, variation_of
from jointclosure.statistics.verdicts import t_interval, verdict, verdict_on_all
from jointclosure.studies.readings.pools import Closures, Parameters, levels_closed

SCATTER = "scatter"
"""Quantity of a row: S/mean at the base level; the others are a parameter's elasticity."""


class Response(NamedTuple):
    """What claims are judged by, of one rock: elasticities by parameter (cycle,), S/mean and
    mean closure (cycle,)."""

    elasticities: Mapping[str, np.ndarray]
    scatter: np.ndarray
    means: np.ndarray

    def sensitivity(self, parameter: str, cycle: int) -> float:
        """|elasticity|, which ranks the parameters as their percent intervals do.

        These are near 100 t sqrt(2/n) S/mean over it, and S/mean is that of the rock and cycle.
        """
        return float(abs(self.elasticities[parameter][cycle - 1]))

    def others(self, parameters: tuple[str, ...], cycle: int) -> float:
        """The largest sensitivity to a parameter that is not among those."""
        return max(self.sensitivity(p, cycle) for p in self.elasticities if p not in parameters)


def _over_scatter(response: Response, parameter: str, cycle: int) -> float:
    return response.sensitivity(parameter, cycle) / float(response.scatter[cycle - 1])


NU, E, STRENGTH, JRC = "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc"
CLAIMS: dict[str, tuple[str, Callable[[Response], float]]] = {
    "1a, cycle 1": (
        "Poisson's ratio matters least on cycle 1",
        lambda r: (
            min(r.sensitivity(p, 1) for p in r.elasticities if p != NU) - r.sensitivity(NU, 1)
        ),
    ),
    "1a, cycle 2": (
        "Poisson's ratio matters least on cycle 2",
        lambda r: (
            min(r.sensitivity(p, 2) for p in r.elasticities if p != NU) - r.sensitivity(NU, 2)
        ),
    ),
    "2a": (
        "Young's modulus matters most on cycle 2",
        lambda r: r.sensitivity(E, 2) - r.others((E,), 2),
    ),
    "2b": (
        "Young's modulus matters most on cycle 1",
        lambda r: r.sensitivity(E, 1) - r.others((E,), 1),
    ),
    "3": (
        "Compressive strength is next on cycle 2",
        lambda r: min(
            r.sensitivity(E, 2) - r.sensitivity(STRENGTH, 2),
            r.sensitivity(STRENGTH, 2) - r.others((E, STRENGTH), 2),
        ),
    ),
    "4": (
        "Sensitivity to JRC falls from cycle 1 to cycle 2",
        lambda r: _over_scatter(r, JRC, 1) - _over_scatter(r, JRC, 2),
    ),
    "5a": ("Cycle-2 closure rises when E falls", lambda r: -float(r.elasticities[E][1])),
    "5b": (
        "Cycle-2 closure rises when sigma_c rises",
        lambda r: float(r.elasticities[STRENGTH][1]),
    ),
    "5c": ("Cycle-1 closure falls when JRC falls", lambda r: float(r.elasticities[JRC][0])),
    "6b": (
        "The second cycle is stiffer than the first",
        lambda r: 1.0 - float(r.means[1] / r.means[0]),
    ),
}
"""The paper's claims on sensitivity, each as a number that is positive where it is true."""
_CLAIMED = {NU, E, STRENGTH, JRC}
"""Parameters that the claims are about."""


def quantities(closures: Closures, parameters: Parameters) -> Iterator[dict]:
    """Scatter and elasticities with standard errors, of every rock closed and cycle, as rows."""
    for rock, of_rock in closures.items():
        for i, cycle in enumerate(of_rock.cycle.values.tolist()):
            for quantity, estimate in _estimates(of_rock, parameters[rock], i):
                row = {"rock": rock, "cycle": cycle, "quantity": quantity}
                yield row | {"value": estimate.value, "standard_error": estimate.standard_error}


def _estimates(of_rock, varied: Mapping, i: int) -> Iterator[tuple[str, Estimate]]:
    at_base = next(
        values[list(levels).index(base)]
        for levels, base, values in (
            (levels, base, levels_closed(of_rock, name, levels, base))
            for name, (levels, base) in varied.items()
        )
    )
    yield SCATTER, variation_of(at_base[:, i])
    for name, (levels, base) in varied.items():
        samples = levels_closed(of_rock, name, levels, base)[:, :, i]
        yield name, elasticity(levels, samples, base, paired=True)


def over_rocks(rows: pd.DataFrame) -> pd.DataFrame:
    """Means over rocks of `quantities`, by cycle and quantity; rocks have surfaces of their own."""
    grouped = rows.groupby(["cycle", "quantity"], sort=False)
    table = grouped.value.mean().to_frame()
    table["standard_error"] = grouped.standard_error.apply(
        lambda errors: float(np.sqrt(np.sum(errors**2)) / errors.size)
    )
    return table.reset_index()


def claims_judged(
    closures: Closures, parameters: Parameters, groups: int, confidence: float
) -> dict[str, str]:
    """Which claims stand in a reading, of all rocks closed: a word of
    `jointclosure.statistics.verdicts` by claim.

    A claim's number has the standard error of a jackknife over groups of surfaces. A rock of
    which not all parameters are varied is left out; parameters besides count for none.
    """
    parameters = {
        rock: {name: each for name, each in varied.items() if name in _CLAIMED}
        for rock, varied in parameters.items()
    }
    closures = {rock: each for rock, each in closures.items() if set(parameters[rock]) == _CLAIMED}
    verdicts: dict[str, list[str]] = {number: [] for number in CLAIMS}
    for rock, of_rock in closures.items():
        numbers = of_rock.realization.values
        count = min(groups, numbers.size)
        whole = _response(of_rock, parameters[rock])
        parts = [
            _response(
                of_rock.isel(realization=np.flatnonzero(numbers % count != g)), parameters[rock]
            )
            for g in range(count)
        ]
        for number, (_, judge) in CLAIMS.items():
            error = jackknife_error([judge(part) for part in parts])
            interval = t_interval((judge(whole), error), count, confidence)
            verdicts[number].append(verdict(interval, (0.0, np.inf)))
    return {number: verdict_on_all(each) for number, each in verdicts.items()}


def _response(of_rock, varied: Mapping) -> Response:
    per_cycle = [dict(_estimates(of_rock, varied, i)) for i in range(of_rock.sizes["cycle"])]
    return Response(
        {name: np.array([each[name].value for each in per_cycle]) for name in varied},
        np.array([each[SCATTER].value for each in per_cycle]),
        of_rock.isel(case=np.flatnonzero(np.isnan(of_rock.value.values))).values.mean(axis=(0, 1)),
    )
