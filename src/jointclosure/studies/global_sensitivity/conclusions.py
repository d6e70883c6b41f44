"""Which of the paper's conclusions hold, whatever is chosen of what the paper leaves open."""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.statistics.verdicts import frequency_of, t_interval
from jointclosure.studies.global_sensitivity.design import Design, is_positive
from jointclosure.studies.global_sensitivity.table import (
    GROUPS,
    Elasticities,
    choices_drawn,
    elasticities_at,
    first_functions,
    has_elasticities,
    jackknife_error,
    responses_of,
)

PROPERTIES = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
"""Properties that the conclusions compare; a design may vary others, too."""
NAMES = ("closure", "closure_net")
"""Responses that conclusions are about."""
COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", "share", "share_error",
    "share_low", "share_high", "rows", "rows_true",
)  # fmt: skip
MARGIN_COLUMNS = (
    "number", "conclusion", "response", "cycle", "rock", "input", "title", "share", "share_error",
)  # fmt: skip
ByProperty = Mapping[str, np.ndarray]
"""Elasticities (...) by property, of one cycle."""


class Conclusion(NamedTuple):
    """A conclusion, and its margin: a number that is above 0 where the conclusion is true.

    ``margin`` of the elasticities of a cycle and of those of the cycle before it, which only one
    that is ``across`` cycles needs.
    """

    said: str
    margin: Callable[[ByProperty, ByProperty], np.ndarray]
    across: bool = False


class _Margins(NamedTuple):
    """Margins at drawn choices (n,), without each group (groups, n), and of single rows (N,)."""

    drawn: np.ndarray
    left_out: np.ndarray
    single: np.ndarray
    rows: np.ndarray


def _others(elasticities: ByProperty, *without: str) -> list[np.ndarray]:
    return [np.abs(values) for name, values in elasticities.items() if name not in without]


def _least(name: str):
    return lambda e, _: np.min(_others(e, name), axis=0) - np.abs(e[name])


def _most(name: str):
    return lambda e, _: np.abs(e[name]) - np.max(_others(e, name), axis=0)


def _next(name: str, before: str):
    def margin(e: ByProperty, _: ByProperty) -> np.ndarray:
        own = np.abs(e[name])
        return np.minimum(np.abs(e[before]) - own, own - np.max(_others(e, name, before), axis=0))

    return margin


CONCLUSIONS: dict[str, Conclusion] = {
    "1a": Conclusion("Poisson's ratio matters least", _least("poisson_ratio")),
    "2a": Conclusion("Young's modulus matters most", _most("youngs_modulus")),
    "3": Conclusion(
        "Compressive strength matters next after Young's modulus",
        _next("compressive_strength", "youngs_modulus"),
    ),
    "4": Conclusion(
        "JRC matters less than on the cycle before",
        lambda e, before: np.abs(before["jrc"]) - np.abs(e["jrc"]),
        across=True,
    ),
    "5a": Conclusion("Closure rises when E falls", lambda e, _: -e["youngs_modulus"]),
    "5b": Conclusion("Closure rises when sigma_c rises", lambda e, _: e["compressive_strength"]),
    "5c": Conclusion("Closure falls when JRC falls", lambda e, _: e["jrc"]),
}
"""Conclusions of the paper on a cycle, from elasticities of the closure by property."""


def conclusion_tables(design: Design, keys: dict, closed) -> tuple[pd.DataFrame, pd.DataFrame]:
    """For what share of the open choices each conclusion holds, and what its margin goes with.

    Returns
    -------
    conclusions : DataFrame
        ``number``, ``conclusion``, ``response`` (closure, with and without bulk indentation),
        ``cycle``, ``rock`` ("all": in every rock at once), ``share`` of the drawn choices at
        which the fitted elasticities have it, ``share_error`` (jackknife over rows, the same
        rows left out in all rocks), ``share_low`` and ``share_high`` (95 %: by that error, and
        never closer than as many single rows could tell), ``rows`` and at how many of them it
        is true of the row's own changes, noise and all (``rows_true``).
    margins : DataFrame
        Of each rock and ``input``: the ``share`` of the variance of the conclusion's margin over
        the drawn choices that goes with the input's first function, with its jackknife error.

    Both empty where the design does not vary all of `PROPERTIES` over ranges above 0, and without
    responses that are not positive everywhere.

    Raises
    ------
    InputError
        The joints of a rock of the design are missing.
    """
    found = _elasticities(design, keys, closed)
    shares: list[dict] = []
    margins: list[dict] = []
    for name in NAMES:
        for cycle in (1, 2):
            for number, conclusion in CONCLUSIONS.items():
                of_rocks = _of_rocks(design, found, conclusion, name, cycle)
                about: dict = {"number": number, "conclusion": conclusion.said}
                about |= {"response": name, "cycle": cycle}
                shares += [about | row for row in _shares(of_rocks)]
                margins += [about | row for row in _variances(design, of_rocks)]
    return (
        pd.DataFrame(shares, columns=list(COLUMNS)),
        pd.DataFrame(margins, columns=list(MARGIN_COLUMNS)),
    )


