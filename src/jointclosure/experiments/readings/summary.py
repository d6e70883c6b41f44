"""Scatter, elasticities and verdicts on claims in a reading."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.findings import EXCESS, TARGET
from jointclosure.claims.statements import PROPERTIES
from jointclosure.claims.table import CLAIMS
from jointclosure.ensemble.cases import BASE
from jointclosure.experiments.readings.pools import (
    Closures,
    Parameters,
    at_levels,
    kept_surfaces,
    samples_of_surfaces,
)
from jointclosure.statistics.correlations import fit_quadratic
from jointclosure.statistics.drawn_studies import Design, jackknife_error
from jointclosure.statistics.standard_errors import Estimate, elasticity, variation_of
from jointclosure.statistics.verdicts import UNDECIDED, t_interval

SCATTER = "scatter"
"""Quantity S/mean at the base level; other quantities are elasticities to a parameter."""


def quantities(closures: Closures, parameters: Parameters) -> Iterator[dict]:
    """Generate rows of scatter and elasticities with standard errors, by closed rock and cycle."""
    for rock, of_rock in closures.items():
        for i, cycle in enumerate(of_rock.cycle.values.tolist()):
            for quantity, estimate in _estimates(of_rock, parameters[rock], i):
                row = {"rock": rock, "cycle": cycle, "quantity": quantity}
                yield row | {"value": estimate.value, "standard_error": estimate.standard_error}


def _estimates(of_rock, varied: Mapping, i: int) -> Iterator[tuple[str, Estimate]]:
    """Generate the quantities of a rock in cycle ``i``, counted from 0."""
    yield SCATTER, variation_of(of_rock[(of_rock.parameter == BASE).values].values[0, :, i])
    for name, (levels, base) in varied.items():
        samples = at_levels(of_rock, name, levels, base).values[:, :, i]
        yield name, elasticity(levels, samples, base, paired=True)


def over_rocks(rows: pd.DataFrame) -> pd.DataFrame:
    """Average `quantities` over rocks, by cycle and quantity; rocks have different surfaces."""
    grouped = rows.groupby(["cycle", "quantity"], sort=False)
    table = grouped.value.mean().to_frame()
    table["standard_error"] = grouped.standard_error.apply(
        lambda errors: float(np.sqrt(np.sum(errors**2)) / errors.size)
    )
    return table.reset_index()


class ClosedReading:
    """Mean closures of a rock in a reading, as `jointclosure.claims.statements.Closed`.

    ``critical`` is the smallest significant change of a mean, in standard deviations of a closure.
    """

    def __init__(self, of_rock: xr.DataArray, varied: Mapping, critical: float) -> None:
        self.base = of_rock[(of_rock.parameter == BASE).values][0]
        self.critical = critical
        self.fits = {
            (name, cycle): fit_quadratic(levels, means, base)
            for name, (levels, base) in varied.items()
            for cycle, means in zip(
                of_rock.cycle.values.tolist(),
                at_levels(of_rock, name, levels, base).mean("realization").values.T,
                strict=True,
            )
        }

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> float:
        """Return d ln(closure)/d ln(parameter) at the rock's value."""
        return self.fits[parameter, cycle].elasticity()

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[float]:
        """Return the elasticity itself in place of those between levels."""
        return [self.elasticity(parameter, cycle, variable)]

    def change(self, parameter: str, cycle: int, change: float) -> float:
        """Return the relative change of the mean closure with a change of the parameter [SI]."""
        return float(self.fits[parameter, cycle].relative_change(change))

    def share(self, variable: str, cycle: int) -> float:
        """Return the mean of a variable over the mean closure of the base case."""
        base = self.base.sel(cycle=cycle)
        return float(base[variable].mean() / base.mean())

    def significant(self, cycle: int) -> float:
        """Return the relative change of a mean that is significant with the scatter of the rock."""
        base = self.base.sel(cycle=cycle)
        return float(self.critical * base.std(ddof=1) / base.mean())


ASKED = tuple(
    claim
    for claim in CLAIMS
    if claim.statement and claim.variable == TARGET and claim.judged_by.reads != EXCESS
)
"""Claims on maximum closures and loops, which all readings have."""
Margins = dict[tuple[str, str], float]
"""Smallest margin of a claim in a rock, by number and rock."""


def least_margins(closures: Closures, parameters: Parameters, critical: float) -> Margins:
    """Return the smallest margins of claims, in rocks with variation of all properties."""
    margins = {}
    for rock, of_rock in closures.items():
        if set(PROPERTIES) <= set(parameters[rock]):
            varied = {name: parameters[rock][name] for name in PROPERTIES}
            model = ClosedReading(of_rock, varied, critical)
            for claim in ASKED:
                of_cycles = [claim.judged_by.least(model, cycle) for cycle in claim.cycles]
                margins[claim.number, rock] = float(np.min(of_cycles))
    return margins


def claims_judged(
    closures: Closures, parameters: Parameters, groups: int, design: Design
) -> dict[str, str]:
    """Judge the claims by all rocks closed in a reading.

    Returns a word of `jointclosure.statistics.verdicts` by claim. The standard error of the least
    margin of a claim in a rock is from a jackknife over groups of surfaces. A rock without
    variation of all properties is left out.
    """
    whole, *parts = (
        least_margins(kept_surfaces(closures, kept), parameters, design.critical_change)
        for kept in samples_of_surfaces(closures, groups)
    )
    estimates = {
        name: Estimate(value, jackknife_error([part[name] for part in parts]))
        for name, value in whole.items()
    }
    return verdicts_of(estimates, len(parts), 1.0 - design.significance)


def verdicts_of(
    margins: Mapping[tuple[str, str], Estimate], samples: int, confidence: float
) -> dict[str, str]:
    """Judge claims by the smallest margins (number, rock) and their errors from so many samples."""
    verdicts = {}
    for claim in ASKED:
        intervals = [
            t_interval(margin, samples, confidence)
            for (number, _), margin in margins.items()
            if number == claim.number
        ]
        verdicts[claim.number] = (
            claim.verdict(tuple(min(ends) for ends in zip(*intervals, strict=True)))
            if intervals
            else UNDECIDED
        )
    return verdicts
