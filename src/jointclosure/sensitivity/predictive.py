"""What repetitions of the study would publish in Table 3, and whether the paper's is one of them.

Repetitions are drawn from a pool (`jointclosure.statistics.drawn_studies`): n surfaces for every
level, independently, as the paper did. The null is a rock whose parameters have no effect at all:
every level draws from the base case.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.found import TARGET
from jointclosure.config.properties import PARAMETERS, PROPERTIES
from jointclosure.sensitivity.intervals import UNPAIRED
from jointclosure.sensitivity.responses import (
    RockSample,
    rock_sample,
    rocks_of,
    sensitivities,
)
from jointclosure.statistics.drawn_studies import (
    RESAMPLED_POOLS,
    Design,
    DrawnResponse,
    draw_studies,
    pool_error,
    repetitions_of_pool,
    resampled_pools,
    without_effect,
)
from jointclosure.statistics.joint_tests import joint_test, p_of_table
from jointclosure.statistics.predictive import length_distribution, share_as_short, two_sided_p
from jointclosure.statistics.randomness import generator, seed_of

Entry = tuple[str, str, int]
"""Rock, parameter, cycle."""

_NOISY = ("poisson_ratio", "youngs_modulus", "compressive_strength")
"""Parameters whose first-cycle entries are tested together: is anything seen but noise?"""


class Resampled(NamedTuple):
    """Lengths [SI] (R,) by entry from one resampled pool, as of `Predictive`."""

    lengths: dict[Entry, np.ndarray]
    null: dict[Entry, np.ndarray]


class Predictive(NamedTuple):
    """Lengths [SI] (R,) of repetitions by entry; of the model, and of one without any effect.

    ``bases``: the rock's own value [SI] of each entry. ``pool``: surfaces of each rock that they
    were drawn from. ``resampled``: fewer repetitions from pools of other surfaces, by which
    probabilities and medians bear the error of the pool.
    """

    lengths: dict[Entry, np.ndarray]
    null: dict[Entry, np.ndarray]
    bases: dict[Entry, float]
    pool: dict[str, int]
    resampled: list[Resampled]

    def pools(self) -> list[Resampled]:
        """Lengths from the pool itself, and from resampled ones."""
        return [Resampled(self.lengths, self.null), *self.resampled]


def predictive(
    ensemble: xr.Dataset,
    design: Design,
    repetitions: int,
    root_seed: int,
    pools: int = RESAMPLED_POOLS,
) -> Predictive:
    """Draw repetitions of the study from a pool.

    Parameters
    ----------
    ensemble : Dataset
        The pool; without one, the study itself.
    design : Design
        How many surfaces a study draws, and its test.
    repetitions : int
    root_seed : int
        Of the study; the draws have streams of their own.
    pools : int
        Pools of other surfaces, resampled from this one.
    """
    samples = maximum_closures(ensemble)
    pool = sensitivities(samples)
    cycles = [int(cycle) for cycle in ensemble.cycle.values]

    def drawn(which, times: int, random: np.random.Generator) -> dict[Entry, np.ndarray]:
        return entries(draw_studies(which, design, times, random), cycles)

    def stream(name: str) -> np.random.Generator:
        return generator(seed_of(root_seed, "predictive", name))

    random, times = stream("pools"), repetitions_of_pool(repetitions)
    resampled = [
        Resampled(drawn(own, times, random), drawn(without_effect(own), times, random))
        for own in resampled_pools(pool, random, pools)
    ]
    return Predictive(
        drawn(pool, repetitions, stream("model")),
        drawn(without_effect(pool), repetitions, stream("null")),
        {(*key, cycle): each.base for key, each in pool.items() for cycle in cycles},
        {sample.rock: sample.values.shape[-1] for sample in samples},
        resampled,
    )


def median_pool_error(found: Predictive, entry: Entry) -> float:
    """Standard error of a median length [SI] from the pool's surfaces; NaN where it is infinite."""
    medians = [length_distribution(each.lengths[entry]).median for each in found.resampled]
    return float(np.std(medians, ddof=1)) if medians and np.isfinite(medians).all() else np.nan


