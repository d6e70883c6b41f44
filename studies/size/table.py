"""Tables of the scale effect: ratios of the same joints, exponents, and Barton and Bandis.

Joints of a size scatter about a typical one by a factor, so means are those of logarithms. The mean
over the patches of one size of a wall counts once, as these are not drawn independently.
"""

import itertools
from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.engine.points import gridded
from jointclosure.engine.quantities import COLUMNS
from jointclosure.joint.empirical import barton_bandis, scaled_to
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.standard_errors import Estimate, mean_of

READ = (
    "max_closure",
    "max_closure_net",
    "max_closure_seated_net",
    "residual_closure_seated_net",
    "stiffness_net",
    "kni_net",
    "vm_net",
)
"""Quantities of each cycle. Only first loadings land (`landing_stress`)."""
GEOMETRY = ("rms_height", "rms_slope", "depth_5")
"""Quantities of the pristine walls."""


def runs_of(joints: pd.DataFrame, spectra: list[str]) -> dict[str, xr.Dataset]:
    """Arrange joints by rock over (spectrum, patch, spacing, position, realization, cycle).

    `GEOMETRY` and the status do not depend on the cycle; NaN where nothing was closed.
    """
    over = ("spectrum", "patch", "spacing", "position", "realization")
    runs = {}
    for rock, part in joints.groupby("rock", sort=False):
        run = gridded(part, over, (*READ, *GEOMETRY)).sel(spectrum=spectra)
        geometry = {name: run[name].isel(cycle=0, drop=True) for name in GEOMETRY}
        runs[str(rock)] = run.assign(geometry)
    return runs


def logs_of(run: xr.Dataset, name: str, cycle: int | None = None) -> xr.DataArray:
    """Compute logarithms (..., patch, spacing, realization), means over the patches of a wall.

    NaN where nothing was closed, or a quantity is not positive.
    """
    values = run[name] if cycle is None else run[name].sel(cycle=cycle)
    positive = values.where(values > 0.0)
    return positive.copy(data=np.log(positive.values)).mean("position")


def size_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Compute geometric means at each size and spacing, and their ratios to those of the base.

    ``runs`` are those of `runs_of`, ``base`` is side and spacing [m]. By ``rock``, ``spectrum``,
    ``patch_mm``, ``spacing_mm`` and ``cycle``: numbers of ``joints`` and ``failed`` ones, and of
    each quantity the mean, its ``..._ratio`` and the ``..._error`` of that (pairs of the same
    walls).
    """
    rows = []
    for about, run in _spectra(runs):
        closed = np.isfinite(run.status)
        for patch, spacing in itertools.product(run.patch.values, run.spacing.values):
            size = {"patch": patch, "spacing": spacing}
            joints = int(closed.sel(size).sum())
            if not joints:
                continue
            failed = int((run.status.sel(size) >= FAILURE).sum())
            sizes = {"patch_mm": 1e3 * patch, "spacing_mm": 1e3 * spacing}
            counts = {"joints": joints, "failed": failed}
            for cycle in run.cycle.values.tolist():
                row = about | sizes | counts | {"cycle": cycle}
                for name in (*READ, *GEOMETRY):
                    column, scale = COLUMNS[name]
                    logs = logs_of(run, name, cycle if name in READ else None)
                    here = _at(logs, (patch, spacing))
                    ratio = ratio_of(here - _at(logs, base))
                    known = here[np.isfinite(here)]
                    row[column] = scale * float(np.exp(known.mean())) if known.size else np.nan
                    row[f"{column}_ratio"] = ratio.value
                    row[f"{column}_error"] = ratio.standard_error
                rows.append(row)
    return pd.DataFrame(rows)


def _spectra(runs: Mapping[str, xr.Dataset]) -> Iterator[tuple[dict, xr.Dataset]]:
    """Generate the joints of each rock and spectrum."""
    for rock, run in runs.items():
        for spectrum in run.spectrum.values.tolist():
            yield {"rock": rock, "spectrum": spectrum}, run.sel(spectrum=spectrum)


def _at(logs: xr.DataArray, size: tuple[float, float]) -> np.ndarray:
    return logs.sel(patch=size[0], spacing=size[1], method="nearest").values


def ratio_of(differences: np.ndarray) -> Estimate:
    """Compute a ratio from differences (n,) of logarithms, whose mean is its logarithm."""
    known = differences[np.isfinite(differences)]
    if known.size < 2:
        return Estimate(np.nan, np.nan)
    mean, error = mean_of(known)
    return Estimate(float(np.exp(mean)), float(np.exp(mean)) * error)


def exponent_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Fit powers of patch length and of spacing, and test whether quantities are powers of these.

    By ``reading`` (the quantity), ``cycle`` (0 for the pristine walls) and ``of`` (patch length at
    the base's spacing, or spacing of the base's patch): ``exponent`` and ``error``; ``change``, the
    exponent of the larger half of the range less that of the smaller, its ``change_error``, and
    ``p`` that there is none (t test over realisations).
    """
    rows = []
    for about, run in _spectra(runs):
        cycles = run.cycle.values.tolist()
        for reading, cycle in [*itertools.product(READ, cycles), *((name, 0) for name in GEOMETRY)]:
            logs = logs_of(run, reading, cycle or None)
            for of, line in (
                ("patch", logs.sel(spacing=base[1], method="nearest")),
                ("spacing", logs.sel(patch=base[0], method="nearest")),
            ):
                power = _power(np.log(line[of].values), line.transpose(of, ...).values)
                rows.append(about | {"reading": reading, "cycle": cycle, "of": of} | power)
    return pd.DataFrame(rows)


