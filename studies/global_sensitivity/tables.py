"""Variance indices of inputs, elasticities over all other inputs, and conclusions of the paper.

A conclusion is judged by the share of the model's open choices for which it holds.
"""

import functools
import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import confidence_limits, jackknife_error
from jointclosure.statistics.variance_indices import (
    FittedFunction,
    Indices,
    Term,
    design_matrix,
    fit_function,
    shapley_effects,
    variance_indices,
)
from jointclosure.statistics.verdicts import frequency
from studies.frame.joint_tables import gridded
from studies.global_sensitivity.design import (
    SURFACES,
    Input,
    Sampling,
    is_positive,
    value_at,
)
from studies.paper.claims import (
    HYSTERESIS,
    LOOP,
    ClosureStatement,
    Elasticities,
    statements_of_elasticities,
)
from studies.paper.conclusions import SHARES

RESPONSES = ("max_closure", "max_closure_net", "residual_closure_seated_net", "compliance_net")
"""Responses with indices. Compliance is among them because nearly infinite stiffnesses would
dominate a mean of stiffnesses. Residual closure is that of the first cycle, as later cycles have
hardly any."""
RESPONSES_AND_LOOP = (*RESPONSES, LOOP)
"""Quantities of the joints."""
FEWEST_ROWS = 16
"""Smallest number of rows for indices."""
GROUPS = 16
"""Number of groups of rows of the jackknife."""
CHOICES_DRAWN = 4096
"""Number of random choices for which a conclusion is judged."""
INDEX_COLUMNS = (
    "rock", "response", "cycle", "rows", "left_out", "input", "title", "total", "total_error",
)  # fmt: skip
"""Columns of a table of indices without rows."""
ELASTICITY_COLUMNS = (
    "rock", "response", "cycle", "input",
    "elasticity", "elasticity_error", "spread", "spread_error",
    "share_positive", "share_positive_error", "fit_over_noise",
)  # fmt: skip


class Responses(NamedTuple):
    """Values (row, point, surface) of a response of a rock in a cycle, of complete rows.

    ``rows`` are their numbers, ``points`` (row, point, input) theirs in the unit cube. ``left_out``
    is the number of rows with a joint that has no value.
    """

    rock: str
    name: str
    cycle: int
    rows: np.ndarray
    points: np.ndarray
    values: np.ndarray
    left_out: int

    @property
    def about(self) -> dict[str, Any]:
        """Columns of tables that name the response."""
        return {"rock": self.rock, "response": self.name, "cycle": self.cycle}


class FittedElasticities(NamedTuple):
    """Elasticities of a response of a rock with respect to k properties.

    ``drawn`` (k, 1 + groups, n) are those at n drawn choices: fitted to all rows, and to the rows
    without each group. ``single`` (k, N) are those of single rows, with their noise; ``rows`` are
    the numbers of these rows. ``fit_over_noise`` (k,) is the variance of the rows' changes about
    the regression over that due to surfaces (1: the regression leaves noise only).
    """

    inputs: list[str]
    drawn: np.ndarray
    single: np.ndarray
    rows: np.ndarray
    fit_over_noise: np.ndarray


def datasets_by_rock(joints: pd.DataFrame) -> dict[str, xr.Dataset]:
    """Arrange the joints of each rock as a dataset over row, point, surface and cycle."""
    joints = joints.assign(surface=joints.realization - SURFACES * joints.row)
    return {
        str(rock): gridded(part, ("row", "point", "surface"), RESPONSES_AND_LOOP)
        for rock, part in joints.groupby("rock", sort=False)
    }


