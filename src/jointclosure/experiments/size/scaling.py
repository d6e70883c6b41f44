"""Is there a scaling under which closures, residual closures and stiffness carry over?

Candidates are products of powers: of patch length and spacing, of the longest wave that a patch
has, and of what its pristine walls measure. Each is fitted to half of the realisations, and judged
by the others; and it is asked for the largest patch where that was not fitted either.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.experiments.size.table import GEOMETRY, logs_of
from jointclosure.statistics.collapse import centred, collapse_of, exponents_of
from jointclosure.statistics.drawn_studies import jackknife_error
from jointclosure.statistics.standard_errors import rounded

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
"""Candidates, and what they are powers of."""
JUDGED = ("closure", "closure_net", "closure_seated_net", "residual_seated_net", "stiffness_net")
FEWEST = 6
"""Realisations that have a reading at every size, below which no scaling is judged."""
BETWEEN = ("sizes", "sizes and spectra")
"""What a scaling has to make one: the sizes of each spectrum, or those of all."""


class Stacked(NamedTuple):
    """Logarithms over (condition, realisation) of a response, and of predictors by name.

    ``spectrum``, ``patch``, ``spacing`` (condition,) say what a condition is.
    """

    response: np.ndarray
    predictors: dict[str, np.ndarray]
    spectrum: np.ndarray
    patch: np.ndarray
    spacing: np.ndarray

    def of(self, scaling: tuple[str, ...]) -> np.ndarray:
        """Predictors (k, condition, realisation) of a scaling."""
        shape = (len(scaling), *self.response.shape)
        return np.array([self.predictors[name] for name in scaling]).reshape(shape)


def stacked(
    run: xr.Dataset, roll_offs: Mapping[str, float | None], name: str, cycle: int
) -> Stacked:
    """The logarithms of a rock's joints as `Stacked`.

    Realisations that lack a condition are left out.
    """
    response = _flat(logs_of(run, name, cycle))
    closed = np.isfinite(response).any(axis=1)
    complete = np.isfinite(response[closed]).all(axis=0)
    labels = np.meshgrid(*(run[each].values for each in _OVER), indexing="ij")
    spectrum, patch, spacing = (each.ravel()[closed] for each in labels)
    roll_off = np.array([roll_offs[each] or np.inf for each in spectrum])
    kept = np.ix_(closed, complete)
    shape = response[kept].shape
    flat = {"patch": patch, "spacing": spacing, "wave": np.minimum(patch, roll_off)}
    predictors = {
        each: np.broadcast_to(np.log(values)[:, None], shape) for each, values in flat.items()
    }
    predictors |= {each: _flat(logs_of(run, each))[kept] for each in GEOMETRY}
    return Stacked(response[kept], predictors, spectrum, patch, spacing)


_OVER = ("spectrum", "patch", "spacing")


def _flat(logs: xr.DataArray) -> np.ndarray:
    """Logarithms as (condition, realisation)."""
    return logs.transpose(*_OVER, "realization").values.reshape(-1, logs.sizes["realization"])


def collapse_table(
    runs: Mapping[str, xr.Dataset], roll_offs: Mapping[str, float | None]
) -> pd.DataFrame:
    """What each scaling does to the spread between sizes.

    Parameters
    ----------
    runs : mapping
        As for `jointclosure.experiments.size.table.size_table`.
    roll_offs : mapping
        Roll-off wavelength [m] of each spectrum, None for none.

    Returns
    -------
    DataFrame
        ``rock``, ``reading``, ``cycle``, ``between`` (`BETWEEN`), ``scaling``, ``realizations``;
        ``exponents`` with their errors as text; on realisations that were not fitted:
        ``removed_percent`` of the mean square spread with its ``removed_error``, and the
        ``left_percent`` (rms of ratios to the mean); ``largest_off_percent``: rms over spectra
        and spacings of how far the largest patch is off, where no such patch was fitted, with
        its ``largest_off_error``. These are NaN where fewer than `FEWEST` realisations have the
        reading at every size.
    """
    rows = []
    for rock, run in runs.items():
        for reading in JUDGED:
            for cycle in run.cycle.values.tolist():
                joints = stacked(run, roll_offs, reading, cycle)
                for between in BETWEEN:
                    own = between == "sizes"
                    groups = joints.spectrum if own else np.zeros(joints.spectrum.size)
                    for scaling, names in SCALINGS.items():
                        about = {"rock": rock, "reading": reading, "cycle": cycle}
                        about |= {"between": between, "scaling": scaling}
                        rows.append(about | _row(joints, groups, names))
    return pd.DataFrame(rows)


_NUMBERS = (
    "removed_percent",
    "removed_error",
    "left_percent",
    "largest_off_percent",
    "largest_off_error",
)


def _row(joints: Stacked, groups: np.ndarray, names: tuple[str, ...]) -> dict:
    """What a scaling does between the conditions of each group."""
    surfaces = joints.response.shape[1]
    if surfaces < FEWEST:
        return {"realizations": surfaces, "exponents": ""} | dict.fromkeys(_NUMBERS, np.nan)
    predictors, response = centred(joints.of(names), groups), centred(joints.response, groups)
    found = collapse_of(predictors, response)
    powers = zip(names, found.exponents, found.errors, strict=True)
    off, left_out = _off(joints, groups, names, np.arange(surfaces)), []
    for surface in range(surfaces):
        left_out.append(_off(joints, groups, names, np.delete(np.arange(surfaces), surface)))
    numbers = (found.removed, found.removed_error, found.left, off, jackknife_error(left_out))
    return {
        "realizations": surfaces,
        "exponents": "; ".join(f"{name} {rounded(value, error)}" for name, value, error in powers),
    } | dict(zip(_NUMBERS, (100.0 * number for number in numbers), strict=True))


def _off(
    joints: Stacked, groups: np.ndarray, names: tuple[str, ...], surfaces: np.ndarray
) -> float:
    """How far the largest patch is off [logarithm, rms], told by the next smaller one.

    Exponents are those of every second surface without the largest patch; the others are told.
    """
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
        fitted, told = surfaces[half::2], surfaces[1 - half :: 2]
        few = np.ix_(np.flatnonzero(smaller), fitted)
        own = predictors[:, few[0], few[1]]
        powers = exponents_of(
            centred(own, groups[smaller]),
            centred(joints.response[few], groups[smaller]),
        )
        scaled = joints.response[:, told] - np.tensordot(powers, predictors[..., told], axes=1)
        squares.append(np.mean((scaled[large] - scaled[small]).mean(axis=1) ** 2))
    return float(np.sqrt(np.mean(squares)))