def _power(size: np.ndarray, logs: np.ndarray) -> dict[str, float]:
    """Fit a power of sizes (k,) to logarithms (k, realization), first for single realisations."""
    known = logs[:, np.isfinite(logs).all(axis=0)]
    power = dict.fromkeys(("exponent", "error", "change", "change_error", "p"), np.nan)
    if len(size) < 2 or known.shape[1] < 2:
        return power
    power["exponent"], power["error"] = mean_of(np.polyfit(size, known, 1)[0])
    local = np.diff(known, axis=0) / np.diff(size)[:, None]
    if len(local) < 2:
        return power
    changes = local[-1] - local[0]
    power["change"], power["change_error"] = mean_of(changes)
    return power | {"p": float(scipy.stats.ttest_1samp(changes, 0.0).pvalue)}


def barton_bandis_table(
    runs: Mapping[str, xr.Dataset],
    base: tuple[float, float],
    rocks: Mapping[str, tuple[float, float, float]],
    strength_ratio: float,
) -> pd.DataFrame:
    """Compare changes from the smallest patch to larger ones with those of Barton and Bandis.

    ``rocks`` has JRC, sigma_c [Pa] and maximum stress [Pa], which the smallest patch is taken to
    have, ``strength_ratio`` is its sigma_c/JCS. By ``reading``, ``cycle``, ``from_mm`` and
    ``to_mm``: the model's ``ratio`` with its ``error``, and ``barton_bandis``.
    """
    rows = []
    for rock, run in runs.items():
        smallest, *larger = run.patch.values.tolist()
        for cycle, spectrum in itertools.product(run.cycle.values, run.spectrum.values.tolist()):
            known, *laws = (
                law_of_size(patch / smallest, rocks[rock], strength_ratio, cycle)
                for patch in (smallest, *larger)
            )
            for reading in known:
                logs = logs_of(run.sel(spectrum=spectrum), reading, cycle)
                for patch, law in zip(larger, laws, strict=True):
                    large, small = (_at(logs, (length, base[1])) for length in (patch, smallest))
                    ratio = ratio_of(large - small)
                    row = {"rock": rock, "spectrum": spectrum, "reading": reading, "cycle": cycle}
                    row |= {"from_mm": 1e3 * smallest, "to_mm": 1e3 * patch}
                    row |= {"ratio": ratio.value, "error": ratio.standard_error}
                    rows.append(row | {"barton_bandis": law[reading] / known[reading]})
    return pd.DataFrame(rows)


def law_of_size(
    times: float, rock: tuple[float, float, float], strength_ratio: float, cycle: int
) -> dict[str, float]:
    """Apply the law of Barton and Bandis to a joint of so many ``times`` the length of a known one.

    ``rock`` is JRC, sigma_c [Pa] and maximum stress [Pa] of the known joint, ``strength_ratio``
    its sigma_c/JCS. Returns stiffnesses [Pa/m] and closures [m] by the names of the model's
    quantities. The law's closures are those of the joint without the rock, and count from seating.
    """
    jrc, strength, stress = rock
    jrc, wall_strength = scaled_to(times, jrc, strength / strength_ratio, 1.0)
    law = barton_bandis(jrc, strength, strength / wall_strength, cycle)
    half, whole = law.closure(np.array([0.5, 1.0]) * stress)
    return {
        "kni_net": law.initial_stiffness,
        "vm_net": law.largest_closure,
        "stiffness_net": 0.5 * stress / float(whole - half),
        "max_closure_seated_net": float(whole),
    }