def _with_pool(error: float, shares: list[float], repetitions: int) -> float:
    """Standard error of a probability: of the repetitions, and of the pool."""
    of_pool = float(pool_error(shares, repetitions)) if len(shares) > 1 else 0.0
    return float(np.hypot(error, of_pool))


def maximum_closures(ensemble: xr.Dataset) -> list[RockSample]:
    """Maximum closures of all rocks of which two surfaces or more succeeded in every case."""
    found = [rock_sample(ensemble, rock, {TARGET: ensemble[TARGET]}) for rock in rocks_of(ensemble)]
    return [sample for sample in found if sample.levels and sample.values.shape[-1] > 1]


def entries(
    drawn: dict[tuple[str, str], DrawnResponse], cycles: list[int]
) -> dict[Entry, np.ndarray]:
    """Lengths (R,) by entry of Table 3; the first targets are the maximum closures by cycle."""
    return {
        (rock, parameter, cycle): response.lengths[:, i]
        for (rock, parameter), response in drawn.items()
        for i, cycle in enumerate(cycles)
    }


def lengths_dataset(found: Predictive) -> xr.Dataset:
    """All lengths drawn (entry, repetition) in percent of the rock's own value, for figures.

    ``percent`` of the model, ``null_percent`` without any effect; infinite where no root.
    """
    keys = list(found.lengths)
    variables = {}
    for name, drawn, text in (
        ("percent", found.lengths, "length of the indifference interval"),
        ("null_percent", found.null, "the same where no parameter has an effect"),
    ):
        rows = [100.0 * drawn[key] / abs(found.bases[key]) for key in keys]
        repetitions = next(iter(drawn.values())).size if keys else 0
        values = np.array(rows).reshape(len(keys), repetitions).astype(np.float32)
        about = {"long_name": f"{text}, of the rock's own value", "units": "percent"}
        variables[name] = (("entry", "repetition"), values, about)
    columns = zip(*keys, strict=True) if keys else ((), (), ())
    coordinates = {
        name: ("entry", np.array(column, dtype=object if name != "cycle" else int))
        for name, column in zip(("rock", "parameter", "cycle"), columns, strict=True)
    }
    return xr.Dataset(variables, coords=coordinates)


def predictive_table(found: Predictive, paper: pd.DataFrame) -> pd.DataFrame:
    """Each entry's distribution over repetitions, with the paper's value in it.

    Parameters
    ----------
    found : Predictive
    paper : DataFrame
        The paper's Table 3.

    Returns
    -------
    DataFrame
        In the units of Table 1; ``test`` of the lengths. Ends of ranges are infinite where too
        many repetitions have no root. ``median_error`` is from the number of repetitions,
        ``median_pool_error`` from that of the pool's surfaces, which the ranges contain. ``p``:
        two-sided, of the paper's entry; ``null_p``: probability of a length as short as the
        paper's where the parameter has no effect. Errors of probabilities are of repetitions and
        of the pool's surfaces
        together. Without these for other rocks.
    """
    published = _published(paper)
    rows = []
    for entry, lengths in found.lengths.items():
        rock, parameter, cycle = entry
        unit, own = PROPERTIES[parameter], found.bases[entry]
        summary = length_distribution(lengths)._asdict()
        share = summary.pop("share_without_root")
        row = {"rock": rock, "parameter": parameter, "cycle": cycle, "unit": unit.unit}
        row["test"] = UNPAIRED
        row |= {"base": own / unit.size, "pool": found.pool[rock], "repetitions": lengths.size}
        row |= {name: value / unit.size for name, value in summary.items()}
        row["median_percent"] = 100.0 * summary["median"] / own if own else np.nan
        row["median_error"] = _median_error(lengths) / unit.size
        row["median_pool_error"] = median_pool_error(found, entry) / unit.size
        shares = [float(np.isinf(each.lengths[entry]).mean()) for each in found.resampled]
        times = found.resampled[0].lengths[entry].size if shares else 0
        error = _with_pool(_error(share, lengths.size), shares, times)
        row |= {"share_without_root": share, "share_error": error}
        row["null_share_without_root"] = float(np.mean(np.isinf(found.null[entry])))
        if entry in published:
            row |= _of_paper(published[entry], entry, found, unit.size)
        rows.append(row)
    return pd.DataFrame(rows, columns=None if rows else ["rock", "parameter", "cycle"])


