"""Distributions of the lengths of Table 3 over repetitions of a study, and tests of the paper's.

A repetition is drawn from a pool of joints: n surfaces for every level, independently, as in the
paper. In the null model no parameter has an effect: all levels are drawn from the base case.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics import repetitions as repeated
from jointclosure.statistics.randomness import generator, seed_of
from studies.paper.claims import TARGET
from studies.paper.closure_tables import UNPAIRED
from studies.paper.responses import (
    RockSample,
    percent_of_value,
    rock_sample,
    rocks_of,
    sensitivities,
)

Entry = tuple[str, str, int]
"""Entry of Table 3: rock, parameter, cycle."""
Lengths = dict[Entry, np.ndarray]
"""Lengths (R,) [SI] of indifference intervals over R repetitions, by entry; infinite: no root."""

_NOISY = ("poisson_ratio", "youngs_modulus", "compressive_strength")
"""Parameters whose entries of the first cycle are tested together for any effect beyond noise."""
AGAIN = 16
"""Number of further sets of repetitions from the pool itself, by which the scatter of p between
sets is known. Eight of them together have as many repetitions as the first set."""
_TEST = ("log_likelihood", "log_likelihood_error", "p", "p_error", "p_pool_error")
"""Columns of a joint test of several entries."""


class Predictive(NamedTuple):
    """Sets of repetitions of a study, by the model and by the null model."""

    model: list[Lengths]  # first from the pool itself, then from resampled pools, for its error
    null: list[Lengths]  # the same by the null model
    bases: dict[Entry, float]  # the rock's value of the parameter [SI]
    pool: dict[str, int]  # number of surfaces of each rock
    twice: list[Lengths]  # a second set by the model from each resampled pool
    same: list[Lengths]  # further sets by the model from the pool itself


def predictive(
    ensemble: xr.Dataset,
    design: repeated.Design,
    repetitions: int,
    root_seed: int,
    pools: int = repeated.RESAMPLED_POOLS,
) -> Predictive:
    """Draw sets of repetitions of a study from a pool, and from resampled pools.

    ``ensemble`` is the pool, ``design`` that of a repetition, and ``pools`` the number of resampled
    pools. Random numbers follow from ``root_seed``.
    """
    samples = maximum_closures(ensemble)
    pool = sensitivities(samples)
    cycles = [int(cycle) for cycle in ensemble.cycle.values]

    def drawn(which, times: int, random: np.random.Generator) -> Lengths:
        return {  # the first targets are maximum closures by cycle
            (*key, cycle): response.lengths[:, i]
            for key, response in repeated.draw_studies(which, design, times, random).items()
            for i, cycle in enumerate(cycles)
        }

    def stream(name: str) -> np.random.Generator:
        return generator(seed_of(root_seed, "predictive", name))

    random = stream("pools")
    times = repeated.repetitions_of_pool(repetitions)
    again = stream("again")
    twice = []
    model = [drawn(pool, repetitions, stream("model"))]
    null = [drawn(repeated.parameters_without_effect(pool), repetitions, stream("null"))]
    for sample in repeated.resampled_pools(pool, random, pools):
        model.append(drawn(sample, times, random))
        null.append(drawn(repeated.parameters_without_effect(sample), times, random))
        twice.append(drawn(sample, times, again))
    bases = {(*key, cycle): varied.base for key, varied in pool.items() for cycle in cycles}
    sizes = {sample.rock: sample.values.shape[-1] for sample in samples}
    same = [drawn(pool, times, again) for _ in range(AGAIN if pools else 0)]
    return Predictive(model, null, bases, sizes, twice, same)


def median_pool_error(lengths: Predictive, entry: Entry) -> float:
    """Return the standard error of the median length [SI] of an entry that is due to the pool.

    It is the standard deviation of the medians of resampled pools; NaN if one is infinite, or
    without such pools.
    """
    medians = [
        repeated.length_distribution(resampled[entry]).median for resampled in lengths.model[1:]
    ]
    return float(np.std(medians, ddof=1)) if medians and np.isfinite(medians).all() else np.nan


def _error_with_pool(error: float, shares: list[float], resampled: list[np.ndarray]) -> float:
    """Return the standard error of a probability with the part that is due to the pool.

    ``error`` is the part due to the number of repetitions; ``shares`` are the probabilities by
    resampled pools, of which ``resampled`` has the lengths (R,). The pool's part is 0 for fewer
    than two of these.
    """
    of_pool = float(repeated.pool_error(shares, resampled[0].size)) if len(shares) > 1 else 0.0
    return float(np.hypot(error, of_pool))


def maximum_closures(ensemble: xr.Dataset) -> list[RockSample]:
    """Return the maximum closures of the rocks of an ensemble for which repetitions can be drawn.

    These rocks have levels, and at least two surfaces that succeeded in all of their cases.
    """
    samples = [
        rock_sample(ensemble, rock, {TARGET: ensemble[TARGET]}) for rock in rocks_of(ensemble)
    ]
    return [sample for sample in samples if sample.levels and sample.values.shape[-1] > 1]


def lengths_dataset(lengths: Predictive) -> xr.Dataset:
    """Return the lengths (entry, repetition) in percent of the rock's value, for figures.

    They are those of the first sets, by the model and by the null model.
    """
    keys = list(lengths.bases)
    variables = {}
    for name, drawn, text in (
        ("percent", lengths.model[0], "length of the indifference interval"),
        ("null_percent", lengths.null[0], "the same where no parameter has an effect"),
    ):
        rows = [percent_of_value(drawn[key], lengths.bases[key]) for key in keys]
        values = np.array(rows, dtype=np.float32) if rows else np.empty((0, 0), dtype=np.float32)
        about = {"long_name": f"{text}, of the rock's own value", "units": "percent"}
        variables[name] = (("entry", "repetition"), values, about)
    columns = zip(*keys, strict=True) if keys else ((), (), ())
    coordinates = {
        name: ("entry", np.array(column, dtype=object if name != "cycle" else int))
        for name, column in zip(("rock", "parameter", "cycle"), columns, strict=True)
    }
    return xr.Dataset(variables, coords=coordinates)


def predictive_table(lengths_of_studies: Predictive, paper: pd.DataFrame) -> pd.DataFrame:
    """Tabulate the distribution of each length of Table 3 over repetitions, in units of Table 1.

    ``share_without_root`` and ``share_zero`` are the shares of repetitions with an infinite length
    and with a length of 0. For entries that the paper has (``paper``), ``p`` is the probability, by
    the model, of a length at least as far from the middle as the paper's. ``null_p`` is the
    probability, by the null model, of a length at least as short as the paper's.
    """
    published = _published(paper)
    rows = []
    for entry, lengths in lengths_of_studies.model[0].items():
        rock, parameter, cycle = entry
        unit = PROPERTIES[parameter]
        base = lengths_of_studies.bases[entry]
        summary = repeated.length_distribution(lengths)._asdict()
        share = summary.pop("share_without_root")
        zero = summary.pop("share_zero")
        row = {"rock": rock, "parameter": parameter, "cycle": cycle, "unit": unit.unit}
        row |= {"test": UNPAIRED, "base": base / unit.size}
        row |= {"pool": lengths_of_studies.pool[rock], "repetitions": lengths.size}
        row |= {name: value / unit.size for name, value in summary.items()}
        row["median_percent"] = percent_of_value(summary["median"], base)
        row["median_error"] = _median_error(lengths) / unit.size
        row["median_pool_error"] = median_pool_error(lengths_of_studies, entry) / unit.size
        resampled = [drawn[entry] for drawn in lengths_of_studies.model[1:]]
        shares = [float(np.isinf(drawn).mean()) for drawn in resampled]
        error = _error_with_pool(_error(share, lengths.size), shares, resampled)
        row |= {"share_without_root": share, "share_error": error}
        null = repeated.length_distribution(lengths_of_studies.null[0][entry])
        row |= {"null_share_without_root": null.share_without_root}
        row |= {"share_zero": zero, "null_share_zero": null.share_zero}
        if entry in published:
            row |= _of_paper(published[entry], entry, lengths_of_studies, unit.size)
        rows.append(row)
    return pd.DataFrame(rows, columns=None if rows else ["rock", "parameter", "cycle"])


def _of_paper(length: float, entry: Entry, lengths_of_studies: Predictive, size: float) -> dict:
    row = {"paper_length": length}
    for prefix, drawn, probability, sides in (
        ("", lengths_of_studies.model, repeated.two_sided_p, 2.0),
        ("null_", lengths_of_studies.null, repeated.share_as_short, 1.0),
    ):
        of_pool, *resampled = (lengths[entry] for lengths in drawn)
        p = probability(of_pool, length * size)
        again = [probability(lengths, length * size) for lengths in resampled]
        error = sides * _error(p / sides, of_pool.size)
        row |= {f"{prefix}p": p, f"{prefix}p_error": _error_with_pool(error, again, resampled)}
    return row


def joint_table(lengths_of_studies: Predictive, paper: pd.DataFrame) -> pd.DataFrame:
    """Tabulate joint tests of the paper's entries: of each row, of each cycle, of the whole table.

    ``p`` is the share of repetitions by the model that are as likely as the paper's entries or less
    likely; dashes (no root) count too. It scatters more than a binomial share, as densities are
    estimated. ``null_p`` is the share by the null model. Tests with an entry in which a repetition
    has a length of 0 are not defined, and are left empty.
    """
    published = {
        entry: length * PROPERTIES[entry[1]].size
        for entry, length in _published(paper).items()
        if entry in lengths_of_studies.bases
    }
    columns = ["entries", "number", "dashes", *_TEST, *(f"null_{name}" for name in _TEST)]
    if not published:
        return pd.DataFrame(columns=columns)
    entries = list(published)
    observed = np.array([published[entry] for entry in entries])
    model, null, _, _, twice, same = lengths_of_studies
    evaluated = {
        "": _evaluated(model, twice, same, entries, observed),
        "null_": _evaluated(null, [], [], entries, observed),
    }
    rows = []
    for group, chosen in _groups(entries).items():
        places = [entries.index(entry) for entry in chosen]
        dashes = int(np.isnan(observed[places]).sum())
        row = {"entries": group, "number": len(chosen), "dashes": dashes}
        for prefix, likelihoods in evaluated.items():
            row |= {f"{prefix}{name}": x for name, x in likelihoods.test(places).items()}
        rows.append(row)
    return pd.DataFrame(rows, columns=columns)


class _Evaluated(NamedTuple):
    """Log-likelihoods by entry under sets of repetitions, computed once for all joint tests.

    Crossed ones are of the paper's entries and of repetitions of the set, under halves of the set.
    """

    jackknifed: repeated.JackknifedLikelihood  # of the paper's entries under the first set
    crossed: repeated.CrossedLikelihoods  # of the first set
    resampled: list[repeated.CrossedLikelihoods]  # of one set from each resampled pool
    further: list[repeated.CrossedLikelihoods]  # of a second set from each resampled pool
    same: list[repeated.CrossedLikelihoods]  # of sets from the pool, as large as the first set
    sizes: tuple[int, int]  # numbers of repetitions of the first set and of a resampled pool's

    def test(self, places: list[int]) -> dict[str, float]:
        """Return the columns `_TEST` of the test of the entries at ``places``.

        There are none if the test is not defined, as for closures without scatter.
        """
        log_likelihood, standard_error, p = self.jackknifed.of(places).test(self.crossed.of(places))
        if np.isnan(p):
            return {}
        shares, twice_p, again = (
            [crossed.of(places).p() for crossed in sets]
            for sets in (self.resampled, self.further, self.same)
        )
        repetitions, times = self.sizes
        of_pool = float(repeated.pool_error(shares, times, twice_p)) if len(shares) > 1 else 0.0
        of_repetitions = _error(p, repetitions)
        if again:
            of_repetitions = float(np.nanstd([p, *again], ddof=1))
        error = float(np.hypot(of_repetitions, of_pool))
        numbers = (log_likelihood, standard_error, p, error, of_pool)
        return dict(zip(_TEST, numbers, strict=True))


def _evaluated(
    drawn: list[Lengths],
    twice: list[Lengths],
    same: list[Lengths],
    entries: list[Entry],
    observed: np.ndarray,
) -> _Evaluated:
    """Return the likelihoods of the published lengths under all sets of repetitions.

    ``observed`` (entries,) [SI] are the published lengths, NaN for a dash. ``drawn``, ``twice`` and
    ``same`` are as in `Predictive`.
    """
    (lengths, *resampled), further, again = (
        _tables(sets, entries) for sets in (drawn, twice, same)
    )
    joined = max(len(lengths) // len(again[0]), 1) if again else 1
    whole = [np.concatenate(again[i : i + joined]) for i in range(0, len(again), joined)]
    crossed, of_resampled, of_further, of_same = (
        [repeated.crossed_likelihoods(one, observed) for one in sets]
        for sets in ([lengths], resampled, further, whole)
    )
    jackknifed = repeated.jackknifed_likelihood(lengths, observed)
    sizes = len(lengths), len(resampled[0]) if resampled else 0
    return _Evaluated(jackknifed, crossed[0], of_resampled, of_further, of_same, sizes)


def _tables(drawn: list[Lengths], entries: list[Entry]) -> list[np.ndarray]:
    """Return a table (R, entries) of lengths [SI] for each set of repetitions."""
    return [np.array([lengths[entry] for entry in entries]).T for lengths in drawn]


def _groups(published: list[Entry]) -> dict[str, list[Entry]]:
    cycles = sorted({cycle for _, _, cycle in published})
    groups = {"all": published}
    groups |= {f"cycle {c}": [entry for entry in published if entry[2] == c] for c in cycles}
    noisy = [entry for entry in published if entry[2] == 1 and entry[1] in _NOISY]
    groups["cycle 1 without JRC"] = noisy
    for parameter, about in PROPERTIES.items():
        for cycle in cycles:
            chosen = [entry for entry in published if entry[1:] == (parameter, cycle)]
            groups[f"{about.title}, cycle {cycle}"] = chosen
    return {name: chosen for name, chosen in groups.items() if chosen}


def _published(paper: pd.DataFrame) -> dict[Entry, float]:
    """Return the paper's lengths by entry, in the units of Table 1; NaN for a dash."""
    return {
        (row.rock, row.parameter, int(row.cycle)): float(row.paper_length)
        for row in paper.itertuples()
    }


def _error(share: float, repetitions: int) -> float:
    return float(np.sqrt(share * (1.0 - share) / repetitions))


def _median_error(lengths: np.ndarray) -> float:
    """Return the standard error of the median of lengths (n,), by the scatter of its rank.

    It is half the range between the lengths at one standard deviation of the rank below and above;
    infinite if the upper one is.
    """
    off = 0.5 / np.sqrt(lengths.size)
    low, high = np.quantile(lengths, [0.5 - off, 0.5 + off], method="nearest")
    return float(0.5 * (high - low)) if np.isfinite(high) else np.inf