def responses_of(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> Iterator[Responses]:
    """Generate `RESPONSES` of all rocks and cycles; residual closure of the first cycle only."""
    points = sampling.points()
    for rock, of_rock in closed.items():
        whole = of_rock.sortby("row")
        for name in RESPONSES:
            for cycle in whole.cycle.values.tolist():
                if name == "residual_closure_seated_net" and cycle > 1:
                    continue
                values = whole[name].sel(cycle=cycle).values
                good = np.isfinite(values).all(axis=(1, 2))
                rows = whole.row.values[good]
                left_out = int((~good).sum())
                yield Responses(rock, name, cycle, rows, points[rows], values[good], left_out)


def index_table(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Compute first and total indices of inputs from a quarter, half and all of the rows.

    Shares with fewer than `FEWEST_ROWS` complete rows are left out. Shapley effects are computed
    from all rows. The rows of the input "surfaces" have the surfaces' share in the variance of a
    single joint.
    """
    rows = []
    fits = []
    for response in responses_of(sampling, closed):
        enough = [share for share in (4, 2, 1) if len(response.values) // share >= FEWEST_ROWS]
        for share in enough:
            number = len(response.values) // share
            points = response.points[:number]
            values = response.values[:number]
            indices = variance_indices(points, values, sampling.values)
            about = response.about | {"rows": number, "left_out": response.left_out}
            about |= {"fit_share": indices.fit_share}
            rows += [about | row for row in _index_rows(sampling, indices)]
        if enough:  # all of the rows came last
            kept = _kept(response.rows)
            fits.append((about, [_fitted(response, part, sampling) for part in kept]))
    if not fits:
        return pd.DataFrame(columns=list(INDEX_COLUMNS))
    return pd.DataFrame(rows).merge(_shapley_table(sampling, fits), how="left")


def global_elasticity_table(sampling: Sampling, closed: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Tabulate mean, spread and share above 0 of elasticities over the other inputs.

    Their standard errors are by jackknife over groups of rows.
    """
    rows = []
    for response in filter(has_elasticities, responses_of(sampling, closed)):
        if not _properties(sampling, response.rock):
            continue
        fit = elasticities_at(sampling, response, choices_drawn(sampling))
        statistics = {
            "elasticity": fit.drawn.mean(axis=-1),
            "spread": fit.drawn.std(axis=-1),
            "share_positive": (fit.drawn > 0.0).mean(axis=-1),
        }
        for place, name in enumerate(fit.inputs):
            row = response.about | {"input": name}
            for column, values in statistics.items():
                errors = jackknife_error(values[:, 1:].T)
                row |= {column: values[place, 0], f"{column}_error": errors[place]}
            rows.append(row | {"fit_over_noise": fit.fit_over_noise[place]})
    return pd.DataFrame(rows, columns=list(ELASTICITY_COLUMNS))


def elasticities_at(sampling: Sampling, response: Responses, at: np.ndarray) -> FittedElasticities:
    """Fit d ln(response)/d ln(property) at drawn choices (n, d), and compute that of single rows.

    Between the two points of a row that differ in a property alone, on the same surfaces,

        change of ln(response) = (e + sum of b_j t_j over the other inputs) change of ln(property)

    with the first function t_j of each input (`jointclosure.statistics.variance_indices`); least
    squares. To remove noise, each b_j is multiplied by 1 - (error/b_j)^2, or by 0 if negative.
    """
    drawn_functions = first_functions(at, sampling.values)
    functions = first_functions(response.points[:, 0], sampling.values)
    logarithms = np.log(response.values)
    inputs = []
    answers = []
    for place, name, one in _properties(sampling, response.rock):
        others = [other for other in range(len(sampling.inputs)) if other != place]
        known = sampling.rocks[response.rock]
        after, before = (
            np.log([value_at(one, known, float(u)) for u in response.points[:, point, place]])
            for point in (2 + place, 0)
        )
        step = after - before
        change = logarithms[:, 2 + place] - logarithms[:, 0]  # (row, surface)
        matrix = np.column_stack([np.ones(len(step)), functions[:, others]]) * step[:, None]
        slopes = _slopes_shrunk_by_noise(matrix, change.mean(axis=-1), response.rows)
        columns = np.column_stack([np.ones(len(at)), drawn_functions[:, others]])
        drawn = np.stack([columns @ slope for slope in slopes])
        inputs.append(name)
        answers.append((drawn, change.mean(axis=-1) / step, _over_noise(matrix, change)))
    drawn, single, over_noise = map(np.array, zip(*answers, strict=True))
    return FittedElasticities(inputs, drawn, single, response.rows, over_noise)


def _properties(sampling: Sampling, rock: str) -> list[tuple[int, str, Input]]:
    """Return place, name and input of each varied property with positive values in a rock."""
    return [
        (place, name, one)
        for place, (name, one) in enumerate(sampling.inputs.items())
        if one.of_rock and is_positive(one, sampling.rocks[rock])
    ]


def _slopes_shrunk_by_noise(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Fit slopes (1 + groups, columns) to all rows and without each group, shrunk for noise."""
    slopes = np.stack([_least_squares(matrix, change, kept) for kept in _kept(rows)])
    squares = slopes[0] ** 2
    noise = jackknife_error(slopes[1:]) ** 2
    factors = np.divide(squares - noise, squares, out=0.0 * squares, where=squares > noise)
    factors[0] = 1.0
    return factors * slopes


def _over_noise(matrix: np.ndarray, change: np.ndarray) -> float:
    """Compute the variance of mean changes about the fit, over that due to the two surfaces."""
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
    """Return whether a response has complete rows, and a logarithm in all of them."""
    return bool(response.values.size and (response.values > 0.0).all())


def choices_drawn(sampling: Sampling) -> np.ndarray:
    """Draw points (n, d) at which elasticities are evaluated; the same in all rocks."""
    random = generator(seed_of(sampling.seed, "choices"))
    return random.random((CHOICES_DRAWN, len(sampling.inputs)))


def _index_rows(sampling: Sampling, indices: Indices) -> Iterator[dict]:
    columns = ("first", "first_error", "total", "total_error")
    for place, (name, one) in enumerate(sampling.inputs.items()):
        values = {column: getattr(indices, column)[place] for column in columns}
        yield {"input": name, "title": one.title} | values
    title = "surfaces (share of a joint's variance)"
    whole = {"total": indices.surfaces, "total_error": indices.surfaces_error}
    yield {"input": "surfaces", "title": title} | whole


def _shapley_table(
    sampling: Sampling, fits: list[tuple[dict, list[FittedFunction]]]
) -> pd.DataFrame:
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
        for place, name in enumerate(sampling.inputs):
            row = about | {"input": name}
            for column, effects in columns.items():
                whole, *left_out = effects[place, here]
                row |= {column: whole, f"{column}_error": jackknife_error(np.array(left_out))}
            rows.append(row)
    return pd.DataFrame(rows)


def _fitted(response: Responses, kept: np.ndarray, sampling: Sampling) -> FittedFunction:
    points = response.points[kept]
    mean = response.values.mean(axis=-1)[kept]
    return fit_function(points.reshape(-1, points.shape[-1]), mean.ravel(), sampling.values)


def _kept(rows: np.ndarray) -> list[np.ndarray]:
    """Return the places of all rows, then those without each group (row number modulo `GROUPS`)."""
    groups = rows % GROUPS
    return [np.arange(rows.size), *(np.flatnonzero(groups != group) for group in range(GROUPS))]


def _least_squares(matrix: np.ndarray, change: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix[rows], change[rows], rcond=None)[0]


NAMES = ("max_closure", "max_closure_net")
"""Responses for which conclusions are judged."""
COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", *SHARES, "rows", "rows_true",
)  # fmt: skip
MARGIN_COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", "input", "title", "share", "share_error",
)  # fmt: skip


class _Margins(NamedTuple):
    """Margins of a conclusion [elasticity]: drawn (1 + groups, n), and of single ``rows`` (N,)."""

    drawn: np.ndarray
    single: np.ndarray
    rows: np.ndarray


def conclusion_tables(
    sampling: Sampling, closed: Mapping[str, xr.Dataset]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tabulate shares of choices for which conclusions hold, and the inputs behind their margins.

    In the first table, ``rock`` is "all" for conclusions that hold in every rock at once.
    ``share_error`` is by jackknife over groups of rows, and the 95 % interval is at least as wide
    as that of a count of single rows. ``rows_true`` is the number of rows for whose changes, noise
    included, the conclusion holds. In the second table, ``share`` is that of an input in the
    variance of the margin by which a conclusion holds.

    Raises
    ------
    InputError
        If the joints of a rock are missing.
    """
    fits = _elasticities(sampling, closed)
    shares: list[dict] = []
    margins: list[dict] = []
    for name, cycle, statement in itertools.product(NAMES, (1, 2), statements_of_elasticities()):
        of_rocks = _of_rocks(sampling, fits, statement, name, cycle)
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


def _elasticities(
    sampling: Sampling, closed: Mapping[str, xr.Dataset]
) -> dict[tuple, FittedElasticities]:
    """Return elasticities by rock, response and cycle; nothing if a rock has no elasticities."""
    missing = sorted(set(sampling.rocks) - set(closed))
    if missing:
        raise InputError(f"the joints of {', '.join(missing)} are missing")
    if not all(_properties(sampling, rock) for rock in sampling.rocks):
        return {}
    at = choices_drawn(sampling)
    return {
        (one.rock, one.name, one.cycle): elasticities_at(sampling, one, at)
        for one in responses_of(sampling, closed)
        if one.name in NAMES and has_elasticities(one)
    }


def _about(statement: ClosureStatement, name: str, cycle: int) -> dict:
    about = {"number": statement.number, "conclusion": statement.text}
    return about | {"response": name, "cycle": cycle}


def _bases(sampling: Sampling, rock: str) -> dict[str, float]:
    """Return the rock's values of the properties that vary [SI]."""
    return {
        one.of_rock: PROPERTIES[one.of_rock].size * sampling.rocks[rock][one.parts[-1]]
        for one in sampling.inputs.values()
        if one.of_rock
    }


def _loop_shares(closed: Mapping[str, xr.Dataset], cycle: int) -> Iterator[dict]:
    """Generate shares of rows whose first point has hysteresis, by rock and in all at once."""
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
    sampling: Sampling, fits: dict[tuple, FittedElasticities], statement: ClosureStatement,
    name: str, cycle: int,
) -> dict[str, _Margins]:  # fmt: skip
    """Return margins by rock; nothing if a rock lacks an elasticity of the statement."""
    properties = {name: one.of_rock for name, one in sampling.inputs.items()}
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
            return statement.least(Elasticities(by_cycle, _bases(sampling, rock)), cycle)

        margins[rock] = _Margins(
            least(lambda fit: fit.drawn),
            least(lambda fit, rows=rows: fit.single[:, np.isin(fit.rows, rows)]),
            rows,
        )
    return margins


def _shares(of_rocks: dict[str, _Margins], above: float) -> Iterator[dict]:
    """Generate the shares of margins above a bound, by rock and in all at once."""
    if not of_rocks:
        return
    for rock, margin in of_rocks.items():
        yield {"rock": rock} | _share(margin.drawn > above, margin.single > above)
    together = of_rocks.values()
    rows = set.intersection(*(set(margin.rows.tolist()) for margin in together))
    single = [margin.single[np.isin(margin.rows, list(rows))] > above for margin in together]
    drawn = np.all([margin.drawn > above for margin in together], axis=0)
    yield {"rock": "all"} | _share(drawn, np.all(single, axis=0))


def _share(drawn: np.ndarray, single: np.ndarray) -> dict:
    share, *left_out = drawn.mean(axis=1).tolist()
    error = float(jackknife_error(np.array(left_out)))
    interval = confidence_limits((share, error), GROUPS)
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
    """Generate the share of each input in the variance of a rock's margin over the choices."""
    functions = first_functions(choices_drawn(sampling), sampling.values)
    matrix = np.column_stack([np.ones(len(functions)), functions])
    for rock, margin in of_rocks.items():
        slopes = np.linalg.lstsq(matrix, margin.drawn.T, rcond=None)[0][1:]
        variances = margin.drawn.var(axis=1)
        parts = functions.var(axis=0)[:, None] * slopes**2
        shares = np.divide(parts, variances, out=np.full_like(parts, np.nan), where=variances > 0)
        errors = jackknife_error(shares[:, 1:].T)
        for place, (name, one) in enumerate(sampling.inputs.items()):
            row = {"rock": rock, "input": name, "title": one.title}
            yield row | {"share": shares[place, 0], "share_error": errors[place]}
