"""Which of the paper's conclusions hold, whatever is chosen of what the paper leaves open."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import pandas as pd

from jointclosure.config.properties import PARAMETERS
from jointclosure.statistics.orthonormal import Fit
from jointclosure.studies.global_sensitivity.design import Design
from jointclosure.studies.global_sensitivity.table import (
    Responses,
    choices_drawn,
    elasticities_at,
    fit_of,
    has_elasticities,
    jackknifed,
    responses_of,
    spreads_of,
)

Elasticities = Mapping[str, np.ndarray]
"""Of a closure by property, each (n,) over the choices drawn."""

CONCLUSIONS: dict[str, tuple[str, Callable[[Elasticities], np.ndarray]]] = {
    "1a": ("Poisson's ratio matters least", lambda e: _least(e, "poisson_ratio")),
    "2a": ("Young's modulus matters most", lambda e: _most(e, "youngs_modulus")),
    "3": (
        "Compressive strength matters next after Young's modulus",
        lambda e: _next(e, "compressive_strength", "youngs_modulus"),
    ),
    "5a": ("Closure rises when E falls", lambda e: e["youngs_modulus"] < 0.0),
    "5b": ("Closure rises when sigma_c rises", lambda e: e["compressive_strength"] > 0.0),
    "5c": ("Closure falls when JRC falls", lambda e: e["jrc"] > 0.0),
}
"""Conclusions of the paper on one cycle, from elasticities of the closure by property."""


def conclusion_table(design: Design, keys: dict, closed) -> pd.DataFrame:
    """For what share of the open choices each conclusion holds, in each rock and in all.

    Returns
    -------
    DataFrame
        ``number``, ``conclusion``, ``response`` (closure, with and without bulk indentation),
        ``cycle``, ``rock`` ("all": in every rock at once), ``share`` and ``share_error``
        (jackknife; that of all rocks is the largest of theirs). Empty where not all four
        properties vary; without those of a response that is not positive everywhere.
    """
    names = [each.property for each in design.inputs if each.property]
    if set(names) != set(PARAMETERS):
        return pd.DataFrame()
    rows: list[dict] = []
    at = choices_drawn(design)
    for name in ("closure", "closure_net"):
        for cycle in (1, 2):
            own = [
                each
                for each in responses_of(design, closed)
                if (each.name, each.cycle) == (name, cycle)
            ]
            if own and all(map(has_elasticities, own)):
                rows += _conclusions(design, keys, own, at)
    return pd.DataFrame(rows)


def _conclusions(
    design: Design, keys: dict, own: list[Responses], at: np.ndarray
) -> Iterator[dict]:
    held: dict[str, list[np.ndarray]] = {number: [] for number in CONCLUSIONS}
    errors: dict[str, list[float]] = {number: [] for number in CONCLUSIONS}
    for each in own:
        spreads = spreads_of(design, keys, each.rock)
        properties = [one.property for one in design.inputs if one.name in spreads]

        def read(fit: Fit, spreads=spreads, properties=properties) -> np.ndarray:
            found = elasticities_at(fit, at, spreads)
            named = dict(zip(properties, found.T, strict=True))
            return np.stack([holds(named) for _, holds in CONCLUSIONS.values()]).astype(float)

        whole = read(fit_of(each.points, each.values, design.values))
        _, error = jackknifed(each, design.values, lambda fit, read=read: read(fit).mean(axis=1))
        for place, (number, (said, _)) in enumerate(CONCLUSIONS.items()):
            held[number].append(whole[place] > 0.5)
            errors[number].append(float(error[place]))
            yield _conclusion(number, said, each, each.rock, whole[place].mean(), error[place])
    for number, (said, _) in CONCLUSIONS.items():
        together = np.all(held[number], axis=0)
        yield _conclusion(number, said, own[0], "all", together.mean(), max(errors[number]))


def _conclusion(number, said, each: Responses, rock, share, error) -> dict:
    return {
        "number": number,
        "conclusion": said,
        "response": each.name,
        "cycle": each.cycle,
        "rock": rock,
        "share": float(share),
        "share_error": float(error),
    }


def _others(elasticities: Elasticities, *without: str) -> list[np.ndarray]:
    return [np.abs(values) for name, values in elasticities.items() if name not in without]


def _least(elasticities: Elasticities, name: str) -> np.ndarray:
    return np.abs(elasticities[name]) < np.min(_others(elasticities, name), axis=0)


def _most(elasticities: Elasticities, name: str) -> np.ndarray:
    return np.abs(elasticities[name]) > np.max(_others(elasticities, name), axis=0)


def _next(elasticities: Elasticities, name: str, before: str) -> np.ndarray:
    own = np.abs(elasticities[name])
    rest = np.max(_others(elasticities, name, before), axis=0)
    return (own < np.abs(elasticities[before])) & (own > rest)
