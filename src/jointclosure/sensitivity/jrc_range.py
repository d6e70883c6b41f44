"""A JRC that is known to a range only (the paper's limit vi): what repetitions would publish.

A joint's JRC is drawn uniformly within a half-width of its case's. How its closure answers is
known surface by surface: the pool closes each at all levels of JRC, and the logarithm of the
closure is interpolated by the polynomial through them. At changed levels of other parameters it
is taken to answer by the same factor.
"""

from collections.abc import Iterable

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.found import NET, TARGET
from jointclosure.config.typed import Configuration
from jointclosure.inputs import InputError
from jointclosure.sensitivity.claims import Evidence, judge_claims
from jointclosure.sensitivity.predictive import (
    joint_table,
    median_pool_error,
    predictive,
)
from jointclosure.sensitivity.responses import (
    levels_of,
    rocks_of,
    same_surfaces,
)
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import mean_of, variation_of

_ORDER = ("case", "realization", "cycle")
REPEATS = 4
"""Times that a JRC is drawn for every joint of the pool; their scatter is the error of it."""


def check_jrc_varies(configuration: Configuration) -> None:
    """Whether a study tells how closures answer a change of JRC, surface by surface.

    Raises
    ------
    InputError
        Naming a rock whose JRC is not varied, or a study without common surfaces.
    """
    for name, rock in configuration.rocks.items():
        if len(rock.levels.get("jrc", ())) < 2:
            raise InputError(f"rocks.{name}.levels.jrc: must be given where a JRC is a range")
    study = configuration.study
    if not study.pool and study.draws != "common":
        raise InputError(
            "study.pool: must be given where a JRC is a range, or study.draws be common"
        )


def with_jrc_range(pool: xr.Dataset, half_width: float, random: np.random.Generator) -> xr.Dataset:
    """A pool whose joints have a JRC drawn within a half-width of that of their case.

    Parameters
    ----------
    pool : Dataset
        Common surfaces at all levels of JRC.
    half_width : float
    random : Generator

    Returns
    -------
    Dataset
        The pool with other maximum closures, also net of bulk indentation. Beyond the levels
        of JRC they are extrapolated.

    Raises
    ------
    InputError
        A rock whose JRC is not varied on common surfaces.
    """
    names = [name for name in (TARGET, NET) if name in pool]
    before = {name: pool[name].transpose(*_ORDER).values for name in names}
    after = {name: values.copy() for name, values in before.items()}
    for rock in rocks_of(pool):
        levels = levels_of(pool, rock).get("jrc")
        if levels is None or not same_surfaces(pool, rock):
            raise InputError(f"{rock}: its JRC is not varied on common surfaces")
        span = levels.values[-1] - levels.values[0]
        at = (levels.values - levels.base) / span
        own = dict(zip(levels.cases.tolist(), at, strict=True))
        for case in np.flatnonzero((pool.rock == rock).values).tolist():
            here = own.get(case, 0.0)
            drawn = random.uniform(-1.0, 1.0, pool.sizes["realization"])
            powers = np.vander(here + half_width / span * drawn, at.size)
            weights = (powers - np.vander([here], at.size)) @ np.linalg.inv(np.vander(at))
            for name in names:
                answers = np.log(before[name][levels.cases])  # (level, realization, cycle)
                after[name][case] *= np.exp(np.einsum("rl,lrc->rc", weights, answers))
    return pool.assign({name: (_ORDER, after[name], pool[name].attrs) for name in names})


