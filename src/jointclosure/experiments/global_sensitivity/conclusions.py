"""Which of the paper's conclusions hold, whatever is chosen of what the paper leaves open."""

import functools
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.claims.statements import Elasticities, Statement
from jointclosure.claims.table import statements_of_elasticities
from jointclosure.experiments.global_sensitivity.design import Sampling, is_positive
from jointclosure.experiments.global_sensitivity.table import (
    GROUPS,
    choices_drawn,
    elasticities_at,
    first_functions,
    has_elasticities,
    jackknife_error,
    responses_of,
)
from jointclosure.experiments.global_sensitivity.table import Elasticities as FittedElasticities
from jointclosure.inputs import InputError
from jointclosure.statistics.verdicts import frequency_of, t_interval

PROPERTIES = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
"""Properties that the conclusions compare; others may vary, too."""
NAMES = ("closure", "closure_net")
"""Responses that conclusions are about."""
COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", "share", "share_error",
    "share_low", "share_high", "rows", "rows_true",
)  # fmt: skip
MARGIN_COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", "input", "title", "share", "share_error",
)  # fmt: skip


class _Margins(NamedTuple):
    """Margins at drawn choices (n,), without each group (groups, n), and of single rows (N,)."""

    drawn: np.ndarray
    left_out: np.ndarray
    single: np.ndarray
    rows: np.ndarray


def conclusion_tables(
    sampling: Sampling, keys: Mapping, closed
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """For what share of the open choices each conclusion holds, and what its margin goes with.

    Returns
    -------
    conclusions : DataFrame
        ``number`` and ``conclusion`` of a statement of `jointclosure.claims.statements`,
        ``response`` (closure, with and without bulk indentation), ``cycle``, ``rock`` ("all": in
        every rock at once), ``share`` of the drawn choices at which the fitted elasticities have
        it by more than the tolerance, ``share_error`` (jackknife over rows, the same rows left
        out in all rocks), ``share_low`` and ``share_high`` (95 %: by that error, and never closer
        than as many single rows could tell), ``rows`` and at how many of them it is true of the
        row's own changes, noise and all (``rows_true``).
    margins : DataFrame
        Of each rock and ``input``: the ``share`` of the variance of the conclusion's margin over
        the drawn choices that goes with the input's first function, with its jackknife error.

    Without statements on properties that do not vary, and without responses that are not
    positive everywhere.

    Raises
    ------
    InputError
        The joints of a sampled rock are missing.
    """
    found = _elasticities(sampling, keys, closed)
    shares: list[dict] = []
    margins: list[dict] = []
    for name in NAMES:
        for cycle in (1, 2):
            for statement in statements_of_elasticities():
                of_rocks = _of_rocks(sampling, found, statement, name, cycle)
                about: dict = {"number": statement.number, "conclusion": statement.text}
                about |= {"response": name, "cycle": cycle}
                shares += [about | row for row in _shares(of_rocks, statement.above)]
                margins += [about | row for row in _variances(sampling, of_rocks)]
    return (
        pd.DataFrame(shares, columns=list(COLUMNS)),
        pd.DataFrame(margins, columns=list(MARGIN_COLUMNS)),
    )


def _elasticities(sampling: Sampling, keys: Mapping, closed) -> dict[tuple, FittedElasticities]:
    """By rock, response and cycle; none where a rock has none to any property."""
    missing = sorted(set(sampling.rocks) - set(closed))
    if missing:
        raise InputError(f"the joints of {', '.join(missing)} are missing")
    for rock in sampling.rocks:
        if not any(one.property and is_positive(one, keys, rock) for one in sampling.inputs):
            return {}
    at = choices_drawn(sampling)
    return {
        (each.rock, each.name, each.cycle): elasticities_at(sampling, keys, each, at)
        for each in responses_of(sampling, closed)
        if each.name in NAMES and has_elasticities(each)
    }


def _of_rocks(
    sampling: Sampling, found: dict[tuple, FittedElasticities], statement: Statement, name: str,
    cycle: int,
) -> dict[str, _Margins]:  # fmt: skip
    """Margins of each rock; none where a rock lacks an elasticity that the statement is about."""
    properties = {one.name: one.property for one in sampling.inputs}
    margins = {}
    for rock in sampling.rocks:
        of_cycles = {
            c: own
            for c in statement.cycles(cycle)
            if (own := found.get((rock, name, c))) is not None
            and set(statement.parameters) <= {properties[one] for one in own.inputs}
        }
        if len(of_cycles) < len(statement.cycles(cycle)):
            return {}
        rows = functools.reduce(np.intersect1d, [own.rows for own in of_cycles.values()])

        def least(part, of_cycles=of_cycles) -> np.ndarray:
            by_cycle = {
                (str(properties[one]), c): values
                for c, own in of_cycles.items()
                for one, values in zip(own.inputs, part(own), strict=True)
            }
            return statement.least(Elasticities(by_cycle), cycle)

        margins[rock] = _Margins(
            least(lambda own: own.drawn),
            least(lambda own: own.left_out),
            least(lambda own, rows=rows: own.single[:, np.isin(own.rows, rows)]),
            rows,
        )
    return margins


def _shares(of_rocks: dict[str, _Margins], above: float) -> Iterator[dict]:
    """Of each rock, and of all at once; true where margins are above a bound."""
    if not of_rocks:
        return
    for rock, own in of_rocks.items():
        yield {"rock": rock} | _share(own.drawn > above, own.left_out > above, own.single > above)
    together = of_rocks.values()
    rows = set.intersection(*(set(own.rows.tolist()) for own in together))
    single = [own.single[np.isin(own.rows, list(rows))] > above for own in together]
    yield {"rock": "all"} | _share(
        np.all([own.drawn > above for own in together], axis=0),
        np.all([own.left_out > above for own in together], axis=0),
        np.all(single, axis=0),
    )


def _share(drawn: np.ndarray, left_out: np.ndarray, single: np.ndarray) -> dict:
    share, error = float(drawn.mean()), float(jackknife_error(left_out.mean(axis=1)))
    interval = t_interval((share, error), GROUPS)
    at_best = frequency_of(round(share * single.size), single.size)
    return {
        "share": share,
        "share_error": error,
        "share_low": max(0.0, min(interval.low, at_best.low)),
        "share_high": min(1.0, max(interval.high, at_best.high)),
        "rows": single.size,
        "rows_true": int(single.sum()),
    }


def _variances(sampling: Sampling, of_rocks: dict[str, _Margins]) -> Iterator[dict]:
    """Shares of a margin's variance over the choices, of each rock and input."""
    functions = first_functions(choices_drawn(sampling), sampling.values)
    matrix = np.column_stack([np.ones(len(functions)), functions])
    for rock, own in of_rocks.items():
        margins = np.vstack([own.drawn, own.left_out])
        slopes = np.linalg.lstsq(matrix, margins.T, rcond=None)[0][1:]
        variances = margins.var(axis=1)
        parts = functions.var(axis=0)[:, None] * slopes**2
        shares = np.divide(parts, variances, out=np.full_like(parts, np.nan), where=variances > 0)
        errors = jackknife_error(shares[:, 1:].T)
        for place, one in enumerate(sampling.inputs):
            row = {"rock": rock, "input": one.name, "title": one.title}
            yield row | {"share": shares[place, 0], "share_error": errors[place]}
