"""Scalings, products of powers, by which closures and stiffness of one size predict another."""

import itertools
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.statistics.standard_errors import jackknife_error, rounded

GEOMETRY = ("rms_height", "rms_slope", "depth_5")
"""Quantities of the pristine walls."""
SCALINGS: dict[str, tuple[str, ...]] = {
    "none": (),
    "patch length": ("patch",),
    "spacing": ("spacing",),
    "patch length, spacing": ("patch", "spacing"),
    "longest wave, spacing": ("wave", "spacing"),
    "rms height": ("rms_height",),
    "rms height, spacing": ("rms_height", "spacing"),
    "rms height, rms slope": ("rms_height", "rms_slope"),
    "depth of 5 %": ("depth_5",),
    "depth of 5 %, spacing": ("depth_5", "spacing"),
}
"""Candidates, and the variables whose powers they are."""
JUDGED = (
    "max_closure",
    "max_closure_net",
    "max_closure_seated_net",
    "residual_closure_seated_net",
    "stiffness_net",
)
FEWEST = 6
"""Smallest number of realisations with a quantity at every size for which a scaling is tested."""
BETWEEN = ("sizes", "sizes and spectra")
"""Joints that a scaling should make equal: sizes of one spectrum, or of all spectra."""


NUMBERS: tuple[str, ...] = ("removed_percent", "removed_error", "left_percent")
NUMBERS += ("largest_off_percent", "largest_off_error")
_OVER = ("spectrum", "patch", "spacing")


def logs_of(run: xr.Dataset, name: str, cycle: int) -> xr.DataArray:
    """Compute logarithms, means over the patches of a wall; NaN where nothing was closed."""
    values = run[name].sel(cycle=cycle) if "cycle" in run[name].dims else run[name]
    positive = values.where(values > 0.0)
    return positive.copy(data=np.log(positive.values)).mean("position")


class Stacked(NamedTuple):
    """Logarithms (condition, realisation) of a response and of predictors."""

    response: np.ndarray
    predictors: dict[str, np.ndarray]
    spectrum: np.ndarray
    patch: np.ndarray
    spacing: np.ndarray

    def of(self, scaling: tuple[str, ...]) -> np.ndarray:
        """Return the predictors (k, condition, realisation) of a scaling."""
        shape = (len(scaling), *self.response.shape)
        return np.array([self.predictors[name] for name in scaling]).reshape(shape)


def stacked(
    run: xr.Dataset, roll_offs: Mapping[str, float | None], name: str, cycle: int
) -> Stacked:
    """Stack the logarithms of a quantity, of the realisations that have it at all conditions."""
    response = _flat(logs_of(run, name, cycle))
    closed = np.isfinite(response).any(axis=1)
    complete = np.isfinite(response[closed]).all(axis=0)
    labels = np.meshgrid(*(run[name].values for name in _OVER), indexing="ij")
    spectrum, patch, spacing = (values.ravel()[closed] for values in labels)
    roll_off = np.array([roll_offs[name] or np.inf for name in spectrum])
    kept = np.ix_(closed, complete)
    shape = response[kept].shape
    flat = {"patch": patch, "spacing": spacing, "wave": np.minimum(patch, roll_off)}
    predictors = {
        name: np.broadcast_to(np.log(values)[:, None], shape) for name, values in flat.items()
    }
    predictors |= {name: _flat(logs_of(run, name, cycle))[kept] for name in GEOMETRY}
    return Stacked(response[kept], predictors, spectrum, patch, spacing)


class Collapse(NamedTuple):
    """Shares of the spread between conditions removed, and left (rms), on surfaces not fitted."""

    exponents: np.ndarray
    errors: np.ndarray
    removed: float
    removed_error: float
    left: float