def _elasticities(design: Design, keys: dict, closed) -> dict[tuple, Elasticities]:
    """By rock, response and cycle; none where a rock has none to one of `PROPERTIES`."""
    missing = sorted(set(design.rocks) - set(closed))
    if missing:
        raise InputError(f"the joints of {', '.join(missing)} are missing, which the design closes")
    for rock in design.rocks:
        varied = {one.property for one in design.inputs if is_positive(one, keys, rock)}
        if not varied >= set(PROPERTIES):
            return {}
    at = choices_drawn(design)
    return {
        (each.rock, each.name, each.cycle): elasticities_at(design, keys, each, at)
        for each in responses_of(design, closed)
        if each.name in NAMES and has_elasticities(each)
    }


def _of_rocks(design, found, conclusion: Conclusion, name, cycle) -> dict[str, _Margins]:
    """Margins of each rock; none where a rock has no elasticities."""
    properties = {one.name: one.property for one in design.inputs}
    margins = {}
    for rock in design.rocks:
        own = found.get((rock, name, cycle))
        before = found.get((rock, name, cycle - 1)) if conclusion.across else own
        if own is None or before is None:
            return {}
        rows = np.intersect1d(own.rows, before.rows)

        def read(part, own=own, before=before) -> np.ndarray:
            pair = (
                {
                    properties[one]: values
                    for one, values in zip(each.inputs, part(each), strict=True)
                    if properties[one] in PROPERTIES
                }
                for each in (own, before)
            )
            return conclusion.margin(*pair)

        margins[rock] = _Margins(
            read(lambda each: each.drawn),
            read(lambda each: each.left_out),
            read(lambda each, rows=rows: each.single[:, np.isin(each.rows, rows)]),
            rows,
        )
    return margins


def _shares(of_rocks: dict[str, _Margins]) -> Iterator[dict]:
    """Of each rock, and of all at once."""
    if not of_rocks:
        return
    for rock, own in of_rocks.items():
        yield {"rock": rock} | _share(own.drawn > 0.0, own.left_out > 0.0, own.single > 0.0)
    together = of_rocks.values()
    rows = set.intersection(*(set(own.rows.tolist()) for own in together))
    single = [own.single[np.isin(own.rows, list(rows))] > 0.0 for own in together]
    yield {"rock": "all"} | _share(
        np.all([own.drawn > 0.0 for own in together], axis=0),
        np.all([own.left_out > 0.0 for own in together], axis=0),
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


def _variances(design: Design, of_rocks: dict[str, _Margins]) -> Iterator[dict]:
    """Shares of a margin's variance over the choices, of each rock and input."""
    functions = first_functions(choices_drawn(design), design.values)
    matrix = np.column_stack([np.ones(len(functions)), functions])
    for rock, own in of_rocks.items():
        margins = np.vstack([own.drawn, own.left_out])
        slopes = np.linalg.lstsq(matrix, margins.T, rcond=None)[0][1:]
        variances = margins.var(axis=1)
        parts = functions.var(axis=0)[:, None] * slopes**2
        shares = np.divide(parts, variances, out=np.full_like(parts, np.nan), where=variances > 0)
        errors = jackknife_error(shares[:, 1:].T)
        for place, one in enumerate(design.inputs):
            row = {"rock": rock, "input": one.name, "title": one.title}
            yield row | {"share": shares[place, 0], "share_error": errors[place]}
