"""Variance indices of sampled inputs, and elasticities whatever else varies."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.ensembles import gridded
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import jackknife_error
from jointclosure.statistics.variance_indices import (
    Fit,
    Indices,
    Term,
    design_matrix,
    fitted,
    shapley_effects,
    variance_indices,
)
from studies.global_sensitivity.design import (
    SURFACES,
    Input,
    Sampling,
    is_positive,
    value_at,
)
from studies.paper.claims import LOOP

RESPONSES = ("max_closure", "max_closure_net", "residual_closure_seated_net", "compliance_net")
"""Responses of each cycle with indices: compliance, as nearly infinite stiffnesses would dominate a
mean of stiffnesses. Residual closure is next to none in later cycles."""
QUANTITIES = (*RESPONSES, LOOP)
"""Quantities of the joints."""
FEWEST = 16
"""Smallest number of rows for indices."""
GROUPS = 16
"""Number of groups of rows of the jackknife."""
CHOICES_DRAWN = 4096
"""Number of random choices for which a conclusion is judged."""
INDEX_COLUMNS = (
    "rock", "response", "cycle", "rows", "left_out", "input", "title", "total", "total_error",
)  # fmt: skip
"""Columns of a table without any indices."""
ELASTICITY_COLUMNS = (
    "rock", "response", "cycle", "input",
    "elasticity", "elasticity_error", "spread", "spread_error",
    "share_positive", "share_positive_error", "fit_over_noise",
)  # fmt: skip


class Responses(NamedTuple):
    """Responses (row, point, surface) of a rock and a cycle at points, of complete rows."""

    rock: str
    name: str
    cycle: int
    rows: np.ndarray
    points: np.ndarray
    values: np.ndarray
    left_out: int


class Elasticities(NamedTuple):
    """Elasticities of a response of a rock by property (k).

    ``drawn`` (k, n) at n drawn choices, ``left_out`` (k, groups, n) the same without each group of
    rows; ``single`` (k, N) of single rows, with their noise, whose numbers are ``rows``;
    ``fit_over_noise`` (k,): variance of the rows' changes about the regression, over that of the
    difference of two surfaces (1: noise alone).
    """

    inputs: list[str]
    drawn: np.ndarray
    left_out: np.ndarray
    single: np.ndarray
    rows: np.ndarray
    fit_over_noise: np.ndarray


def by_rock(joints: pd.DataFrame) -> dict[str, xr.Dataset]:
    """Put the joints of each rock on a grid."""
    joints = joints.assign(surface=joints.realization - SURFACES * joints.row)
    return {
        str(rock): gridded(part, ("row", "point", "surface"), QUANTITIES)
        for rock, part in joints.groupby("rock", sort=False)
    }


def responses_of(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> Iterator[Responses]:
    """Generate responses of all rocks and cycles, of compliance in place of stiffness."""
    points = sampling.points()
    for rock, of_rock in closed.items():
        whole = of_rock.sortby("row")
        for name in RESPONSES:
            for cycle in whole.cycle.values.tolist():
                if name == "residual_closure_seated_net" and cycle > 1:
                    continue
                values = whole[name].sel(cycle=cycle).values
                good = np.isfinite(values).all(axis=(1, 2))
                rows, left_out = whole.row.values[good], int((~good).sum())
                yield Responses(rock, name, cycle, rows, points[rows], values[good], left_out)


def index_table(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Compute first and total indices of inputs, for a quarter, half and all of the rows.

    Of all rows also Shapley effects. The input "surfaces" has the share of the surfaces in a single
    joint's variance. There are none of fewer than `FEWEST` complete rows.
    """
    rows, fits = [], []
    for response in responses_of(sampling, closed):
        enough = [share for share in (4, 2, 1) if len(response.values) // share >= FEWEST]
        for share in enough:
            number = len(response.values) // share
            points, values = response.points[:number], response.values[:number]
            indices = variance_indices(points, values, sampling.values)
            about = {"rock": response.rock, "response": response.name, "cycle": response.cycle}
            about |= {"rows": number, "left_out": response.left_out, "fit_share": indices.fit_share}
            rows += [about | row for row in _index_rows(sampling, indices)]
        if enough:  # all of the rows came last
            fits.append(
                (about, [_fitted(response, kept, sampling) for kept in _kept(response.rows)])
            )
    if not fits:
        return pd.DataFrame(columns=list(INDEX_COLUMNS))
    return pd.DataFrame(rows).merge(_shapley_table(sampling, fits), how="left")


def elasticity_table(sampling: Sampling, keys: Mapping, closed) -> pd.DataFrame:
    """Compute elasticities: mean, spread and share above 0 over other inputs, by jackknife."""
    rows = []
    for response in filter(has_elasticities, responses_of(sampling, closed)):
        if not _properties(sampling, keys, response.rock):
            continue
        fit = elasticities_at(sampling, keys, response, choices_drawn(sampling))

        def statistics(drawn: np.ndarray) -> dict[str, np.ndarray]:
            return {
                "elasticity": drawn.mean(axis=-1),
                "spread": drawn.std(axis=-1),
                "share_positive": (drawn > 0.0).mean(axis=-1),
            }

        values = statistics(fit.drawn)
        errors = {
            name: jackknife_error(parts.T) for name, parts in statistics(fit.left_out).items()
        }
        about = {"rock": response.rock, "response": response.name, "cycle": response.cycle}
        for place, name in enumerate(fit.inputs):
            row = about | {"input": name}
            for column in values:
                row |= {column: values[column][place], f"{column}_error": errors[column][place]}
            rows.append(row | {"fit_over_noise": fit.fit_over_noise[place]})
    return pd.DataFrame(rows, columns=list(ELASTICITY_COLUMNS))


def elasticities_at(
    sampling: Sampling, keys: Mapping, response: Responses, at: np.ndarray
) -> Elasticities:
    """Fit d ln(response)/d ln(property) at drawn choices (n, d), and compute that of single rows.

    Between the two points of a row that differ in a property alone, on the same surfaces,

        change of ln(response) = (e + sum of b_j t_j over the other inputs) change of ln(property)

    with the first function t_j of each input (`jointclosure.statistics.variance_indices`); least
    squares. To remove noise, each b_j is multiplied by 1 - (error/b_j)^2, or by 0 if negative.
    """
    drawn_functions = first_functions(at, sampling.values)
    functions = first_functions(response.points[:, 0], sampling.values)
    logarithms = np.log(response.values)
    inputs, answers = [], []
    for place, one in _properties(sampling, keys, response.rock):
        others = [other for other in range(len(sampling.inputs)) if other != place]
        step = _logarithm(one, keys, response.rock, response.points[:, 2 + place, place])
        step = step - _logarithm(one, keys, response.rock, response.points[:, 0, place])
        change = logarithms[:, 2 + place] - logarithms[:, 0]  # (row, surface)
        matrix = np.column_stack([np.ones(len(step)), functions[:, others]]) * step[:, None]
        slopes = _shrunk_slopes(matrix, change.mean(axis=-1), response.rows)
        columns = np.column_stack([np.ones(len(at)), drawn_functions[:, others]])
        drawn = np.stack([columns @ slope for slope in slopes])
        inputs.append(one.name)
        answers.append(
            (drawn[0], drawn[1:], change.mean(axis=-1) / step, _over_noise(matrix, change))
        )
    drawn, left_out, single, over_noise = map(np.array, zip(*answers, strict=True))
    return Elasticities(inputs, drawn, left_out, single, response.rows, over_noise)


def _properties(sampling: Sampling, keys: Mapping, rock: str) -> list[tuple[int, Input]]:
    """Return the inputs with elasticities, and their places."""
    return [
        (place, one)
        for place, one in enumerate(sampling.inputs)
        if one.property and is_positive(one, keys, rock)
    ]


def _shrunk_slopes(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Fit slopes (1 + groups, columns) of all rows and without each group, shrunk for noise."""
    slopes = np.stack([_least_squares(matrix, change, kept) for kept in _kept(rows)])
    squares, noise = slopes[0] ** 2, jackknife_error(slopes[1:]) ** 2
    factors = np.divide(squares - noise, squares, out=0.0 * squares, where=squares > noise)
    factors[0] = 1.0
    return factors * slopes


def _over_noise(matrix: np.ndarray, change: np.ndarray) -> float:
    """Compute the variance of mean changes about the fit, over that between two surfaces."""
    rows, columns = matrix.shape
    if rows <= columns:
        return np.nan
    mean = change.mean(axis=-1)
    left = mean - matrix @ _least_squares(matrix, mean, np.arange(rows))
    noise = np.mean((change[:, 0] - change[:, 1]) ** 2) / 4.0  # of a mean of two
    return float((left**2).sum() / (rows - columns) / noise) if noise > 0.0 else np.nan


def first_functions(points: np.ndarray, values: tuple[int, ...]) -> np.ndarray:
    """Return the first function of each input at points (n, d): (n, d)."""
    terms = tuple(Term(((one, 0),)) for one in range(len(values)))
    return design_matrix(points, values, terms)


def has_elasticities(response: Responses) -> bool:
    """Return whether a response has a logarithm at all points of some rows."""
    return bool(response.values.size and (response.values > 0.0).all())


def choices_drawn(sampling: Sampling) -> np.ndarray:
    """Draw points (n, d) at which elasticities are evaluated; the same in all rocks."""
    random = generator(seed_of(sampling.seed, "choices"))
    return random.random((CHOICES_DRAWN, len(sampling.inputs)))


def _index_rows(sampling: Sampling, indices: Indices) -> Iterator[dict]:
    columns = ("first", "first_error", "total", "total_error")
    for place, one in enumerate(sampling.inputs):
        values = {name: getattr(indices, name)[place] for name in columns}
        yield {"input": one.name, "title": one.title} | values
    title = "surfaces (share of a joint's variance)"
    whole = {"total": indices.surfaces, "total_error": indices.surfaces_error}
    yield {"input": "surfaces", "title": title} | whole


def _shapley_table(sampling: Sampling, fits: list[tuple[dict, list[Fit]]]) -> pd.DataFrame:
    """Compute Shapley effects of all responses at once, as the points of a subset are the same."""
    coefficients = np.stack(
        [fit.coefficients for _, of_response in fits for fit in of_response], axis=1
    )
    columns = {"shapley": shapley_effects(sampling.values, coefficients)}
    if sampling.correlations:
        columns["shapley_dependent"] = shapley_effects(
            sampling.values, coefficients, sampling.correlations
        )
    rows = []
    for number, (about, of_response) in enumerate(fits):
        here = slice(number * len(of_response), (number + 1) * len(of_response))
        for place, one in enumerate(sampling.inputs):
            row = about | {"input": one.name}
            for name, effects in columns.items():
                whole, *left_out = effects[place, here]
                row |= {name: whole, f"{name}_error": jackknife_error(np.array(left_out))}
            rows.append(row)
    return pd.DataFrame(rows)


def _fitted(response: Responses, kept: np.ndarray, sampling: Sampling) -> Fit:
    points, mean = response.points[kept], response.values.mean(axis=-1)[kept]
    return fitted(points.reshape(-1, points.shape[-1]), mean.ravel(), sampling.values)


def _kept(rows: np.ndarray) -> list[np.ndarray]:
    """Return places of all rows, then without one group in turn; groups are by row number."""
    groups = rows % GROUPS
    return [np.arange(rows.size), *(np.flatnonzero(groups != group) for group in range(GROUPS))]


def _least_squares(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix[rows], change[rows], rcond=None)[0]


def _logarithm(one: Input, keys: Mapping, rock: str, u: np.ndarray) -> np.ndarray:
    return np.log([value_at(one, keys, rock, float(part)) for part in u])
