"""Errors, orders of convergence and costs from the runs of an accuracy study.

The results of a setting are compared with those of the scene's finest setting on the same
surfaces: the mean maximum closure, its standard deviation over the surfaces, the indifference
interval of the varied parameter, the mean net of the bulk indentation, and the mean over the
surfaces and all levels, whose error is known better than that of the base level alone.
Confidence intervals are percentiles over resampled surfaces.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.engine.points import gridded
from jointclosure.engine.settings import BASE
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.indifference import indifference_interval
from studies.accuracy.design import Setting
from studies.frame.summary import grouped

MEASURES = ("mean", "deviation", "interval", "net", "levels")


class Resampling(NamedTuple):
    """Bootstrap of confidence intervals: random numbers, number of resamples, confidence."""

    random: np.random.Generator
    resamples: int
    confidence: float

    def interval(self, values: np.ndarray) -> tuple[float, float]:
        """Return percentiles of values (n,), or NaN if more than a tenth of the resamples lack one.

        An indifference interval that is absent in many resamples has no confidence interval.
        """
        if values.size <= 0.9 * self.resamples:
            return np.nan, np.nan
        tail = 50.0 * (1.0 - self.confidence)
        low, high = np.percentile(values, [tail, 100.0 - tail])
        return float(low), float(high)


class _Sample(NamedTuple):
    """Closures (level, realization) of a run at one cycle, gross and net of the bulk indentation.

    ``good`` (realization,): whether the joints of all levels were closed.
    """

    closures: np.ndarray
    net: np.ndarray
    levels: np.ndarray
    base: float
    good: np.ndarray

    @property
    def base_level(self) -> int:
        return list(self.levels).index(self.base)

    def measures(self, index: np.ndarray, significance: float) -> np.ndarray:
        """Compute `MEASURES` [m, but the interval] on the surfaces of an index."""
        chosen = self.closures[:, index]
        at_base = chosen[self.base_level]
        length = np.nan
        if len(self.levels) > 2 and index.size > 1 and np.ptp(index) > 0:
            means, deviations = chosen.mean(axis=1), chosen.std(axis=1, ddof=1)
            length = indifference_interval(
                self.levels, means, deviations, index.size, significance, self.base
            ).length
        deviation = at_base.std(ddof=1) if index.size > 1 else np.nan
        net = self.net[self.base_level, index].mean()
        return np.array([at_base.mean(), deviation, length, net, chosen.mean()])


def _sample(run: xr.Dataset, cycle: int) -> _Sample:
    return _Sample(
        run.max_closure.sel(cycle=cycle).values,
        run.max_closure_net.sel(cycle=cycle).values,
        run.level.values,
        float(run.attrs["base"]),
        (run.status.values < FAILURE).all(axis=0),
    )


def runs_of(joints: pd.DataFrame, bases: Mapping[str, float]) -> dict[str, xr.Dataset]:
    """Arrange the joints of each run over (level, realization, cycle).

    ``bases`` are the values of the varied property at the base level [SI], by run.
    """
    return {
        str(name): gridded(
            part, ("level", "realization"), ("max_closure", "max_closure_net", "fft_pair")
        ).assign_attrs(base=bases[str(name)])
        for name, part in joints.groupby("run", sort=False)
    }


def cost_table(
    settings: list[Setting],
    runs: Mapping[str, xr.Dataset],
    finest: Mapping[str, dict],
    drawn: Resampling,
    significance: float,
) -> pd.DataFrame:
    """Compute the error and time of every setting, cycle by cycle.

    ``<measure>_error_percent`` with ``_low`` and ``_high`` for each of
    `MEASURES`; ``seconds`` a simulation (median, with quartiles), ``pairs``
    of FFTs, and ``relative_time`` to the scene's base setting. Of knobs that
    change the joints (``other_joints``) the errors are changes to the base
    setting, between other surfaces.
    """
    rows = []
    at_base = {"knob": BASE, "value": ""}
    for setting in settings:
        other = setting.other_joints
        reference = at_base if other else finest[setting.scene]
        run, truth, base = (
            runs[name]
            for name in (
                setting.run,
                _run_of(settings, setting, reference),
                _run_of(settings, setting, at_base),
            )
        )
        for cycle in run.cycle.values.tolist():
            row: dict = {name: getattr(setting, name) for name in ("scene", "rock", "knob")}
            row |= {"value": setting.value, "cycle": cycle, "run": setting.run}
            row["other_joints"] = other
            samples = _sample(run, cycle), _sample(truth, cycle)
            rows.append(row | _errors(*samples, drawn, significance, other) | _times(run, base))
    return pd.DataFrame(rows)


def _run_of(settings: list[Setting], like: Setting, point: dict) -> str:
    """Return the run of a knob and value in the variant and rock of a setting."""
    for setting in settings:
        same = setting.scene == like.scene and setting.rock == like.rock
        if same and setting.knob == point["knob"] and setting.value == point["value"]:
            return setting.run
    raise ValueError(
        f"accuracy.scenes.{like.scene}.finest: no setting of this variant has the knob "
        f"{point['knob']!r} with value {point['value']!r}"
    )


def _errors(
    sample: _Sample, truth: _Sample, drawn: Resampling, significance: float, other: bool
) -> dict:
    """Compute relative errors in percent, and their confidence intervals."""
    here, there = np.flatnonzero(sample.good), np.flatnonzero(truth.good)
    if not other:
        here = there = np.flatnonzero(sample.good & truth.good)
    row: dict = {"samples": here.size, "failed": int((~sample.good).sum())}
    if here.size < 2:
        return row

    def errors(index: np.ndarray, index_of_truth: np.ndarray) -> np.ndarray:
        values = sample.measures(index, significance)
        return 100.0 * (values / truth.measures(index_of_truth, significance) - 1.0)

    mean, deviation, length, net, _ = sample.measures(here, significance)
    row |= {"mean_mm": 1e3 * mean, "deviation_mm": 1e3 * deviation, "interval": length}
    row |= {"net_mm": 1e3 * net}
    resampled = np.empty((drawn.resamples, len(MEASURES)))
    for i in range(drawn.resamples):
        index = drawn.random.integers(0, here.size, here.size)
        again = drawn.random.integers(0, there.size, there.size) if other else index
        resampled[i] = errors(here[index], there[again])
    for measure, error, values in zip(MEASURES, errors(here, there), resampled.T, strict=True):
        row[f"{measure}_error_percent"] = error
        row[f"{measure}_low"], row[f"{measure}_high"] = drawn.interval(values[np.isfinite(values)])
    return row


def _times(run: xr.Dataset, base: xr.Dataset) -> dict:
    """Compute the median time with its quartiles, also in FFT pairs and relative to the base."""
    middle, low, high = np.quantile(run.seconds.values, (0.5, 0.25, 0.75))
    pairs, of_base = (
        float(np.median(part.seconds.values / part.fft_pair.isel(cycle=0).values))
        for part in (run, base)
    )
    times = {"seconds": middle, "seconds_low": low, "seconds_high": high}
    return times | {"pairs": pairs, "relative_time": pairs / of_base}


def order_table(costs: pd.DataFrame) -> pd.DataFrame:
    """Compute the observed order of convergence of the mean closure in every numeric knob.

    It is the slope of log |error| over log value, among the values whose confidence interval
    excludes zero. With fewer than three of these, or errors of both signs, there is no order; the
    remark gives the reason.
    """
    rows = []
    for at, part in grouped(costs, "scene", "rock", "knob", "cycle"):
        numbers = pd.to_numeric(part["value"], errors="coerce")
        if at["knob"] == BASE or part.other_joints.any() or numbers.isna().any():
            continue
        part = part.assign(number=numbers)
        sure = part[(part.mean_low > 0.0) | (part.mean_high < 0.0)]
        row = at | {
            "values": len(part),
            "beyond_noise": len(sure),
            "order": np.nan,
            "error": np.nan,
        }
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


def source_table(
    costs: pd.DataFrame,
    runs: Mapping[str, xr.Dataset],
    scene: str,
    realizations: int,
    drawn: Resampling,
) -> pd.DataFrame:
    """Split the error of the paper's setting in a scene by its sources, in percent of the mean.

    ``source``, ``error_percent``, ``low``, ``high``. ``steps``: the error of its steps;
    ``tolerances``: the change by tight ones (knob ``paper_tolerances``, if the scene has it) on
    the same surfaces; ``sampling``: the standard error of a mean over ``realizations``,
    with the interval (by chi-square) that the deviation of normal closures has from the
    closed surfaces; ``surface rule``: the largest change among the rules tried, which no
    computing reduces.
    """
    rows = []
    for at, part in grouped(costs[costs.scene == scene], "scene", "rock", "cycle"):
        base = part[part.knob == BASE].iloc[0]
        sources = {"steps": _mean_error(base)}
        tight = part[part.knob == "paper_tolerances"]
        if len(tight):
            one, exact = (_sample(runs[run], at["cycle"]) for run in (base.run, tight.run.iloc[0]))
            sources["tolerances"] = _change(one, exact, drawn)
        sources["sampling"] = _sampling(base, realizations, drawn.confidence)
        rule = part[part.knob == "surface_rule"]
        if len(rule):
            worst = rule.loc[rule.mean_error_percent.abs().idxmax()]
            sources[f"surface rule ({worst['value']})"] = _mean_error(worst)
        for source, values in sources.items():
            errors = zip(("error_percent", "low", "high"), values, strict=True)
            rows.append(at | {"source": source} | dict(errors))
    return pd.DataFrame(rows)


def _mean_error(row: pd.Series) -> tuple[float, float, float]:
    return row.mean_error_percent, row.mean_low, row.mean_high


def _change(sample: _Sample, tight: _Sample, drawn: Resampling) -> tuple[float, float, float]:
    """Compute the change [%] of a mean from that with tight tolerances, and its interval."""
    good = np.flatnonzero(sample.good & tight.good)
    one, two = (part.closures[sample.base_level, good] for part in (sample, tight))
    index = drawn.random.integers(0, good.size, (drawn.resamples, good.size))
    changes = [100.0 * (one[i].mean(-1) / two[i].mean(-1) - 1.0) for i in (..., index)]
    return float(changes[0]), *drawn.interval(changes[1])


def _sampling(base: pd.Series, realizations: int, confidence: float) -> tuple[float, float, float]:
    """Compute the standard error [%] of a mean over realisations, and its interval."""
    error = 100.0 * base.deviation_mm / base.mean_mm / np.sqrt(realizations)
    free = base.samples - 1
    tail = 0.5 * (1.0 - confidence)
    low, high = np.sqrt(free / scipy.stats.chi2.ppf([1.0 - tail, tail], free))
    return error, error * low, error * high
