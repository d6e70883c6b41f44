"""From the runs of an accuracy study to errors, orders of convergence, and what they cost.

Errors are those of a setting's results on the same surfaces as the scene's
finest setting: of the mean maximum closure, of its standard deviation over the
surfaces, and of the indifference interval of the parameter that is followed.
Confidence intervals are percentiles over resampled surfaces.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.ensemble.cases import BASE
from jointclosure.ensemble.points import gridded
from jointclosure.experiments.accuracy.design import Setting
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.indifference import indifference_interval

MEASURES = ("mean", "deviation", "interval", "net")


class _Sample(NamedTuple):
    """Closures (level, realization) of a run at one cycle, as they are and net of the bulk
    indentation, where all levels succeeded, and where.
    """

    closures: np.ndarray
    net: np.ndarray
    levels: np.ndarray
    base: float
    good: np.ndarray
    significance: float

    def measures(self, index: np.ndarray) -> tuple[float, float, float, float]:
        """`MEASURES` of chosen surfaces: mean and deviation at the base level [m], length of the
        interval, mean net of the bulk indentation [m].
        """
        chosen = self.closures[:, index]
        own = list(self.levels).index(self.base)
        at_base = chosen[own]
        length = np.nan
        if len(self.levels) > 2 and index.size > 1 and np.ptp(index) > 0:
            means, deviations = chosen.mean(axis=1), chosen.std(axis=1, ddof=1)
            length = indifference_interval(
                self.levels, means, deviations, index.size, self.significance, self.base
            ).length
        deviation = at_base.std(ddof=1) if index.size > 1 else np.nan
        return at_base.mean(), deviation, length, self.net[own, index].mean()


def _sample(run: xr.Dataset, cycle: int, significance: float) -> _Sample:
    return _Sample(
        run.closure.sel(cycle=cycle).values,
        run.closure_net.sel(cycle=cycle).values,
        run.level.values,
        float(run.attrs["base"]),
        (run.status.values < FAILURE).all(axis=0),
        significance,
    )


def runs_of(joints: pd.DataFrame, bases: Mapping[str, float]) -> dict[str, xr.Dataset]:
    """Runs by name, each over (level, realization, cycle), from the table of all their joints.

    ``bases`` are the rocks' own values of the property that is varied [SI], by run.
    """
    return {
        str(name): gridded(
            part, ("level", "realization"), ("closure", "closure_net", "fft_pair")
        ).assign_attrs(base=bases[str(name)])
        for name, part in joints.groupby("run", sort=False)
    }


def cost_table(
    settings: list[Setting],
    runs: Mapping[str, xr.Dataset],
    finest: Mapping[str, dict],
    random: np.random.Generator,
    resamples: int,
    confidence: float,
    significance: float,
) -> pd.DataFrame:
    """Error and time of every setting, cycle by cycle.

    Parameters
    ----------
    settings : list of Setting
    runs : mapping
        By the name of a run, datasets over (level, realization, cycle) with the attribute ``base``,
        as from `runs_of`.
    finest : mapping
        Knob and value that the settings of each variant are held against.
    random : Generator
    resamples : int
    confidence : float
        Of the confidence intervals.
    significance : float
        Of the indifference interval.

    Returns
    -------
    DataFrame
        ``<measure>_error_percent`` with ``_low`` and ``_high`` for each of
        `MEASURES`; ``seconds`` a simulation (median, with quartiles), ``pairs``
        of FFTs, and ``relative_time`` to the scene's base setting. Of knobs that
        change the joints (``other_joints``) the errors are changes to the base
        setting, between other surfaces.
    """
    rows = []
    for setting in settings:
        run = runs[setting.run]
        other = setting.other_joints
        against = finest[setting.scene] if not other else {"knob": BASE, "value": ""}
        truth = runs[_run_of(settings, setting, against)]
        base = runs[_run_of(settings, setting, {"knob": BASE, "value": ""})]
        for cycle in run.cycle.values.tolist():
            row: dict = {"scene": setting.scene, "rock": setting.rock, "knob": setting.knob}
            row |= {"value": setting.value, "cycle": cycle, "run": setting.run}
            row["other_joints"] = other
            own, exact = (_sample(each, cycle, significance) for each in (run, truth))
            row |= _errors(own, exact, random, resamples, confidence, other)
            rows.append(row | _times(run, base))
    return pd.DataFrame(rows)


def _run_of(settings: list[Setting], like: Setting, wanted: dict) -> str:
    for setting in settings:
        same = setting.scene == like.scene and setting.rock == like.rock
        if same and setting.knob == wanted["knob"] and setting.value == wanted["value"]:
            return setting.run
    raise ValueError(
        f"accuracy.scenes.{like.scene}.finest: no knob {wanted['knob']!r} "
        f"with value {wanted['value']!r} is turned there"
    )


def _errors(own: _Sample, truth: _Sample, random, resamples, confidence, other) -> dict:
    """Relative errors in percent, and their confidence intervals."""
    if other:
        mine, theirs = np.flatnonzero(own.good), np.flatnonzero(truth.good)
    else:
        mine = theirs = np.flatnonzero(own.good & truth.good)
    row: dict = {"samples": mine.size, "failed": int((~own.good).sum())}
    if mine.size < 2:
        return row
    exact = truth.measures(theirs)
    found = own.measures(mine)
    row |= {"mean_mm": 1e3 * found[0], "deviation_mm": 1e3 * found[1], "interval": found[2]}
    row |= {"net_mm": 1e3 * found[3]}
    drawn = np.empty((resamples, len(MEASURES)))
    for i in range(resamples):
        index = random.integers(0, mine.size, mine.size)
        again = random.integers(0, theirs.size, theirs.size) if other else index
        one, two = own.measures(mine[index]), truth.measures(theirs[again])
        drawn[i] = [100.0 * (a / b - 1.0) for a, b in zip(one, two, strict=True)]
    tail = 50.0 * (1.0 - confidence)
    for k, measure in enumerate(MEASURES):
        row[f"{measure}_error_percent"] = 100.0 * (found[k] / exact[k] - 1.0)
        known = drawn[np.isfinite(drawn[:, k]), k]
        # an interval that is absent in many resamples has no confidence interval
        enough = known.size > 0.9 * resamples
        low, high = np.percentile(known, [tail, 100.0 - tail]) if enough else (np.nan, np.nan)
        row |= {f"{measure}_low": low, f"{measure}_high": high}
    return row


def _times(run: xr.Dataset, base: xr.Dataset) -> dict:
    seconds = run.seconds.values
    middle, low, high = np.quantile(seconds, (0.5, 0.25, 0.75))
    own, of_base = (
        float(np.median(each.seconds.values / each.fft_pair.isel(cycle=0).values))
        for each in (run, base)
    )
    return {
        "seconds": middle,
        "seconds_low": low,
        "seconds_high": high,
        "pairs": own,
        "relative_time": own / of_base,
    }


def order_table(costs: pd.DataFrame) -> pd.DataFrame:
    """Observed order of convergence of the mean closure in every knob that is a number.

    The slope of log |error| over log value, among the values whose confidence
    interval excludes zero; with fewer than three of these, or errors of both
    signs, there is no clean order, and the remark says why.
    """
    rows = []
    for keys, part in costs.groupby(["scene", "rock", "knob", "cycle"], sort=False):
        scene, rock, knob, cycle = keys
        numbers = pd.to_numeric(part["value"], errors="coerce")
        if knob == BASE or part.other_joints.any() or numbers.isna().any():
            continue
        part = part.assign(number=numbers)
        sure = part[(part.mean_low > 0.0) | (part.mean_high < 0.0)]
        row = {"scene": scene, "rock": rock, "knob": knob, "cycle": cycle}
        row |= {"values": len(part), "beyond_noise": len(sure), "order": np.nan, "error": np.nan}
        if len(sure) < 3:
            row["remark"] = "fewer than three errors beyond the noise of the surfaces"
        elif np.ptp(np.sign(sure.mean_error_percent)) > 0:
            row["remark"] = "errors of both signs"
        else:
            size = sure.mean_error_percent.abs()
            fit = scipy.stats.linregress(np.log(sure.number), np.log(size))
            row |= {"order": fit.slope, "error": fit.stderr, "remark": ""}
        rows.append(row)
    return pd.DataFrame(rows)


class Resampling(NamedTuple):
    """How confidence intervals are drawn."""

    random: np.random.Generator
    resamples: int
    confidence: float


def source_table(
    costs: pd.DataFrame,
    runs: Mapping[str, xr.Dataset],
    scene: str,
    realizations: int,
    drawn: Resampling,
) -> pd.DataFrame:
    """Where the error of the paper's own setting in a scene comes from, in percent of the mean.

    Parameters
    ----------
    costs : DataFrame
        As from `cost_table`.
    runs : mapping
        As for `cost_table`.
    scene : str
    realizations : int
        Surfaces of a mean whose sampling error is told.
    drawn : Resampling
        For the intervals of ``tolerances``.

    Returns
    -------
    DataFrame
        ``source``, ``error_percent``, ``low``, ``high``. ``steps``: the error of its steps;
        ``tolerances``: what tight ones (knob ``paper_tolerances``, where it is turned) move, on the
        same surfaces; ``sampling``: the standard error of a mean over so many ``realizations``,
        with the interval (by chi-square) that the deviation of normal closures has from the
        surfaces that were closed; ``surface rule``: the largest change among the rules tried,
        which no computing takes away.
    """
    rows = []
    chosen = costs[costs.scene == scene]
    for (rock, cycle), part in chosen.groupby(["rock", "cycle"], sort=False):
        base = part[part.knob == BASE].iloc[0]
        rule = part[part.knob == "surface_rule"]
        sources = {"steps": (base.mean_error_percent, base.mean_low, base.mean_high)}
        tight = part[part.knob == "paper_tolerances"]
        if len(tight):
            pair = runs[base.run], runs[tight.run.iloc[0]]
            sources["tolerances"] = _moved(*pair, cycle, drawn)
        sources["sampling"] = _sampling(base, realizations, drawn.confidence)
        if len(rule):
            worst = rule.loc[rule.mean_error_percent.abs().idxmax()]
            name = f"surface rule ({worst['value']})"
            sources[name] = (worst.mean_error_percent, worst.mean_low, worst.mean_high)
        for source, (error, low, high) in sources.items():
            row = {"scene": scene, "rock": rock, "cycle": cycle, "source": source}
            rows.append(row | {"error_percent": error, "low": low, "high": high})
    return pd.DataFrame(rows)


def _moved(
    base: xr.Dataset, tight: xr.Dataset, cycle: int, drawn: Resampling
) -> tuple[float, float, float]:
    """Change [%] of the base's mean from that of tight tolerances, and its interval."""
    own, exact = (_sample(run, cycle, np.nan) for run in (base, tight))
    good = np.flatnonzero(own.good & exact.good)
    level = list(own.levels).index(own.base)
    pair = own.closures[level, good], exact.closures[level, good]
    index = drawn.random.integers(0, good.size, (drawn.resamples, good.size))
    found = [100.0 * (pair[0][i].mean(-1) / pair[1][i].mean(-1) - 1.0) for i in (..., index)]
    tail = 50.0 * (1.0 - drawn.confidence)
    low, high = np.percentile(found[1], [tail, 100.0 - tail])
    return float(found[0]), float(low), float(high)


def _sampling(base: pd.Series, realizations: int, confidence: float) -> tuple[float, float, float]:
    """Standard error [%] of a mean over realisations, and the interval of its estimate."""
    error = 100.0 * base.deviation_mm / base.mean_mm / np.sqrt(realizations)
    free = base.samples - 1
    tail = 0.5 * (1.0 - confidence)
    low, high = np.sqrt(free / scipy.stats.chi2.ppf([1.0 - tail, tail], free))
    return error, error * low, error * high
