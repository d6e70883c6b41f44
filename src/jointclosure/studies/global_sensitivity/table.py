"""What a design's closures tell: indices, and elasticities whatever else varies."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.randomness import generator, seed_of
from jointclosure.statistics.orthonormal import Fit, fitted
from jointclosure.statistics.variance_indices import (
    Indices,
    shapley_effects,
    variance_indices,
)
from jointclosure.studies.global_sensitivity.closing import RESPONSES
from jointclosure.studies.global_sensitivity.design import Design, spread_of

GROUPS = 16
"""Groups of rows of the jackknife, where fits are repeated."""
CHOICES_DRAWN = 4096
"""Choices drawn, over which a conclusion is asked."""


class Responses(NamedTuple):
    """A response (row, point, surface) of a rock and a cycle, with its points; whole rows only."""

    rock: str
    name: str
    cycle: int
    points: np.ndarray
    values: np.ndarray
    left_out: int


def responses_of(design: Design, closed: Mapping[str, xr.Dataset]) -> Iterator[Responses]:
    """Every response of every rock and cycle; rows with a failed simulation are left out."""
    points = design.points()
    for rock, whole in closed.items():
        whole = whole.sortby("row")
        for name in RESPONSES:
            for cycle in whole.cycle.values.tolist():
                if name == "residual" and cycle > 1:
                    continue
                values = whole[name].sel(cycle=cycle).values
                good = np.isfinite(values).all(axis=(1, 2))
                own = points[whole.row.values[good]]
                yield Responses(rock, name, cycle, own, values[good], int((~good).sum()))


def index_table(design: Design, closed: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Indices of every input, response, cycle and rock, for a quarter, half and all of the rows.

    Parameters
    ----------
    design : Design
    closed : mapping
        Of every rock, its rows as from `close_rows`.

    Returns
    -------
    DataFrame
        ``rock``, ``response``, ``cycle``, ``rows``, ``left_out``, ``input``, ``first`` and
        ``total`` with standard errors; of all rows also the Shapley effects of the fitted function
        (``shapley``, and ``shapley_dependent`` with the design's dependent inputs) with jackknife
        errors. The input "surfaces" has the share of the surfaces in a single joint's variance.
    """
    rows, fits = [], []
    for each in responses_of(design, closed):
        for share in (4, 2, 1):
            number = len(each.values) // share
            if number < 16:
                continue
            points, values = each.points[:number], each.values[:number]
            found = variance_indices(points, values, design.values)
            about = {"rock": each.rock, "response": each.name, "cycle": each.cycle}
            about |= {"rows": number, "left_out": each.left_out, "fit_share": found.fit_share}
            rows += [about | row for row in _index_rows(design, found)]
        fits.append((about, _resampled(each, design.values, logarithm=False)))
    if not fits:
        return pd.DataFrame(rows)
    return pd.DataFrame(rows).merge(_shapley_table(design, fits), how="left")


def elasticity_table(design: Design, keys: dict, closed) -> pd.DataFrame:
    """Elasticities of properties in the middle of their ranges, whatever else varies.

    Returns
    -------
    DataFrame
        ``rock``, ``response``, ``cycle``, ``input``; ``elasticity``, its mean over all else;
        ``spread``, its standard deviation over all else; both with jackknife errors;
        ``share_positive`` of all else for which it is above 0. A response that is not positive
        everywhere has none.
    """
    rows = []
    for each in filter(has_elasticities, responses_of(design, closed)):
        spreads = spreads_of(design, keys, each.rock)
        at = choices_drawn(design)

        def read(fit: Fit, at=at, spreads=spreads) -> np.ndarray:
            found = elasticities_at(fit, at, spreads)
            parts = (found.mean(axis=0), found.std(axis=0), (found > 0.0).mean(axis=0))
            return np.concatenate(parts)

        values, errors = jackknifed(each, design.values, read)
        mean, spread, share = np.split(values, 3)
        mean_error, spread_error, share_error = np.split(errors, 3)
        for place, name in enumerate(spreads):
            rows.append(
                {
                    "rock": each.rock,
                    "response": each.name,
                    "cycle": each.cycle,
                    "input": name,
                    "elasticity": mean[place],
                    "elasticity_error": mean_error[place],
                    "spread": spread[place],
                    "spread_error": spread_error[place],
                    "share_positive": share[place],
                    "share_positive_error": share_error[place],
                }
            )
    return pd.DataFrame(rows)


