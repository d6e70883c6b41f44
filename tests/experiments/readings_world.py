"""A world in which it is known which reading is true: closures of rocks made by a formula."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.properties import PROPERTIES
from jointclosure.experiments.readings.likelihood import Question
from jointclosure.experiments.readings.pools import sensitivities_of
from jointclosure.statistics.drawn_studies import Design, draw_studies
from jointclosure.statistics.randomness import generator, seed_of

PARAMETERS = {
    rock: {
        "poisson_ratio": ((0.15, 0.25, 0.35), 0.25),
        "youngs_modulus": ((60e9 * size, 66e9 * size, 72e9 * size), 66e9 * size),
        "compressive_strength": ((143e6 * size, 159e6 * size, 175e6 * size), 159e6 * size),
        "jrc": ((5.0, 6.5, 8.0), 6.5),
    }
    for rock, size in (("slate", 1.0), ("limestone", 0.7))
}
ELASTICITIES = {
    "poisson_ratio": (0.02, 0.04),
    "youngs_modulus": (-0.4, -1.0),
    "compressive_strength": (-0.3, 0.6),
    "jrc": (0.8, 0.1),
}
SCATTER = np.array([0.2, 0.1])
LOOPS = np.array([0.5, 0.0])  # over the closure


def closures(rock, count, scatter=1.0, factor=1.0, first=0):
    """Closures (case, realization, cycle) of a rock; the same surfaces for the same numbers."""
    cases, means = [("base", np.nan)], [np.ones(2)]
    for name, (levels, base) in PARAMETERS[rock].items():
        for level in (levels[0], levels[-1]):
            cases.append((name, level))
            means.append((level / base) ** (np.array(ELASTICITIES[name]) * factor))
    numbers = np.arange(first, first + count)
    noise = np.array([generator(seed_of(7, rock, int(n))).standard_normal(2) for n in numbers])
    values = 1e-3 * np.array(means)[:, None] * (1.0 + scatter * SCATTER * noise)
    return xr.DataArray(
        values,
        dims=("case", "realization", "cycle"),
        coords={
            "realization": numbers,
            "cycle": [1, 2],
            "parameter": ("case", [name for name, _ in cases]),
            "value": ("case", [value for _, value in cases]),
            "loop": (("realization", "cycle"), values[0] * LOOPS),
        },
    )


def world(count, **truth):
    """`closures` of all rocks."""
    return {rock: closures(rock, count, **truth) for rock in PARAMETERS}


def table_3(seed, **truth):
    """A study of 20 independent draws in a world, as the published lengths."""
    drawn = draw_studies(
        sensitivities_of(world(400, **truth), PARAMETERS), Design(), 1, np.random.default_rng(seed)
    )
    return {
        (rock, parameter, cycle): length if np.isfinite(length) else np.nan
        for (rock, parameter), response in drawn.items()
        for cycle, length in zip((1, 2), response.lengths[0], strict=True)
    }


def question(published, repetitions=300, groups=6):
    """The question that readings of this world are asked."""
    return Question(published, PARAMETERS, Design(), repetitions, groups, 1)


def as_paper_table(published):
    """Published lengths as the paper's table has them: in GPa and MPa."""
    rows = [
        {"rock": r, "parameter": p, "cycle": c, "paper_length": v / PROPERTIES[p].size}
        for (r, p, c), v in published.items()
    ]
    return pd.DataFrame(rows)
