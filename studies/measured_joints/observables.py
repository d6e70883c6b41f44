"""Simulated joints beside three measured joints: observables, fitted mismatch, and judgement.

Measured values are in `jointclosure.uncertainty.published_joints`. Walls that mate have the
wavelength at which the mean closure of the first loading is that of a measured joint. A measured
value agrees if its range overlaps the 95 % interval of a single simulated joint.

A joint is also predicted from others. The prediction is the distribution of one more joint,
averaged over the wavelengths. Weights are the likelihoods of the wavelengths for the first closures
of the others; no wavelength within the simulated range is preferred beforehand.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from jointclosure.ensembles.quantities import heading
from jointclosure.joint.status import FAILURE
from jointclosure.measured.likelihood import Likelihood, Readings, likelihood_of
from jointclosure.statistics.chance import chance_of_scores
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.uncertainty.published_joints import JOINTS, measured

BASE = "default choices"
"""Name of the model with its default choices."""
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
FITTED = "first_closure"
"""Observable to which the mismatch wavelength is fitted, and which is not judged."""
UPPER_BOUND = "contact_share"
"""Observable that is an upper bound, so that no measured value is too small."""
PREDICTED = ("first_closure", "first_stiffness", "later_closure", "later_stiffness")
CLOSURE_ERROR = 0.04
"""Relative error of the measured first closures: two digits of a figure."""
RESAMPLES = 1000
AGREES = "agrees"


def observables_of(joints: pd.DataFrame, film_cells: float) -> pd.DataFrame:
    """Compute `OBSERVABLES` of each joint that did not fail, by ``variant`` and ``wavelength``.

    Later loading is the second cycle. If a joint has one cycle only, this is its later loading, and
    its first loading is that of the same walls in the variant ``loaded_as``. ``film_cells`` is the
    number of grid cells in a cell of the film that measures contact: its contact area is at most so
    many times larger.
    """
    joints = joints[joints.status < FAILURE]
    at = ["variant", "wavelength", "realization"]
    cycles = {number: part.set_index(at) for number, part in joints.groupby("cycle")}
    first = cycles[1]
    second = cycles[2]
    once = first[~first.index.isin(second.index)]
    later = pd.concat([second, once])
    loaded = once.reset_index()[["loaded_as", *at[1:]]]
    base = first.reindex(pd.MultiIndex.from_frame(loaded)).set_axis(once.index)
    before = pd.concat([first.loc[second.index], base])
    columns: dict = {}
    for name, part in (("first", before), ("later", later)):
        closure = part.max_closure_seated_net
        stays = part.residual_closure_seated_net
        columns[f"{name}_closure"] = 1e3 * closure
        columns[f"{name}_residual_share"] = 100.0 * stays / closure
        columns[f"{name}_stiffness"] = 1e-9 * part.stiffness_net
    columns["stiffness_ratio"] = later.stiffness_net / before.stiffness_net
    columns["contact_share"] = 100.0 * np.minimum(1.0, film_cells * later.contact_at_max)
    return pd.DataFrame(columns)[list(OBSERVABLES)].dropna().reset_index()


class _Walls(NamedTuple):
    """Walls beside a measured joint, and observables of their joints.

    ``values`` are (surfaces, observables), ``resampled`` (resamples, observables + 1) their means
    in resamples of the surfaces, and the ``wavelength`` [m] that is fitted to each.
    """

    walls: str
    joint: str
    wavelength: float
    values: np.ndarray
    resampled: np.ndarray


def judged_joints(observables: pd.DataFrame, root_seed: int) -> pd.DataFrame:
    """Compare each variant and kind of walls with each measured joint.

    ``value`` is the mean over surfaces. Its standard ``error`` is that of a bootstrap over
    surfaces, in which the wavelength is fitted anew. ``low`` and ``high`` are the ends of the 95 %
    interval of a single joint. Units are those of `OBSERVABLES`.
    """
    rows = []
    for variant, part in observables.groupby("variant", sort=False):
        for walls in _walls(part, root_seed):
            at = {"variant": variant, "walls": walls.walls, "joint": walls.joint}
            lengths = walls.resampled[:, -1]
            at["wavelength_mm"] = 1e3 * walls.wavelength
            at["wavelength_error"] = 1e3 * lengths.std() if np.isfinite(lengths).all() else np.nan
            for i, (name, (_, unit)) in enumerate(OBSERVABLES.items()):
                low, high = single_joint_interval(walls.values[:, i])
                low = 0.0 if name == UPPER_BOUND else low
                row = at | {"observable": name, "unit": unit}
                row |= {"value": walls.values[:, i].mean(), "error": walls.resampled[:, i].std()}
                row |= {"low": low, "high": high} | _judged(name, walls.joint, low, high)
                rows.append(row | {"surfaces": len(walls.values)})
    return pd.DataFrame(rows)


def score_table(judged: pd.DataFrame, constants: pd.Series) -> pd.DataFrame:
    """Count the judged values of all joints that each variant of mated walls agrees with.

    ``chance`` is the probability of this score or a better one by chance, see `chance_of_scores`;
    ``constants``, by variant, is the number of constants that were chosen besides the wavelength.
    """
    judged = judged[(judged.walls == "mated") & (judged.observable != FITTED)]
    variants = list(dict.fromkeys(judged.variant))
    columns = ["value", "low", "high", "measured_low", "measured_high"]
    wide = judged.set_index(["variant", "observable", "joint"])[columns].to_xarray()
    value, low, high, *measured = (wide[name].sel(variant=variants).values for name in columns)
    counts = constants[variants].to_numpy()
    ranges = measured[0][0], measured[1][0]
    seed = seed_of(0, "measured joints by chance")
    score, chance = chance_of_scores(value, (low, high), ranges, counts, seed)
    table = {"variant": variants, "constants": counts, "score": score}
    return pd.DataFrame(table | {"of": value[0].size, "chance": chance})


def _judged(name: str, joint: str, low: float, high: float) -> dict:
    """Return the range of a measured value, and how it compares with an interval of the model."""
    known = measured(name, joint)
    off = "too large" if known.high < low else "too small" if known.low > high else AGREES
    return {"measured_low": known.low, "measured_high": known.high, "judgement": off}


def single_joint_interval(values: np.ndarray) -> tuple[float, float]:
    """Compute the 95 % prediction interval of one more value; log-normal if all are positive."""
    logarithmic = bool((values > 0.0).all())
    scaled = np.log(values) if logarithmic else values
    count = values.size
    half = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1) * scaled.std(ddof=1)
    half *= np.sqrt(1.0 + 1.0 / count)
    ends = scaled.mean() - half, scaled.mean() + half
    low, high = (float(np.exp(end)) if logarithmic else max(float(end), 0.0) for end in ends)
    return low, high


def _walls(part: pd.DataFrame, root_seed: int) -> Iterator[_Walls]:
    """Generate for each measured joint a variant's independent walls, and those fitted to it."""
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
            means = values[-1][draws].mean(axis=1)
            resampled = np.column_stack([means, np.full(len(means), np.inf)])
            yield _Walls("independent", joint, np.inf, values[-1], resampled)
        closure = measured("first_closure", joint).value
        logs = np.log(lengths[finite])
        mated = values[finite]
        best = fitted_length(logs, mated[:, :, 0].mean(axis=1), closure)
        fitted = []
        for draw in draws:
            at = fitted_length(logs, mated[:, draw, 0].mean(axis=1), closure)
            fitted.append([*_between(logs, mated[:, draw], at).mean(axis=0), np.exp(at)])
        at_best = _between(logs, mated, best)
        yield _Walls("mated", joint, float(np.exp(best)), at_best, np.array(fitted))


