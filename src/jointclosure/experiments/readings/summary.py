"""Scatter, elasticities and verdicts on claims in a reading."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from jointclosure.claims.findings import TARGET
from jointclosure.claims.statements import PROPERTIES, Elasticities
from jointclosure.claims.table import CLAIMS
from jointclosure.ensemble.cases import BASE
from jointclosure.experiments.readings.pools import Closures, Parameters, at_levels
from jointclosure.statistics.drawn_studies import jackknife_error
from jointclosure.statistics.standard_errors import Estimate, elasticity, variation_of
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, Interval, t_interval, verdict

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


def claims_judged(
    closures: Closures, parameters: Parameters, groups: int, confidence: float
) -> dict[str, str]:
    """Judge the claims on elasticities by all rocks closed in a reading.

    Returns a word of `jointclosure.statistics.verdicts` by claim. The standard error of the least
    margin of a claim in a rock is from a jackknife over groups of surfaces. A rock without
    variation of all properties is left out.
    """
    asked = [
        claim
        for claim in CLAIMS
        if claim.statement and claim.statement.of_elasticities
        if claim.variable == TARGET and not claim.negated
    ]
    intervals: dict[str, list[Interval]] = {claim.number: [] for claim in asked}
    for rock, of_rock in closures.items():
        if not set(PROPERTIES) <= set(parameters[rock]):
            continue
        varied = {name: parameters[rock][name] for name in PROPERTIES}
        numbers = of_rock.realization.values
        count = min(groups, numbers.size)
        whole, *parts = (
            _elasticities(of_rock[:, kept], varied)
            for kept in (numbers >= 0, *(numbers % count != group for group in range(count)))
        )
        for claim in asked:
            (cycle,) = claim.cycles
            value, *left_out = (
                float(claim.judged_by.least(values, cycle)) for values in (whole, *parts)
            )
            estimate = (value, jackknife_error(left_out))
            intervals[claim.number].append(t_interval(estimate, count, confidence))
    return {
        claim.number: verdict(
            claim.judged_by.least_interval(intervals[claim.number]),
            claim.judged_by.true_above(),
            claim.judged_by.alike,
        )
        if intervals[claim.number]
        else CANNOT_BE_TOLD
        for claim in asked
    }


def _elasticities(of_rock, varied: Mapping) -> Elasticities:
    return Elasticities(
        {
            (name, cycle): np.asarray(estimate.value)
            for i, cycle in enumerate(of_rock.cycle.values.tolist())
            for name, estimate in _estimates(of_rock, varied, i)
            if name != SCATTER
        }
    )