def has_elasticities(each: Responses) -> bool:
    """Whether a response has a logarithm at all points."""
    return bool((each.values.mean(axis=-1) > 0.0).all())


def choices_drawn(design: Design) -> np.ndarray:
    """Points (n, d) over which elasticities are asked; the same in all rocks."""
    random = generator(seed_of(design.seed, "choices"))
    return random.random((CHOICES_DRAWN, len(design.inputs)))


def _index_rows(design: Design, found: Indices) -> Iterator[dict]:
    for place, each in enumerate(design.inputs):
        yield {
            "input": each.name,
            "title": each.title,
            "first": found.first[place],
            "first_error": found.first_error[place],
            "total": found.total[place],
            "total_error": found.total_error[place],
        }
    yield {
        "input": "surfaces",
        "title": "surfaces (share of a joint's variance)",
        "total": found.surfaces,
        "total_error": found.surfaces_error,
    }


def _shapley_table(design: Design, fits: list[tuple[dict, list[Fit]]]) -> pd.DataFrame:
    """Shapley effects of all responses at once: the points of a subset are the same for all."""
    coefficients = np.stack([fit.coefficients for _, own in fits for fit in own], axis=1)
    columns = {"shapley": shapley_effects(design.values, coefficients)}
    if design.correlations:
        columns["shapley_dependent"] = shapley_effects(
            design.values, coefficients, design.correlations
        )
    rows = []
    for number, (about, own) in enumerate(fits):
        here = slice(number * len(own), (number + 1) * len(own))
        for place, each in enumerate(design.inputs):
            row = about | {"input": each.name}
            for name, effects in columns.items():
                whole, *left_out = effects[place, here]
                row |= {name: whole, f"{name}_error": _jackknife_error(np.array(left_out))}
            rows.append(row)
    return pd.DataFrame(rows)


def fit_of(points, values, counts, logarithm: bool = True) -> Fit:
    mean = values.mean(axis=-1)
    target = np.log(mean) if logarithm else mean
    return fitted(points.reshape(-1, points.shape[-1]), target.ravel(), counts)


def jackknifed(each: Responses, counts, read) -> tuple[np.ndarray, np.ndarray]:
    """What is read of the fit to the logarithm of all rows, and its jackknife error."""
    whole, *left_out = (read(fit) for fit in _resampled(each, counts, logarithm=True))
    return whole, _jackknife_error(np.stack(left_out))


def _resampled(each: Responses, counts, logarithm: bool) -> list[Fit]:
    """The fit to all rows, and those to all but a group."""
    n = len(each.values)
    kept = [np.setdiff1d(np.arange(n), np.arange(first, n, GROUPS)) for first in range(GROUPS)]
    return [
        fit_of(each.points[rows], each.values[rows], counts, logarithm)
        for rows in (np.arange(n), *kept)
    ]


def _jackknife_error(left_out: np.ndarray) -> np.ndarray:
    about = left_out - left_out.mean(axis=0)
    return np.sqrt((GROUPS - 1) / GROUPS * (about**2).sum(axis=0))


def spreads_of(design: Design, keys: dict, rock: str) -> dict[str, tuple[int, float]]:
    """Properties that have an elasticity: place among the inputs, and ln of high over low."""
    found = {}
    for place, each in enumerate(design.inputs):
        spread = spread_of(each, keys, rock) if each.property else None
        if spread is not None:
            found[each.name] = (place, spread)
    return found


def elasticities_at(fit: Fit, at: np.ndarray, spreads: Mapping[str, tuple[int, float]]):
    """d ln(response)/d ln(property) between the ends of its range, all else as drawn (n, k)."""
    columns = []
    for place, spread in spreads.values():
        low, high = at.copy(), at.copy()
        low[:, place], high[:, place] = 0.0, 1.0
        columns.append((fit(high) - fit(low)) / spread)
    return np.stack(columns, axis=1)
