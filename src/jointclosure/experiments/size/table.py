"""What patch length and spacing do: ratios of the same joints, exponents, and Barton and Bandis.

Joints of a size scatter about a typical one by a factor, so means are those of logarithms. Of each
realisation the mean over its patches of one size counts once: patches of one wall are not drawn
independently.
"""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.engineering.empirical import barton_bandis, scaled_to
from jointclosure.ensemble.points import gridded
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.standard_errors import Estimate, mean_of

READ = (
    "closure",
    "closure_net",
    "closure_seated_net",
    "residual_seated_net",
    "stiffness_net",
    "kni_net",
    "vm_net",
)
"""Quantities of each cycle. Only first loadings land (`ensemble.responses.responses_of`)."""
GEOMETRY = ("rms_height", "rms_slope", "depth_5")
"""Quantities of the pristine walls."""
COLUMNS = {
    "closure": ("closure_mm", 1e3),
    "closure_net": ("closure_net_mm", 1e3),
    "closure_seated_net": ("closure_seated_net_mm", 1e3),
    "residual_seated_net": ("residual_closure_mm", 1e3),
    "stiffness_net": ("net_stiffness_MPa_per_mm", 1e-9),
    "kni_net": ("net_kni_MPa_per_mm", 1e-9),
    "vm_net": ("net_vm_mm", 1e3),
    "rms_height": ("rms_height_mm", 1e3),
    "rms_slope": ("rms_slope", 1.0),
    "depth_5": ("depth_5_mm", 1e3),
}
"""Columns of the table of sizes, and their scale."""


def runs_of(joints: pd.DataFrame, spectra: list[str]) -> dict[str, xr.Dataset]:
    """Joints of each rock over (spectrum, patch, spacing, position, realization, cycle).

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
    """Logarithms over (..., patch, spacing, realization), means over the patches of a wall.

    NaN where nothing was closed, or nothing positive was read.
    """
    values = run[name] if cycle is None else run[name].sel(cycle=cycle)
    positive = values.where(values > 0.0)
    return positive.copy(data=np.log(positive.values)).mean("position")


def size_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Typical readings at each size and spacing, and their ratio to the base's.

    Parameters
    ----------
    runs : mapping
        By rock, datasets over (spectrum, patch, spacing, position, realization, cycle), as from
        `runs_of`.
    base : (float, float)
        Side [m] and spacing [m] of the joints that others are held against.

    Returns
    -------
    DataFrame
        ``rock``, ``spectrum``, ``patch_mm``, ``spacing_mm``, ``cycle``, ``joints`` and how many
        of these failed; of each reading the geometric mean in the unit of its column, its
        ``..._ratio`` to the base, and the ``..._error`` of the ratio (pairs of the same walls).
    """
    rows = []
    for rock, run in runs.items():
        for spectrum in run.spectrum.values.tolist():
            own = run.sel(spectrum=spectrum)
            for patch, spacing in _sizes(own):
                status = own.status.sel(patch=patch, spacing=spacing)
                about = {
                    "rock": rock,
                    "spectrum": spectrum,
                    "patch_mm": 1e3 * patch,
                    "spacing_mm": 1e3 * spacing,
                    "joints": int(np.isfinite(status).sum()),
                    "failed": int((status >= FAILURE).sum()),
                }
                for cycle in run.cycle.values.tolist():
                    row = about | {"cycle": cycle}
                    for name in (*READ, *GEOMETRY):
                        logs = logs_of(own, name, cycle if name in READ else None)
                        row |= _ratio(name, logs, (patch, spacing), base)
                    rows.append(row)
    return pd.DataFrame(rows)


def _sizes(run: xr.Dataset) -> list[tuple[float, float]]:
    """Sides and spacings [m] that were closed."""
    closed = np.isfinite(run.status).any(("position", "realization"))
    return [
        (float(patch), float(spacing))
        for patch in run.patch.values
        for spacing in run.spacing.values
        if bool(closed.sel(patch=patch, spacing=spacing))
    ]


def _at(logs: xr.DataArray, size: tuple[float, float]) -> np.ndarray:
    return logs.sel(patch=size[0], spacing=size[1], method="nearest").values


def _ratio(
    name: str, logs: xr.DataArray, size: tuple[float, float], base: tuple[float, float]
) -> dict[str, float]:
    """Typical value, and its ratio to the base's with its error."""
    column, scale = COLUMNS[name]
    own = _at(logs, size)
    ratio = ratio_of(own - _at(logs, base))
    known = own[np.isfinite(own)]
    typical = scale * float(np.exp(known.mean())) if known.size else np.nan
    named = {f"{column}_ratio": ratio.value, f"{column}_error": ratio.standard_error}
    return {column: typical} | named


def ratio_of(differences: np.ndarray) -> Estimate:
    """Ratio whose logarithm is the mean of differences (n,) of logarithms, and its error."""
    known = differences[np.isfinite(differences)]
    if known.size < 2:
        return Estimate(np.nan, np.nan)
    mean, error = mean_of(known)
    return Estimate(float(np.exp(mean)), float(np.exp(mean)) * error)


