"""Variance indices of sampled inputs, and elasticities whatever else varies."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensemble.points import gridded
from jointclosure.experiments.global_sensitivity.design import (
    SURFACES,
    Input,
    Sampling,
    is_positive,
    value_at,
)
from jointclosure.statistics.orthonormal import Fit, Term, design_matrix, fitted
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.variance_indices import (
    Indices,
    shapley_effects,
    variance_indices,
)

RESPONSES = ("closure", "closure_net", "residual_seated_net", "stiffness_net")
"""Quantities that are read of each cycle. Of later cycles next to no residual closure stays."""
FEWEST = 16
"""Rows from which indices are found."""
GROUPS = 16
"""Groups of rows of the jackknife, where fits are repeated."""
CHOICES_DRAWN = 4096
"""Choices drawn, over which a conclusion is asked."""
INDEX_COLUMNS = ("rock", "response", "cycle", "rows", "input", "title", "total", "total_error")
"""Those that a table of indices has also where there are none."""
ELASTICITY_COLUMNS = (
    "rock", "response", "cycle", "input",
    "elasticity", "elasticity_error", "spread", "spread_error",
    "share_positive", "share_positive_error", "fit_over_noise",
)  # fmt: skip


class Responses(NamedTuple):
    """A response (row, point, surface) of a rock and a cycle, with its points; whole rows only.

    ``rows`` are their numbers in the sampling, ``left_out`` how many are not whole.
    """

    rock: str
    name: str
    cycle: int
    rows: np.ndarray
    points: np.ndarray
    values: np.ndarray
    left_out: int


class Elasticities(NamedTuple):
    """Elasticities of a response by property, of a rock.

    ``inputs`` (k) by name; ``drawn`` (k, n) at n drawn choices, ``left_out`` (k, groups, n) the
    same without each group of rows; ``single`` (k, N) of each row alone, with its noise, and
    ``rows`` (N,) their numbers; ``fit_over_noise`` (k,): what the regression leaves of the rows'
    changes, over what two surfaces differ by (1: noise alone).
    """

    inputs: list[str]
    drawn: np.ndarray
    left_out: np.ndarray
    single: np.ndarray
    rows: np.ndarray
    fit_over_noise: np.ndarray


def by_rock(joints: pd.DataFrame) -> dict[str, xr.Dataset]:
    """Put the joints of each rock on a grid.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`.

    Returns
    -------
    dict of Dataset
        `RESPONSES` over (row, point, surface, cycle), NaN where a simulation failed.
    """
    joints = joints.assign(surface=joints.realization - SURFACES * joints.row)
    return {
        str(rock): gridded(part, ("row", "point", "surface"), RESPONSES)
        for rock, part in joints.groupby("rock", sort=False)
    }


def responses_of(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> Iterator[Responses]:
    """Every response of every rock and cycle; rows with a failed simulation are left out.

    In place of the net stiffness its inverse, the compliance: a mean over stiffnesses is that of
    the few that are near infinite.
    """
    points = sampling.points()
    for rock, each in closed.items():
        whole = each.sortby("row")
        whole = whole.assign(compliance=1.0 / whole.stiffness_net)
        for name in (*(name for name in RESPONSES if name != "stiffness_net"), "compliance"):
            for cycle in whole.cycle.values.tolist():
                if name == "residual_seated_net" and cycle > 1:
                    continue
                values = whole[name].sel(cycle=cycle).values
                good = np.isfinite(values).all(axis=(1, 2))
                rows = whole.row.values[good]
                left_out = int((~good).sum())
                yield Responses(rock, name, cycle, rows, points[rows], values[good], left_out)


def index_table(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Indices of every input, response, cycle and rock, for a quarter, half and all of the rows.

    Parameters
    ----------
    sampling : Sampling
    closed : mapping
        As from `by_rock`.

    Returns
    -------
    DataFrame
        Without responses of fewer than `FEWEST` whole rows. ``rock``, ``response``, ``cycle``,
        ``rows``, ``left_out``, ``input``, ``first`` and ``total`` with standard errors; of all
        rows also the Shapley effects of the fitted function (``shapley``, and
        ``shapley_dependent`` with its dependent inputs) with jackknife errors. The input
        "surfaces" has the share of the surfaces in a single joint's variance.
    """
    rows, fits = [], []
    for each in responses_of(sampling, closed):
        enough = [share for share in (4, 2, 1) if len(each.values) // share >= FEWEST]
        for share in enough:
            number = len(each.values) // share
            points, values = each.points[:number], each.values[:number]
            found = variance_indices(points, values, sampling.values)
            about = {"rock": each.rock, "response": each.name, "cycle": each.cycle}
            about |= {"rows": number, "left_out": each.left_out, "fit_share": found.fit_share}
            rows += [about | row for row in _index_rows(sampling, found)]
        if enough:  # all of the rows came last
            fits.append((about, _resampled(each, sampling.values)))
    if not fits:
        return pd.DataFrame(columns=list(INDEX_COLUMNS))
    return pd.DataFrame(rows).merge(_shapley_table(sampling, fits), how="left")


def elasticity_table(sampling: Sampling, keys: Mapping, closed) -> pd.DataFrame:
    """Elasticities of properties, and how they vary with all else.

    Returns
    -------
    DataFrame
        ``rock``, ``response``, ``cycle``, ``input``; ``elasticity``, its mean over all else;
        ``spread``, its standard deviation over all else; ``share_positive`` of all else for which
        it is above 0; each with its jackknife error; ``fit_over_noise``. A response that is not
        positive everywhere has none.
    """
    rows = []
    for each in filter(has_elasticities, responses_of(sampling, closed)):
        if not _properties(sampling, keys, each.rock):
            continue
        found = elasticities_at(sampling, keys, each, choices_drawn(sampling))

        def read(drawn: np.ndarray) -> dict[str, np.ndarray]:
            return {
                "elasticity": drawn.mean(axis=-1),
                "spread": drawn.std(axis=-1),
                "share_positive": (drawn > 0.0).mean(axis=-1),
            }

        values = read(found.drawn)
        errors = {name: jackknife_error(parts.T) for name, parts in read(found.left_out).items()}
        about = {"rock": each.rock, "response": each.name, "cycle": each.cycle}
        for place, name in enumerate(found.inputs):
            row = about | {"input": name}
            for column in values:
                row[column] = values[column][place]
                row[f"{column}_error"] = errors[column][place]
            rows.append(row | {"fit_over_noise": found.fit_over_noise[place]})
    return pd.DataFrame(rows, columns=list(ELASTICITY_COLUMNS))


def elasticities_at(
    sampling: Sampling, keys: Mapping, each: Responses, at: np.ndarray
) -> Elasticities:
    """d ln(response)/d ln(property) at drawn choices (n, d), and what is known of each row.

    Between the two points of a row that differ in a property alone, on the same surfaces,

        change of ln(response) = (e + sum of b_j t_j over the other inputs) change of ln(property)

    with the first function t_j of each input (`jointclosure.statistics.orthonormal`); least
    squares. Each b_j is multiplied by 1 - (error/b_j)^2, or 0: noise is no variation.
    """
    drawn_functions = first_functions(at, sampling.values)
    functions = first_functions(each.points[:, 0], sampling.values)
    logarithms = np.log(each.values)
    inputs, answers = [], []
    for place, one in _properties(sampling, keys, each.rock):
        others = [other for other in range(len(sampling.inputs)) if other != place]
        step = _logarithm(one, keys, each.rock, each.points[:, 2 + place, place])
        step = step - _logarithm(one, keys, each.rock, each.points[:, 0, place])
        change = logarithms[:, 2 + place] - logarithms[:, 0]  # (row, surface)
        matrix = np.column_stack([np.ones(len(step)), functions[:, others]]) * step[:, None]
        slopes = _shrunk_slopes(matrix, change.mean(axis=-1), each.rows)
        columns = np.column_stack([np.ones(len(at)), drawn_functions[:, others]])
        drawn = np.stack([columns @ slope for slope in slopes])
        inputs.append(one.name)
        answers.append(
            (drawn[0], drawn[1:], change.mean(axis=-1) / step, _over_noise(matrix, change))
        )
    drawn, left_out, single, over_noise = map(np.array, zip(*answers, strict=True))
    return Elasticities(inputs, drawn, left_out, single, each.rows, over_noise)


def _properties(sampling: Sampling, keys: Mapping, rock: str) -> list[tuple[int, Input]]:
    """Inputs that have elasticities, with their places."""
    return [
        (place, one)
        for place, one in enumerate(sampling.inputs)
        if one.property and is_positive(one, keys, rock)
    ]


def _shrunk_slopes(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Slopes (1 + groups, columns) of all rows and without each group, noise taken off."""
    slopes = np.stack([_least_squares(matrix, change, own) for own in _kept(rows)])
    squares, noise = slopes[0] ** 2, jackknife_error(slopes[1:]) ** 2
    factors = np.divide(squares - noise, squares, out=0.0 * squares, where=squares > noise)
    factors[0] = 1.0
    return factors * slopes


def _over_noise(matrix: np.ndarray, change: np.ndarray) -> float:
    """Variance that the fit leaves of mean changes, over that by which two surfaces differ."""
    rows, columns = matrix.shape
    if rows <= columns:
        return np.nan
    mean = change.mean(axis=-1)
    left = mean - matrix @ _least_squares(matrix, mean, np.arange(rows))
    noise = np.mean((change[:, 0] - change[:, 1]) ** 2) / 4.0  # of a mean of two
    return float((left**2).sum() / (rows - columns) / noise) if noise > 0.0 else np.nan


def first_functions(points: np.ndarray, values: tuple[int, ...]) -> np.ndarray:
    """The first function of each input at points (n, d): (n, d)."""
    terms = tuple(Term(((one, 0),)) for one in range(len(values)))
    return design_matrix(points, values, terms)


def has_elasticities(each: Responses) -> bool:
    """Whether a response has a logarithm at all points of some rows."""
    return bool(each.values.size and (each.values > 0.0).all())


def choices_drawn(sampling: Sampling) -> np.ndarray:
    """Points (n, d) over which elasticities are asked; the same in all rocks."""
    random = generator(seed_of(sampling.seed, "choices"))
    return random.random((CHOICES_DRAWN, len(sampling.inputs)))


def _index_rows(sampling: Sampling, found: Indices) -> Iterator[dict]:
    for place, each in enumerate(sampling.inputs):
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


def _shapley_table(sampling: Sampling, fits: list[tuple[dict, list[Fit]]]) -> pd.DataFrame:
    """Shapley effects of all responses at once: the points of a subset are the same for all."""
    coefficients = np.stack([fit.coefficients for _, own in fits for fit in own], axis=1)
    columns = {"shapley": shapley_effects(sampling.values, coefficients)}
    if sampling.correlations:
        columns["shapley_dependent"] = shapley_effects(
            sampling.values, coefficients, sampling.correlations
        )
    rows = []
    for number, (about, own) in enumerate(fits):
        here = slice(number * len(own), (number + 1) * len(own))
        for place, each in enumerate(sampling.inputs):
            row = about | {"input": each.name}
            for name, effects in columns.items():
                whole, *left_out = effects[place, here]
                row |= {name: whole, f"{name}_error": jackknife_error(np.array(left_out))}
            rows.append(row)
    return pd.DataFrame(rows)


def _resampled(each: Responses, counts) -> list[Fit]:
    """The fit to all rows, and those to all but a group."""
    d = each.points.shape[-1]
    mean = each.values.mean(axis=-1)
    return [
        fitted(each.points[rows].reshape(-1, d), mean[rows].ravel(), counts)
        for rows in _kept(each.rows)
    ]


def _kept(rows: np.ndarray) -> list[np.ndarray]:
    """Places of all rows, and of all but a group, in turn; groups are by the rows' numbers."""
    group = rows % GROUPS
    return [np.arange(rows.size), *(np.flatnonzero(group != one) for one in range(GROUPS))]


def _least_squares(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix[rows], change[rows], rcond=None)[0]


def _logarithm(one: Input, keys: Mapping, rock: str, u: np.ndarray) -> np.ndarray:
    return np.log([value_at(one, keys, rock, float(each)) for each in u])


def jackknife_error(left_out: np.ndarray) -> np.ndarray:
    """Errors (...) from what is found without each group of rows (groups, ...)."""
    about = left_out - left_out.mean(axis=0)
    return np.sqrt((GROUPS - 1) / GROUPS * (about**2).sum(axis=0))