def centred(logs: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Subtract each surface's mean over its group from logarithms (..., condition, surface)."""
    answer = np.array(logs, dtype=float)
    for group in np.unique(groups):
        members = groups == group
        answer[..., members, :] -= answer[..., members, :].mean(axis=-2, keepdims=True)
    return answer


def exponents_of(predictors: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Fit the exponents (k,) of centred predictors (k, condition, surface) by least squares."""
    if not len(predictors):
        return np.zeros(0)
    return np.linalg.lstsq(predictors.reshape(len(predictors), -1).T, response.ravel())[0]


def spreads(predictors: np.ndarray, response: np.ndarray) -> tuple[float, float]:
    """Return the mean square spread between conditions, before and after, by cross-validation.

    The variance of the means over surfaces is subtracted, so that it may be negative.
    """
    halves = np.arange(response.shape[1]) % 2
    both = []
    for half in (0, 1):
        fitted, tested = halves != half, halves == half
        powers = exponents_of(predictors[..., fitted], response[:, fitted])
        rest = response[:, tested] - np.tensordot(powers, predictors[..., tested], axes=1)
        both.append([_mean_square(response[:, tested]), _mean_square(rest)])
    before, after = np.mean(both, axis=0).tolist()
    return before, after


def _mean_square(values: np.ndarray) -> float:
    noise = values.var(axis=1, ddof=1) / values.shape[1]
    return float(np.mean(values.mean(axis=1) ** 2 - noise))


def collapse_of(predictors: np.ndarray, response: np.ndarray) -> Collapse:
    """Fit exponents and evaluate their effect, with errors; arguments as for `spreads`."""
    before, after = spreads(predictors, response)
    powers, shares = [], []
    for kept in ~np.eye(response.shape[1], dtype=bool):
        one = predictors[..., kept], response[:, kept]
        powers.append(exponents_of(*one))
        first, second = spreads(*one)
        shares.append(1.0 - second / first)
    errors, left = np.array(list(map(jackknife_error, np.transpose(powers)))), max(after, 0.0)
    removed = 1.0 - after / before, float(jackknife_error(shares))
    return Collapse(exponents_of(predictors, response), errors, *removed, float(np.sqrt(left)))


def _flat(logs: xr.DataArray) -> np.ndarray:
    """Reshape logarithms to (condition, realisation)."""
    return logs.transpose(*_OVER, "realization").values.reshape(-1, logs.sizes["realization"])


def collapse_table(
    runs: Mapping[str, xr.Dataset], roll_offs: Mapping[str, float | None]
) -> pd.DataFrame:
    """Compute by how much each scaling reduces the spread between sizes (`BETWEEN`).

    On realisations that were not fitted: ``removed_percent`` of the mean square spread and
    ``left_percent`` (rms of ratios to the mean); ``largest_off_percent``: rms over spectra and
    spacings of the error in the largest patch, predicted by fits without it. NaN where fewer than
    `FEWEST` realisations have the quantity at every size. ``roll_offs`` [m] are by spectrum.
    """
    rows = []
    for rock, run in runs.items():
        for reading, cycle in itertools.product(JUDGED, run.cycle.values.tolist()):
            joints = stacked(run, roll_offs, reading, cycle)
            for between, scaling in itertools.product(BETWEEN, SCALINGS):
                groups = joints.spectrum if between == "sizes" else np.zeros(joints.spectrum.size)
                row = {"rock": rock, "reading": reading, "cycle": cycle}
                row |= {"between": between, "scaling": scaling}
                rows.append(row | _row(joints, groups, SCALINGS[scaling]))
    return pd.DataFrame(rows)


def _row(joints: Stacked, groups: np.ndarray, names: tuple[str, ...]) -> dict:
    """Fit and test a scaling between the conditions of each group."""
    surfaces = joints.response.shape[1]
    if surfaces < FEWEST:
        return {"realizations": surfaces, "exponents": ""} | dict.fromkeys(NUMBERS, np.nan)
    fit = collapse_of(centred(joints.of(names), groups), centred(joints.response, groups))
    every = np.arange(surfaces)
    off, *left_out = (
        _off(joints, groups, names, chosen)
        for chosen in (every, *(np.delete(every, surface) for surface in every))
    )
    numbers = (fit.removed, fit.removed_error, fit.left, off, jackknife_error(left_out))
    powers = zip(names, fit.exponents, fit.errors, strict=True)
    return {
        "realizations": surfaces,
        "exponents": "; ".join(f"{name} {rounded(value, error)}" for name, value, error in powers),
    } | {name: 100.0 * number for name, number in zip(NUMBERS, numbers, strict=True)}


def _off(
    joints: Stacked, groups: np.ndarray, names: tuple[str, ...], surfaces: np.ndarray
) -> float:
    """Compute the rms error [logarithm] of the largest patch, predicted by fits without it."""
    lengths = np.unique(joints.patch)
    smaller = joints.patch < lengths[-1]
    pairs = [
        (large, small)
        for large in np.flatnonzero(~smaller)
        for small in np.flatnonzero(joints.patch == lengths[-2])
        if joints.spectrum[large] == joints.spectrum[small]
        and joints.spacing[large] == joints.spacing[small]
    ]
    large, small = np.array(pairs).T
    predictors, squares = joints.of(names), []
    for half in (0, 1):
        fitted, tested = surfaces[half::2], surfaces[1 - half :: 2]
        few = np.ix_(np.flatnonzero(smaller), fitted)
        powers = exponents_of(
            centred(predictors[:, few[0], few[1]], groups[smaller]),
            centred(joints.response[few], groups[smaller]),
        )
        scaled = joints.response[:, tested]
        scaled = scaled - np.tensordot(powers, predictors[..., tested], axes=1)
        squares.append(np.mean((scaled[large] - scaled[small]).mean(axis=1) ** 2))
    return float(np.sqrt(np.mean(squares)))
