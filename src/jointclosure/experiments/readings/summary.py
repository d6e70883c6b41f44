"""What a reading gives besides the likelihood: scatter, elasticities, and claims that stand."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from jointclosure.claims.findings import TARGET
from jointclosure.claims.statements import PROPERTIES, Elasticities
from jointclosure.claims.table import CLAIMS
from jointclosure.experiments.readings.pools import Closures, Parameters, levels_closed
from jointclosure.statistics.drawn_studies import jackknife_error
from jointclosure.statistics.standard_errors import Estimate, elasticity, variation_of
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, Interval, t_interval, verdict

SCATTER = "scatter"
"""Quantity of a row: S/mean at the base level; the others are a parameter's elasticity."""


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
    """Verdicts on the claims that elasticities decide, of all rocks closed in a reading.

    A word of `jointclosure.statistics.verdicts` by claim. The least margin of a claim in a rock
    has the standard error of a jackknife over groups of surfaces. A rock of which not all
    parameters are varied is left out.
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
            _elasticities(of_rock.isel(realization=np.flatnonzero(kept)), varied)
            for kept in (numbers >= 0, *(numbers % count != group for group in range(count)))
        )
        for claim in asked:
            (cycle,) = claim.cycles
            value, *left_out = (
                float(claim.judged_by.least(each, cycle)) for each in (whole, *parts)
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