def _of_paper(length: float, entry: Entry, found: Predictive, size: float) -> dict:
    row = {"paper_length": length}
    for prefix, probability in (("", two_sided_p), ("null_", share_as_short)):
        of_model, *resampled = (
            (each.null if prefix else each.lengths)[entry] for each in found.pools()
        )
        p = probability(of_model, length * size)
        again = [probability(each, length * size) for each in resampled]
        sides = 1.0 if prefix else 2.0
        error = sides * _error(p / sides, of_model.size)
        row[f"{prefix}p"] = p
        row[f"{prefix}p_error"] = _with_pool(error, again, resampled[0].size if again else 0)
    return row


def joint_table(found: Predictive, paper: pd.DataFrame) -> pd.DataFrame:
    """Joint tests of the paper's entries: each row, each cycle, and the whole table.

    ``p`` is the share of repetitions that are as unlikely or more, ``null_p`` the same where no
    parameter has an effect; dashes count with their probability. Errors of both are of repetitions
    and of the pool's surfaces together. Empty without the paper's rocks.
    """
    published = {
        entry: length for entry, length in _published(paper).items() if entry in found.lengths
    }
    rows = []
    for group, chosen in _groups(list(published)).items():
        observed = np.array([published[e] * PROPERTIES[e[1]].size for e in chosen])
        row = {"entries": group, "number": len(chosen), "dashes": int(np.isnan(observed).sum())}
        for prefix in ("", "null_"):
            lengths, *resampled = (
                np.stack([(each.null if prefix else each.lengths)[e] for e in chosen], axis=1)
                for each in found.pools()
            )
            if np.any(lengths == 0.0):  # a closure without any scatter: nothing is drawn
                continue
            test = joint_test(lengths, observed)
            again = [
                np.nan if np.any(each == 0.0) else p_of_table(each, observed) for each in resampled
            ]
            times = len(resampled[0]) if resampled else 0
            row |= {
                f"{prefix}log_likelihood": test.log_likelihood,
                f"{prefix}log_likelihood_error": test.standard_error,
                f"{prefix}p": test.p,
                f"{prefix}p_error": _with_pool(_error(test.p, len(lengths)), again, times),
            }
        rows.append(row)
    columns = ["entries", "number", "dashes"]
    columns += [
        f"{prefix}{name}"
        for prefix in ("", "null_")
        for name in ("log_likelihood", "log_likelihood_error", "p", "p_error")
    ]
    return pd.DataFrame(rows, columns=columns)


def _groups(published: list[Entry]) -> dict[str, list[Entry]]:
    groups: dict[str, list[Entry]] = {"all": published}
    cycles = sorted({cycle for _, _, cycle in published})
    for cycle in cycles:
        groups[f"cycle {cycle}"] = [e for e in published if e[2] == cycle]
    groups["cycle 1 without JRC"] = [e for e in published if e[2] == 1 and e[1] in _NOISY]
    for parameter in PARAMETERS:
        for cycle in cycles:
            name = f"{PROPERTIES[parameter].title}, cycle {cycle}"
            groups[name] = [e for e in published if e[1:] == (parameter, cycle)]
    return {name: chosen for name, chosen in groups.items() if chosen}


def _published(paper: pd.DataFrame) -> dict[Entry, float]:
    """The paper's lengths in the units of Table 1, NaN for a dash."""
    return {
        (row.rock, row.parameter, int(row.cycle)): float(row.paper_length)
        for row in paper.itertuples()
    }


def _error(share: float, repetitions: int) -> float:
    return float(np.sqrt(share * (1.0 - share) / repetitions))


def _median_error(lengths: np.ndarray) -> float:
    """Half the range between the quantiles one standard deviation of a rank off the middle."""
    off = 0.5 / np.sqrt(lengths.size)
    low, high = np.quantile(lengths, [0.5 - off, min(0.5 + off, 1.0)], method="nearest")
    return float(0.5 * (high - low)) if np.isfinite(high) else np.inf