def fitted_length(logs: np.ndarray, means: np.ndarray, closure: float) -> float:
    """Find the logarithm of the wavelength at which the mean closure has a value.

    Means at the wavelengths, whose logarithms are ``logs``, are first made to increase by isotonic
    regression. Beyond their range the result is the first or the last wavelength.
    """
    rising = scipy.optimize.isotonic_regression(means).x
    rising = rising * (1.0 + 1e-12 * np.arange(rising.size))  # np.interp needs it to increase
    return float(np.interp(closure, rising, logs))


def _between(logs: np.ndarray, values: np.ndarray, at: float) -> np.ndarray:
    """Interpolate values (wavelengths, joints, observables) linearly at a logarithm."""
    i = int(np.clip(np.searchsorted(logs, at) - 1, 0, logs.size - 2))
    part = np.clip((at - logs[i]) / (logs[i + 1] - logs[i]), 0.0, 1.0)
    return (1.0 - part) * values[i] + part * values[i + 1]


def prediction_table(observables: pd.DataFrame) -> pd.DataFrame:
    """Predict each measured joint from one other joint, and from all others together.

    The variant is `BASE`. Intervals (``low`` to ``high``) are those of 95 %.
    """
    base = observables[(observables.variant == BASE) & np.isfinite(observables.wavelength)]
    fits = {joint: _likelihood(base, "first_closure", joint) for joint in JOINTS}
    readings = {name: _likelihood(base, name, JOINTS[0]) for name in PREDICTED}
    rows = []
    for count in range(1, len(JOINTS)):
        for fitted in combinations(JOINTS, count):
            logs = np.sum([fits[joint].log[:, 0] for joint in fitted], axis=0)
            weights = np.exp(logs - logs.max())
            for joint in (joint for joint in JOINTS if joint not in fitted):
                for name, reading in readings.items():
                    low, median, high = _quantiles(weights, reading)
                    row: dict = {"fitted_to": "+".join(fitted), "joint": joint, "observable": name}
                    row |= {"low": low, "median": median, "high": high}
                    row |= _judged(name, joint, low, high)
                    rows.append(row | {"hit": int(row["judgement"] == AGREES)})
    return pd.DataFrame(rows)


def _likelihood(base: pd.DataFrame, name: str, joint: str) -> Likelihood:
    """Compute mean and scatter of an observable over the wavelengths, and their likelihood.

    The likelihood compares the observable with the first closure of a measured joint: it has a
    meaning only for the observable "first_closure".
    """
    wide = base.pivot_table(index="wavelength", columns="realization", values=name)
    logs = np.log(wide.to_numpy())[:, np.newaxis, :, np.newaxis]
    closure = np.array([measured("first_closure", joint).value])
    reading = Readings(1, (), np.array([1.0]), 0.0, closure)
    return likelihood_of(reading, logs, wide.index.to_numpy(), np.ones(1), CLOSURE_ERROR)


def _quantiles(weights: np.ndarray, likelihood: Likelihood) -> list[float]:
    """Compute low end, median and high end of a prediction; weights (n,) are of the wavelengths."""
    means = likelihood.means[:, 0, 0]
    scatter = likelihood.scatter[:, 0]
    share = weights / weights.sum()

    def below(value: float) -> float:
        return float(share @ scipy.stats.norm.cdf((value - means) / scatter))

    ends = float((means - 10.0 * scatter).min()), float((means + 10.0 * scatter).max())
    levels = (0.5 - 0.5 * CONFIDENCE, 0.5, 0.5 + 0.5 * CONFIDENCE)
    roots = (scipy.optimize.brentq(lambda x, p=p: below(x) - p, *ends) for p in levels)
    return [float(np.exp(root)) for root in roots]
