"""Effect of a JRC that is known only to a range (the paper's limit vi) on repetitions of a study.

The JRC of a joint is drawn uniformly within a half-width of that of its case. The effect on its
closure is known for each surface: the pool closes each surface at all levels of JRC, and the
logarithm of the closure is interpolated by the polynomial through them. At changed levels of other
parameters the same factor is assumed.
"""

from collections.abc import Iterable

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.findings import NET, TARGET
from jointclosure.config.typed import Configuration
from jointclosure.inputs import InputError
from jointclosure.sensitivity.claims import Evidence, judge_claims
from jointclosure.sensitivity.predictive import joint_table, median_pool_error, predictive
from jointclosure.sensitivity.responses import levels_of, rocks_of, same_surfaces
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import mean_of, variation_of

_ORDER = ("case", "realization", "cycle")
REPEATS = 4
"""Number of JRC draws for every joint of the pool; their scatter is the error due to the draw."""


def check_jrc_varies(configuration: Configuration) -> None:
    """Check that a study contains the response of closures to JRC for each surface.

    Raises
    ------
    InputError
        If the JRC of a rock is not varied, or the study has no common surfaces.
    """
    for name, rock in configuration.rocks.items():
        if len(rock.levels.get("jrc", ())) < 2:
            raise InputError(f"rocks.{name}.levels.jrc: must be given if a JRC is a range")
    study = configuration.study
    if not study.pool and study.draws != "common":
        raise InputError(
            "study.pool: must be given if a JRC is a range, or study.draws must be common"
        )


def with_jrc_range(pool: xr.Dataset, half_width: float, random: np.random.Generator) -> xr.Dataset:
    """Return a pool whose joints have a JRC drawn within a half-width of that of their case.

    Parameters
    ----------
    pool : Dataset
        Pool with common surfaces at all levels of JRC.

    Returns
    -------
    Dataset
        The pool with changed maximum closures, also net of bulk indentation. Beyond the levels
        of JRC they are extrapolated.

    Raises
    ------
    InputError
        If the JRC of a rock is not varied on common surfaces.
    """
    names = [name for name in (TARGET, NET) if name in pool]
    before = {name: pool[name].transpose(*_ORDER).values for name in names}
    after = {name: values.copy() for name, values in before.items()}
    for rock in rocks_of(pool):
        levels = levels_of(pool, rock).get("jrc")
        if levels is None or not same_surfaces(pool, rock):
            raise InputError(f"{rock}: its JRC must be varied on common surfaces")
        span = levels.values[-1] - levels.values[0]
        at = (levels.values - levels.base) / span
        place_of_case = dict(zip(levels.cases.tolist(), at, strict=True))
        for case in np.flatnonzero((pool.rock == rock).values).tolist():
            here = place_of_case.get(case, 0.0)
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
    """Tabulate the effect of a JRC known to a range on scatter, intervals, and confirmed claims.

    Parameters
    ----------
    evidence : Evidence
        Evidence of a real study.
    half_widths : iterable of float
        Half-widths of the JRC; 0 (a known JRC) is added first.
    paper : DataFrame
        The paper's Table 3.

    Returns
    -------
    entries : DataFrame
        ``rock``, ``parameter``, ``cycle``, ``half_width``, ``value`` with ``standard_error``,
        ``share_without_root``. The value is S/mean in percent for the parameter "base", and
        otherwise the median length in percent of the rock's value; for the rock "all" it is the
        joint p of the paper's table.
    claims : DataFrame
        ``number``, ``claim``, ``half_width``, ``found_share`` with ``found_error`` and
        the interval from ``found_low`` to ``found_high``, the widest of the repeated draws.
    """
    entries, claims = [], []
    for half_width in (0.0, *half_widths):
        parts, judged = [], []
        for repeat in range(REPEATS if half_width else 1):
            random = generator(seed_of(evidence.root_seed, "JRC", half_width, repeat))
            pool = evidence.pool
            drawn = with_jrc_range(pool, half_width, random) if half_width else pool
            part = evidence._replace(pool=drawn)
            if repeat:  # the pool's error is computed once
                part = part._replace(resampled_pools=0)
            parts.append(_entries(part, paper))
            judged.append(judge_claims(part, paper)[0])
        entries.append(_together(pd.concat(parts)).assign(half_width=half_width))
        parts_of = pd.concat(judged).groupby(["number", "claim"], sort=False)
        shares = parts_of.found_share
        means = shares.agg(lambda part: mean_of(part).value if len(part) > 1 else part.iloc[0])
        errors = parts_of.found_error.max()
        scatter = shares.std() / np.sqrt(REPEATS)
        error = np.maximum(errors, scatter.fillna(0.0))
        interval = {"found_low": parts_of.found_low.min(), "found_high": parts_of.found_high.max()}
        table = pd.DataFrame({"found_share": means, "found_error": error} | interval).reset_index()
        claims.append(table.assign(half_width=half_width))
    columns = ["rock", "parameter", "cycle", "half_width", "value", "standard_error",
               "share_without_root"]  # fmt: skip
    return pd.concat(entries)[columns], pd.concat(claims, ignore_index=True)


def _entries(evidence: Evidence, paper: pd.DataFrame) -> pd.DataFrame:
    rows, pool = [], evidence.pool
    base = pool[TARGET][(pool.parameter == "base").values]
    for rock, scatter_of_rock in zip(base.rock.values.tolist(), base, strict=True):
        for cycle in pool.cycle.values.tolist():
            samples = scatter_of_rock.sel(cycle=cycle).values
            scatter = variation_of(samples[np.isfinite(samples)])
            rows.append({"rock": rock, "parameter": "base", "cycle": cycle,
                         "value": 100.0 * scatter.value,
                         "error": 100.0 * scatter.standard_error})  # fmt: skip
    drawn_lengths = predictive(
        pool, evidence.design, evidence.repetitions, evidence.root_seed, evidence.resampled_pools
    )
    for (rock, parameter, cycle), lengths in drawn_lengths.lengths.items():
        size = 100.0 / abs(drawn_lengths.bases[rock, parameter, cycle])
        rows.append({"rock": rock, "parameter": parameter, "cycle": cycle,
                     "value": size * float(np.median(lengths)),
                     "error": size * median_pool_error(drawn_lengths, (rock, parameter, cycle)),
                     "share_without_root": float(np.isinf(lengths).mean())})  # fmt: skip
    joint = joint_table(drawn_lengths, paper)
    if not joint.empty:
        whole = joint.iloc[0]
        rows.append({"rock": "all", "parameter": "joint p", "cycle": 0, "value": whole.p,
                     "error": whole.p_error})  # fmt: skip
    return pd.DataFrame(rows)


def _together(parts: pd.DataFrame) -> pd.DataFrame:
    """Average repeated draws; the error is that of the pool, or of the draws if it is larger."""
    group = parts.groupby(["rock", "parameter", "cycle"], sort=False)
    means = group[["value", "share_without_root"]].mean()
    scatter = (group.value.std() / np.sqrt(group.value.count())).fillna(0.0)
    return means.assign(
        standard_error=np.maximum(group.error.max().fillna(0.0), scatter)
    ).reset_index()
