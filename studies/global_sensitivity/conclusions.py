"""Share of the paper's open choices for which each of its conclusions holds."""

import functools
import itertools
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.standard_errors import jackknife_error
from jointclosure.statistics.verdicts import frequency, t_interval
from studies.global_sensitivity.design import Sampling, is_positive
from studies.global_sensitivity.table import (
    GROUPS,
    choices_drawn,
    elasticities_at,
    first_functions,
    has_elasticities,
    responses_of,
)
from studies.global_sensitivity.table import Elasticities as FittedElasticities
from studies.paper.claims import HYSTERESIS, Elasticities, Statement, statements_of_elasticities
from studies.paper.conclusions import SHARES

NAMES = ("max_closure", "max_closure_net")
"""Responses for which conclusions are judged."""
COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", *SHARES, "rows", "rows_true",
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
    """Compute shares of choices for which conclusions hold, and the inputs behind their margins.

    ``rock`` "all" is in every rock at once; ``share_error`` is by jackknife over rows, the 95 %
    interval at least as wide as for a count of single rows; ``rows_true`` are those for whose
    changes, noise included, it holds. The second table: ``share`` of the margin's variance due to
    each input.
    """
    fits = _elasticities(sampling, keys, closed)
    shares: list[dict] = []
    margins: list[dict] = []
    bases = {rock: _bases(sampling, keys, rock) for rock in sampling.rocks}
    for name, cycle, statement in itertools.product(NAMES, (1, 2), statements_of_elasticities()):
        of_rocks = _of_rocks(sampling, fits, bases, statement, name, cycle)
        about = _about(statement, name, cycle)
        shares += [about | row for row in _shares(of_rocks, statement.true_above())]
        margins += [about | row for row in _variances(sampling, of_rocks)]
    for cycle in (1, 2):
        about = _about(HYSTERESIS, NAMES[0], cycle)
        shares += [about | row for row in _loop_shares(closed, cycle)]
    return (
        pd.DataFrame(shares, columns=list(COLUMNS)),
        pd.DataFrame(margins, columns=list(MARGIN_COLUMNS)),
    )


def _elasticities(sampling: Sampling, keys: Mapping, closed) -> dict[tuple, FittedElasticities]:
    """Return elasticities by rock, response and cycle; none if a rock has none."""
    missing = sorted(set(sampling.rocks) - set(closed))
    if missing:
        raise InputError(f"the joints of {', '.join(missing)} are missing")
    for rock in sampling.rocks:
        if not any(one.property and is_positive(one, keys, rock) for one in sampling.inputs):
            return {}
    at = choices_drawn(sampling)
    return {
        (one.rock, one.name, one.cycle): elasticities_at(sampling, keys, one, at)
        for one in responses_of(sampling, closed)
        if one.name in NAMES and has_elasticities(one)
    }


def _about(statement: Statement, name: str, cycle: int) -> dict:
    about = {"number": statement.number, "conclusion": statement.text}
    return about | {"response": name, "cycle": cycle}


def _bases(sampling: Sampling, keys: Mapping, rock: str) -> dict[str, float]:
    """Return the rock's values of the properties that vary [SI]."""
    return {
        one.property: PROPERTIES[one.property].size * keys["rocks"][rock][one.key[-1]]
        for one in sampling.inputs
        if one.property
    }


def _loop_shares(closed: Mapping[str, xr.Dataset], cycle: int) -> Iterator[dict]:
    """Generate shares of rows whose first point has a loop, in single rocks and in all at once."""
    true = {}
    for rock, of_rock in closed.items():
        first = of_rock.sortby("row").isel(point=0).sel(cycle=cycle).mean("surface", skipna=False)
        held = first.loop / first.max_closure > HYSTERESIS.above
        true[rock] = held.where(np.isfinite(first.max_closure))
    everywhere = xr.concat(true.values(), "rock", join="inner").min("rock", skipna=False)
    for rock, of_rock in (true | {"all": everywhere}).items():
        known = of_rock.dropna("row")
        if known.size:
            count = int(known.sum())
            share = frequency(count, known.size)
            row = dict(zip(SHARES, share, strict=True))
            yield {"rock": rock} | row | {"rows": known.size, "rows_true": count}


