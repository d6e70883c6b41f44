"""Simulated joints beside three measured joints: observables, fitted mismatch, and judgement.

Measured values are in `jointclosure.engine.measured_joints`. Walls that mate have the
wavelength at which the mean closure of the first loading is that of a measured joint. A measured
value agrees if its range overlaps the 95 % interval of a single simulated joint.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from jointclosure.engine.measured_joints import JOINTS, Measured, measured
from jointclosure.engine.quantities import heading
from jointclosure.joint.protocol import FAILURE
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.statistics.randomness import generator, seed_of

BASE = "default choices"
"""Name of the model with its default choices."""
FILM_CELL = 0.5e-3
"""Spacing of the measured maps of contact stress [m]."""
OBSERVABLES = {
    "first_closure": ("closure, first loading", "mm"),
    "first_residual_share": ("share of first closure that stays", "%"),
    "first_stiffness": ("stiffness, first loading", "MPa/mm"),
    "later_closure": ("closure, later loading", "mm"),
    "later_stiffness": ("stiffness, later loading", "MPa/mm"),
    "stiffness_ratio": ("stiffness, later over first", "1"),
    "later_residual_share": ("share of later closure that stays", "%"),
    "contact_share": ("contact area, at most", "%"),
}
"""Titles and units of observables of a joint."""
HEADINGS = {name: heading(*about) for name, about in OBSERVABLES.items()}
"""Headings of tables and labels of axes, by observable."""
UPPER_BOUNDS = ("contact_share",)
"""Observables that are upper bounds, so that no measured value is too small for them."""
CONFIDENCE = 0.95
RESAMPLES = 1000
AGREES, TOO_SMALL, TOO_LARGE = "agrees", "too small", "too large"


def observables_of(joints: pd.DataFrame, film_cells: float) -> pd.DataFrame:
    """Compute the observables of each joint.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.engine.points.close_points`, with the columns ``variant``,
        ``wavelength`` [m] and ``loaded_as``: the variant that has the first loading of a variant of
        one cycle, which is a later loading.
    film_cells : float
        Number of cells of the grid in a cell of the film. The observed area of contact is at most
        this many times that of the cells in contact, and at most all.

    Returns
    -------
    DataFrame
        ``variant``, ``wavelength``, ``realization``, `OBSERVABLES`; without failed joints.
    """
    joints = joints[joints.status < FAILURE]
    at = ["variant", "wavelength", "realization"]
    cycles = {number: part.set_index(at) for number, part in joints.groupby("cycle")}
    first, second = cycles[1], cycles[2]
    once = first[~first.index.isin(second.index)]
    later = pd.concat([second, once])
    loaded = once.reset_index()[["loaded_as", *at[1:]]]
    base = first.reindex(pd.MultiIndex.from_frame(loaded)).set_axis(once.index)
    before = pd.concat([first.loc[second.index], base])
    table = pd.DataFrame(
        {
            "first_closure": 1e3 * before.max_closure_seated_net,
            "first_residual_share": 100.0
            * before.residual_closure_seated_net
            / before.max_closure_seated_net,
            "first_stiffness": 1e-9 * before.stiffness_net,
            "later_closure": 1e3 * later.max_closure_seated_net,
            "later_stiffness": 1e-9 * later.stiffness_net,
            "stiffness_ratio": later.stiffness_net / before.stiffness_net,
            "later_residual_share": 100.0
            * later.residual_closure_seated_net
            / later.max_closure_seated_net,
            "contact_share": 100.0 * np.minimum(1.0, film_cells * later.contact_at_max),
        }
    )
    return table.dropna().reset_index()


def digitised_curve(joint: str) -> MeasuredCurve:
    """Return both loadings of a measured joint, with the points that were read off.

    These are seating and the largest stress, the return to seating, and half of the largest stress
    on the later loading, by its stiffness. Closures are net of the rock.
    """
    stress, seating = (measured(name).value for name in ("largest_stress", "seating_stress"))
    first, later, stiffness = (
        measured(name, joint).value
        for name in ("first_closure", "later_closure", "later_stiffness")
    )
    stays, later_stays = (
        0.01 * measured(f"{name}_residual_share", joint).value for name in ("first", "later")
    )
    half = later - 0.5 * stress / stiffness
    points = np.array(
        [
            (seating, 0.0, 1), (stress, first, 1), (seating, stays * first, 1),
            (seating, 0.0, 2), (0.5 * stress, half, 2), (stress, later, 2),
            (seating, later_stays * later, 2),
        ]
    )  # fmt: skip
    stresses, closures, cycles = points.T
    lines = np.arange(1, len(points) + 1)
    return MeasuredCurve(1e6 * stresses, 1e-3 * closures, cycles.astype(int), lines)


class _Walls(NamedTuple):
    """Walls of a row, and observables of their joints for given surfaces (..., observables)."""

    name: str
    joint: str
    wavelength: float
    values: np.ndarray
    resampled: np.ndarray


def judged_joints(observables: pd.DataFrame, root_seed: int) -> pd.DataFrame:
    """Compare each variant and kind of walls with each measured joint.

    Parameters
    ----------
    observables : DataFrame
        As from `observables_of`.
    root_seed : int
        Root seed of the study, for the resamples.

    Returns
    -------
    DataFrame
        ``variant``, ``walls`` ("independent" or "mated"), ``joint``, fitted ``wavelength_mm``
        (infinite: independent) with its ``wavelength_error``, ``observable``, ``unit``, mean
        ``value`` over surfaces with its standard ``error`` (bootstrap over surfaces, with the
        wavelength fitted anew), ``low`` and ``high`` end of the 95 % interval of a single joint,
        ``measured_low``, ``measured_high``, ``judgement``, number of ``surfaces``.
    """
    rows = []
    for variant, part in observables.groupby("variant", sort=False):
        for walls in _walls(part, root_seed):
            lengths = walls.resampled[:, -1]
            about = {
                "variant": variant,
                "walls": walls.name,
                "joint": walls.joint,
                "wavelength_mm": 1e3 * walls.wavelength,
                "wavelength_error": 1e3 * lengths.std() if np.isfinite(lengths).all() else np.nan,
            }
            for i, (name, (_, unit)) in enumerate(OBSERVABLES.items()):
                low, high = single_joint_interval(walls.values[:, i])
                low = 0.0 if name in UPPER_BOUNDS else low
                row = about | {"observable": name, "unit": unit}
                row |= {"value": walls.values[:, i].mean(), "error": walls.resampled[:, i].std()}
                row |= {"low": low, "high": high}
                known = measured(name, walls.joint)
                row |= {"measured_low": known.low, "measured_high": known.high}
                row |= {"judgement": judgement(known, low, high), "surfaces": len(walls.values)}
                rows.append(row)
    return pd.DataFrame(rows)


def judgement(known: Measured, low: float, high: float) -> str:
    """Compare the range of a measured value with the interval of the model."""
    if known.high < low:
        return TOO_LARGE
    return TOO_SMALL if known.low > high else AGREES


def single_joint_interval(values: np.ndarray) -> tuple[float, float]:
    """Compute the 95 % prediction interval of one more joint, from logarithms if all are positive.

    It contains the error of the mean, and takes joints as (log-)normal.
    """
    logarithmic = bool((values > 0.0).all())
    scaled = np.log(values) if logarithmic else values
    count = values.size
    half = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1) * scaled.std(ddof=1)
    half *= np.sqrt(1.0 + 1.0 / count)
    ends = scaled.mean() - half, scaled.mean() + half
    low, high = (float(np.exp(end)) if logarithmic else max(float(end), 0.0) for end in ends)
    return low, high


def _walls(part: pd.DataFrame, root_seed: int) -> Iterator[_Walls]:
    """Generate the walls of a variant: independent ones, and those fitted to each joint."""
    names = list(OBSERVABLES)
    wide = part.pivot_table(index="realization", columns="wavelength", values=names).dropna()
    count = len(wide)
    draws = generator(seed_of(root_seed, "measured joints")).integers(
        count, size=(RESAMPLES, count)
    )
    lengths = np.sort(part.wavelength.unique())
    values = np.stack([wide.xs(length, axis=1, level=1)[names].to_numpy() for length in lengths])
    finite = np.isfinite(lengths)
    for joint in JOINTS:
        if not finite.all():
            free = values[-1]
            yield _Walls("independent", joint, np.inf, free, _means(free, draws, np.inf))
        closure = measured("first_closure", joint).value
        logs, mated = np.log(lengths[finite]), values[finite]
        best = fitted_length(logs, mated[:, :, 0].mean(axis=1), closure)
        resampled = []
        for draw in draws:
            at = fitted_length(logs, mated[:, draw, 0].mean(axis=1), closure)
            resampled.append([*_between(logs, mated[:, draw], at).mean(axis=0), np.exp(at)])
        at_best = _between(logs, mated, best)
        yield _Walls("mated", joint, float(np.exp(best)), at_best, np.array(resampled))


def _means(values: np.ndarray, draws: np.ndarray, wavelength: float) -> np.ndarray:
    means = values[draws].mean(axis=1)
    return np.column_stack([means, np.full(len(means), wavelength)])


def fitted_length(logs: np.ndarray, means: np.ndarray, closure: float) -> float:
    """Find the logarithm of the wavelength at which the mean closure has a value.

    Closure grows with the wavelength (isotonic regression), along straight lines over its
    logarithm. A closure beyond the ends gives the end.
    """
    rising = scipy.optimize.isotonic_regression(means).x
    rising = rising * (1.0 + 1e-12 * np.arange(rising.size))  # np.interp needs it to increase
    return float(np.interp(closure, rising, logs))


def _between(logs: np.ndarray, values: np.ndarray, at: float) -> np.ndarray:
    """Interpolate values (wavelengths, joints, observables) linearly at a logarithm."""
    i = int(np.clip(np.searchsorted(logs, at) - 1, 0, logs.size - 2))
    part = np.clip((at - logs[i]) / (logs[i + 1] - logs[i]), 0.0, 1.0)
    return (1.0 - part) * values[i] + part * values[i + 1]
