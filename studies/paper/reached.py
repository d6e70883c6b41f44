"""Accuracy that a study has reached, and number of missing surfaces."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.statistics.total_error import REACH, Method
from studies.frame.config.wanted import BLOCK, PresetErrors, Wanted
from studies.frame.ensemble.covariates import Covariates
from studies.paper.claims.findings import TARGET
from studies.paper.closures import max_closure_table
from studies.paper.planning import Goal, length_error, surfaces_for
from studies.paper.responses import responses

COLUMNS = ["rock", "parameter", "level", "cycle", "surfaces", "bias_percent", "bias_error_percent"]
COLUMNS += ["sampling_percent", "total_percent", "within_percent", "met", "surfaces_needed"]
COLUMNS += ["bias_known_at"]


def reached_table(
    study: xr.Dataset,
    covariates: Covariates | None,
    wanted: Wanted,
    errors: Mapping[str, PresetErrors],
    significance: float,
) -> pd.DataFrame:
    """Tabulate the total error of each mean, or of each interval, of a study.

    Parameters
    ----------
    covariates : Covariates or None
        Covariates of the study, if means are adjusted.
    errors : mapping
        Errors of the preset by rock.
    significance : float
        Significance level of the intervals.

    Returns
    -------
    DataFrame
        For each case or parameter and cycle with known bias: number of surfaces, the bias of the
        preset with its standard error, half the 95 % confidence interval of the study itself
        (Student's t), the total error of both (`jointclosure.statistics.total_error`), whether
        the accuracy is ``met``, and ``surfaces_needed``, the expected number for it, infinite if
        there is none.
    """
    errors_of = _of_means if wanted.of == "mean" else _of_intervals
    rows = []
    for about, surfaces, sampling, needed in errors_of(
        study, covariates, wanted, errors, significance
    ):
        known = errors[about["rock"]]
        bias = known.of_cycle[about["cycle"]]
        # the scatter of few surfaces is known only roughly
        sampling *= scipy.stats.t.ppf(0.975, surfaces - 1) / REACH
        total = bias.total(sampling)
        rows.append(
            about
            | {"surfaces": surfaces, "bias_percent": 100.0 * bias.value}
            | {"bias_error_percent": 100.0 * bias.error, "bias_known_at": known.measured_at}
            | {"sampling_percent": 100.0 * sampling, "total_percent": 100.0 * total}
            | {"within_percent": 100.0 * wanted.within, "met": bool(total <= wanted.within)}
            | {"surfaces_needed": needed}
        )
    return pd.DataFrame(rows, columns=COLUMNS)


def _of_means(study, covariates, wanted: Wanted, errors, significance) -> Iterator[tuple]:
    for row in max_closure_table(study, covariates).itertuples():
        if row.cycle not in errors[row.rock].of_cycle:
            continue
        adjusted = np.isfinite(row.max_closure_adjusted_mean_mm_standard_error)
        kind = "adjusted_mean" if adjusted and row.cycle == 1 else "mean"
        mean = getattr(row, f"max_closure_{kind}_mm")
        error = getattr(row, f"max_closure_{kind}_mm_standard_error") / mean
        bias = errors[row.rock].of_cycle[row.cycle]
        way = Method(bias, error * np.sqrt(row.samples), 1.0, 0.0, 0.0, 0.0)
        about = {"rock": row.rock, "parameter": row.parameter, "level": row.level}
        sampling = way.sampling(row.samples)
        yield about | {"cycle": row.cycle}, row.samples, sampling, way.surfaces_for(wanted.within)


def _of_intervals(study, covariates, wanted: Wanted, errors, significance) -> Iterator[tuple]:
    for response in responses(study, TARGET):
        biases = errors[response.rock].of_cycle
        if response.cycle not in biases:
            continue
        surfaces = response.samples.shape[1]
        room = biases[response.cycle].room(wanted.within)
        goal = Goal("width", 2.0 * room)
        needed = surfaces_for(response, goal, significance, response.paired) if room > 0 else np.inf
        about = {"rock": response.rock, "parameter": response.parameter, "level": ""}
        sampling = REACH * length_error(response, surfaces)
        yield about | {"cycle": response.cycle}, surfaces, sampling, needed


def surfaces_next(table: pd.DataFrame, wanted: Wanted) -> int | None:
    """Return the number of surfaces per case to continue with; None if finished.

    It is None if the accuracy is reached, or the largest number of surfaces is reached.
    """
    missing = table[~table.met]
    had = int(table.surfaces.max()) if len(table) else 0
    if missing.empty or had >= wanted.most:
        return None
    # failed realisations are not counted: whole blocks, at least one
    had = BLOCK * int(np.ceil(had / BLOCK))
    needed = min(float(missing.surfaces_needed.max()), wanted.most)
    return int(min(max(BLOCK * np.ceil(needed / BLOCK), had + BLOCK), wanted.most))


def describe_reached(table: pd.DataFrame, wanted: Wanted) -> str:
    """Describe the reached accuracy in words."""
    if table.empty:
        return f"accuracy: no {wanted.of} of this study has a known error"
    worst = table.loc[table.total_percent.idxmax()]
    # parameter and level of the base case are both "base"
    parts = dict.fromkeys(str(part) for part in worst[["rock", "parameter", "level"]] if part)
    name = " ".join(parts)
    reached = (
        "reached" if table.met.all() else f"not reached in {(~table.met).sum()} of {len(table)}"
    )
    return (
        f"accuracy: {wanted.of} within {100.0 * wanted.within:g} % {reached}, with "
        f"{worst.surfaces:.0f} surfaces; the worst is {worst.total_percent:.2g} % ({name}, cycle "
        f"{worst.cycle})"
    )