def _of_rocks(
    sampling: Sampling, fits: dict[tuple, FittedElasticities], bases: dict, statement: Statement,
    name: str, cycle: int,
) -> dict[str, _Margins]:  # fmt: skip
    """Return margins by rock; none if a rock lacks an elasticity of the statement."""
    properties = {one.name: one.property for one in sampling.inputs}
    margins = {}
    for rock in sampling.rocks:
        of_cycles = {
            c: fit
            for c in statement.cycles(cycle)
            if (fit := fits.get((rock, name, c))) is not None
            and set(statement.parameters) <= {properties[one] for one in fit.inputs}
        }
        if len(of_cycles) < len(statement.cycles(cycle)):
            return {}
        rows = functools.reduce(np.intersect1d, [fit.rows for fit in of_cycles.values()])

        def least(part, of_cycles=of_cycles, rock=rock) -> np.ndarray:
            by_cycle = {
                (str(properties[one]), c): values
                for c, fit in of_cycles.items()
                for one, values in zip(fit.inputs, part(fit), strict=True)
            }
            return statement.least(Elasticities(by_cycle, bases[rock]), cycle)

        margins[rock] = _Margins(
            least(lambda fit: fit.drawn),
            least(lambda fit: fit.left_out),
            least(lambda fit, rows=rows: fit.single[:, np.isin(fit.rows, rows)]),
            rows,
        )
    return margins


def _shares(of_rocks: dict[str, _Margins], above: float) -> Iterator[dict]:
    """Generate the shares of margins above a bound, in single rocks and in all at once."""
    if not of_rocks:
        return
    for rock, margin in of_rocks.items():
        parts = (margin.drawn, margin.left_out, margin.single)
        yield {"rock": rock} | _share(*(part > above for part in parts))
    together = of_rocks.values()
    rows = set.intersection(*(set(margin.rows.tolist()) for margin in together))
    single = [margin.single[np.isin(margin.rows, list(rows))] > above for margin in together]
    yield {"rock": "all"} | _share(
        np.all([margin.drawn > above for margin in together], axis=0),
        np.all([margin.left_out > above for margin in together], axis=0),
        np.all(single, axis=0),
    )


def _share(drawn: np.ndarray, left_out: np.ndarray, single: np.ndarray) -> dict:
    share, error = float(drawn.mean()), float(jackknife_error(left_out.mean(axis=1)))
    interval = t_interval((share, error), GROUPS)
    at_best = frequency(round(share * single.size), single.size)
    return {
        "share": share,
        "share_error": error,
        "share_low": max(0.0, min(interval.low, at_best.low)),
        "share_high": min(1.0, max(interval.high, at_best.high)),
        "rows": single.size,
        "rows_true": int(single.sum()),
    }


def _variances(sampling: Sampling, of_rocks: dict[str, _Margins]) -> Iterator[dict]:
    """Generate shares of a margin's variance over the choices, by rock and input."""
    functions = first_functions(choices_drawn(sampling), sampling.values)
    matrix = np.column_stack([np.ones(len(functions)), functions])
    for rock, margin in of_rocks.items():
        margins = np.vstack([margin.drawn, margin.left_out])
        slopes = np.linalg.lstsq(matrix, margins.T, rcond=None)[0][1:]
        variances = margins.var(axis=1)
        parts = functions.var(axis=0)[:, None] * slopes**2
        shares = np.divide(parts, variances, out=np.full_like(parts, np.nan), where=variances > 0)
        errors = jackknife_error(shares[:, 1:].T)
        for place, one in enumerate(sampling.inputs):
            row = {"rock": rock, "input": one.name, "title": one.title}
            yield row | {"share": shares[place, 0], "share_error": errors[place]}