def jrc_range_tables(
    evidence: Evidence, half_widths: Iterable[float], paper: pd.DataFrame
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """What a JRC that is known to a range does to scatter, intervals, and what studies find.

    Parameters
    ----------
    evidence : Evidence
        Of a study as made.
    half_widths : iterable of float
        Of the JRC; 0 (a JRC that is known) comes first by itself.
    paper : DataFrame
        The paper's Table 3.

    Returns
    -------
    entries : DataFrame
        ``rock``, ``parameter`` (base: S/mean in percent), ``cycle``, ``half_width``, ``value``
        (else the median length in percent of the rock's own value) with ``standard_error``,
        ``share_without_root``; the rock "all" has the joint p of the paper's table.
    found : DataFrame
        ``number``, ``claim``, ``half_width``, ``found_share`` with ``found_error`` and
        the interval from ``found_low`` to ``found_high``, the widest of the parts that are drawn.
    """
    entries, found = [], []
    for half_width in (0.0, *half_widths):
        parts, judged = [], []
        for repeat in range(REPEATS if half_width else 1):
            random = generator(seed_of(evidence.root_seed, "JRC", half_width, repeat))
            pool = evidence.pool
            drawn = with_jrc_range(pool, half_width, random) if half_width else pool
            own = evidence._replace(pool=drawn)
            if repeat:  # the pool's error is that of the first one
                own = own._replace(resampled_pools=0)
            parts.append(_entries(own, paper))
            judged.append(judge_claims(own, paper)[0])
        entries.append(_together(pd.concat(parts)).assign(half_width=half_width))
        parts_of = pd.concat(judged).groupby(["number", "claim"], sort=False)
        shares = parts_of.found_share
        told = shares.agg(lambda own: mean_of(own).value if len(own) > 1 else own.iloc[0])
        errors = parts_of.found_error.max()
        scatter = shares.std() / np.sqrt(REPEATS)
        error = np.maximum(errors, scatter.fillna(0.0))
        interval = {"found_low": parts_of.found_low.min(), "found_high": parts_of.found_high.max()}
        table = pd.DataFrame({"found_share": told, "found_error": error} | interval).reset_index()
        found.append(table.assign(half_width=half_width))
    columns = ["rock", "parameter", "cycle", "half_width", "value", "standard_error",
               "share_without_root"]  # fmt: skip
    return pd.concat(entries)[columns], pd.concat(found, ignore_index=True)


def _entries(evidence: Evidence, paper: pd.DataFrame) -> pd.DataFrame:
    rows, pool = [], evidence.pool
    base = pool[TARGET][(pool.parameter == "base").values]
    for rock, own in zip(base.rock.values.tolist(), base, strict=True):
        for cycle in pool.cycle.values.tolist():
            samples = own.sel(cycle=cycle).values
            scatter = variation_of(samples[np.isfinite(samples)])
            rows.append({"rock": rock, "parameter": "base", "cycle": cycle,
                         "value": 100.0 * scatter.value,
                         "error": 100.0 * scatter.standard_error})  # fmt: skip
    found = predictive(
        pool, evidence.design, evidence.repetitions, evidence.root_seed, evidence.resampled_pools
    )
    for (rock, parameter, cycle), lengths in found.lengths.items():
        size = 100.0 / abs(found.bases[rock, parameter, cycle])
        rows.append({"rock": rock, "parameter": parameter, "cycle": cycle,
                     "value": size * float(np.median(lengths)),
                     "error": size * median_pool_error(found, (rock, parameter, cycle)),
                     "share_without_root": float(np.isinf(lengths).mean())})  # fmt: skip
    joint = joint_table(found, paper)
    if not joint.empty:
        whole = joint.iloc[0]
        rows.append({"rock": "all", "parameter": "joint p", "cycle": 0, "value": whole.p,
                     "error": whole.p_error})  # fmt: skip
    return pd.DataFrame(rows)


def _together(parts: pd.DataFrame) -> pd.DataFrame:
    """Means over repeats; the error is that of the pool, or their own where it is larger."""
    group = parts.groupby(["rock", "parameter", "cycle"], sort=False)
    means = group[["value", "share_without_root"]].mean()
    scatter = (group.value.std() / np.sqrt(group.value.count())).fillna(0.0)
    return means.assign(
        standard_error=np.maximum(group.error.max().fillna(0.0), scatter)
    ).reset_index()