def exponent_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Powers of patch length and of spacing, and whether they are powers.

    Parameters as for `size_table`.

    Returns
    -------
    DataFrame
        ``rock``, ``spectrum``, ``reading``, ``cycle`` (0 for the pristine walls), ``of`` (patch
        length at the base's spacing, or spacing of the base's patch), the fitted ``exponent`` and
        its ``error``; ``change``: the exponent of the larger half of the range less that of the
        smaller, its ``change_error``, and ``p`` that there is none (t test over realisations).
    """
    rows = []
    for rock, run in runs.items():
        for spectrum in run.spectrum.values.tolist():
            own = run.sel(spectrum=spectrum)
            for reading, cycle, logs in _readings(own):
                for of, line in (
                    ("patch", logs.sel(spacing=base[1], method="nearest")),
                    ("spacing", logs.sel(patch=base[0], method="nearest")),
                ):
                    about = {"rock": rock, "spectrum": spectrum, "reading": reading}
                    found = _power(np.log(line[of].values), line.transpose(of, ...).values)
                    rows.append(about | {"cycle": cycle, "of": of} | found)
    return pd.DataFrame(rows)


def _readings(run: xr.Dataset) -> Iterator[tuple[str, int, xr.DataArray]]:
    for name in READ:
        for cycle in run.cycle.values.tolist():
            yield name, cycle, logs_of(run, name, cycle)
    for name in GEOMETRY:
        yield name, 0, logs_of(run, name)


def _power(size: np.ndarray, logs: np.ndarray) -> dict[str, float]:
    """Exponent over sizes (k,) of logarithms (k, realization), one for each realisation first."""
    known = logs[:, np.isfinite(logs).all(axis=0)]
    nothing = dict.fromkeys(("exponent", "error", "change", "change_error", "p"), np.nan)
    if len(size) < 2 or known.shape[1] < 2:
        return nothing
    exponent, error = mean_of(np.polyfit(size, known, 1)[0])
    local = np.diff(known, axis=0) / np.diff(size)[:, None]
    found = nothing | {"exponent": exponent, "error": error}
    if len(local) < 2:
        return found
    changes = local[-1] - local[0]
    change, doubt = mean_of(changes)
    p = float(scipy.stats.ttest_1samp(changes, 0.0).pvalue)
    return found | {"change": change, "change_error": doubt, "p": p}


def barton_bandis_table(
    runs: Mapping[str, xr.Dataset],
    base: tuple[float, float],
    rocks: Mapping[str, tuple[float, float, float]],
    strength_ratio: float,
) -> pd.DataFrame:
    """Changes from the smallest patch to larger ones, beside those of Barton and Bandis.

    Parameters
    ----------
    runs, base
        As for `size_table`.
    rocks : mapping
        By rock: JRC, sigma_c [Pa], maximum stress [Pa]. The smallest patch is taken to have them.
    strength_ratio : float
        sigma_c/JCS of the smallest patch.

    Returns
    -------
    DataFrame
        ``rock``, ``spectrum``, ``reading``, ``cycle``, ``from_mm``, ``to_mm``, the model's
        ``ratio`` with its ``error``, and ``barton_bandis``.
    """
    rows = []
    for rock, run in runs.items():
        smallest, *larger = run.patch.values.tolist()
        for cycle in run.cycle.values.tolist():
            laws = {
                patch: law_of_size(patch / smallest, rocks[rock], strength_ratio, cycle)
                for patch in run.patch.values.tolist()
            }
            for spectrum in run.spectrum.values.tolist():
                for reading in laws[smallest]:
                    logs = logs_of(run.sel(spectrum=spectrum), reading, cycle)
                    for patch in larger:
                        small, large = (_at(logs, (each, base[1])) for each in (smallest, patch))
                        found = ratio_of(large - small)
                        rows.append(
                            {
                                "rock": rock,
                                "spectrum": spectrum,
                                "reading": reading,
                                "cycle": cycle,
                                "from_mm": 1e3 * smallest,
                                "to_mm": 1e3 * patch,
                                "ratio": found.value,
                                "error": found.standard_error,
                                "barton_bandis": laws[patch][reading] / laws[smallest][reading],
                            }
                        )
    return pd.DataFrame(rows)


def law_of_size(
    times: float, rock: tuple[float, float, float], strength_ratio: float, cycle: int
) -> dict[str, float]:
    """What the law of Barton and Bandis says of a joint so many times as long as one that is known.

    Parameters
    ----------
    times : float
    rock : (float, float, float)
        JRC, sigma_c [Pa] and maximum stress [Pa] of the known joint.
    strength_ratio : float
        sigma_c/JCS of the known joint.
    cycle : int

    Returns
    -------
    dict
        Initial stiffness and stiffness from half of the stress on [Pa/m], largest closure and that
        at the stress [m], by the names of the model's readings. The law's closures are of the
        joint without the rock, and count from seating.
    """
    jrc, strength, stress = rock
    jrc, wall_strength = scaled_to(times, jrc, strength / strength_ratio, 1.0)
    law = barton_bandis(jrc, strength, strength / wall_strength, cycle)
    half, whole = law.closure(np.array([0.5, 1.0]) * stress)
    return {
        "kni_net": law.initial_stiffness,
        "vm_net": law.largest_closure,
        "stiffness_net": 0.5 * stress / float(whole - half),
        "closure_seated_net": float(whole),
    }
