"""Prediction of measured joints by a mismatch wavelength that was fitted to other joints.

The likelihood of the wavelength is that of `jointclosure.measured.calibration`, from the closure of
the first loading. A prediction is the distribution of one more joint, averaged over the wavelengths
by their likelihood (no wavelength within the simulated range is preferred before).
"""

from itertools import combinations

import numpy as np
import pandas as pd
import scipy

from jointclosure.engine.measured_joints import JOINTS, measured
from jointclosure.measured.calibration import Likelihood, Readings, likelihood_of
from studies.measured_joints.observables import AGREES, BASE, CONFIDENCE, judgement

PREDICTED = ("first_closure", "first_stiffness", "later_closure", "later_stiffness")
CLOSURE_ERROR = 0.04
"""Relative error of the measured first closures: two digits of a figure."""


def prediction_table(observables: pd.DataFrame) -> pd.DataFrame:
    """Predict each measured joint from each other one, and from all others.

    Parameters
    ----------
    observables : DataFrame
        As from `studies.measured_joints.observables.observables_of`.

    Returns
    -------
    DataFrame
        ``fitted_to`` (joints, as in "1+2"), ``joint``, ``observable``, ``low``, ``median``,
        ``high`` of the 95 % interval, ``measured_low``, ``measured_high``, ``judgement``, ``hit``.
    """
    base = observables[(observables.variant == BASE) & np.isfinite(observables.wavelength)]
    lengths = np.sort(base.wavelength.unique())
    likelihoods = {
        (name, joint): _likelihood(base, lengths, name, measured("first_closure", joint).value)
        for name in PREDICTED
        for joint in (JOINTS if name == "first_closure" else JOINTS[:1])
    }
    rows = []
    for count in range(1, len(JOINTS)):
        for fitted in combinations(JOINTS, count):
            logs = np.sum(
                [likelihoods["first_closure", joint].log[:, 0] for joint in fitted], axis=0
            )
            weights = np.exp(logs - logs.max())
            for joint in (joint for joint in JOINTS if joint not in fitted):
                for name in PREDICTED:
                    low, median, high = _quantiles(weights, likelihoods[name, JOINTS[0]])
                    known = measured(name, joint)
                    answer = judgement(known, low, high)
                    rows.append(
                        {"fitted_to": "+".join(fitted), "joint": joint, "observable": name}
                        | {"low": low, "median": median, "high": high}
                        | {"measured_low": known.low, "measured_high": known.high}
                        | {"judgement": answer, "hit": int(answer == AGREES)}
                    )
    return pd.DataFrame(rows)


def _likelihood(base: pd.DataFrame, lengths: np.ndarray, name: str, value: float) -> Likelihood:
    """Compute the likelihood of one reading over the wavelengths, with its mean and scatter."""
    wide = base.pivot_table(index="wavelength", columns="realization", values=name).loc[lengths]
    logs = np.log(wide.to_numpy())[:, np.newaxis, :, np.newaxis]
    reading = Readings(1, (), np.array([1.0]), 0.0, np.array([value]))
    return likelihood_of(reading, logs, lengths, np.ones(1), CLOSURE_ERROR)


def _quantiles(weights: np.ndarray, likelihood: Likelihood) -> list[float]:
    """Compute low end, median and high end of the prediction of a reading."""
    means, scatter = likelihood.means[:, 0, 0], likelihood.scatter[:, 0]
    share = weights / weights.sum()

    def below(value: float) -> float:
        return float(share @ scipy.stats.norm.cdf((value - means) / scatter))

    ends = float((means - 10.0 * scatter).min()), float((means + 10.0 * scatter).max())
    levels = (0.5 - 0.5 * CONFIDENCE, 0.5, 0.5 + 0.5 * CONFIDENCE)
    roots = (scipy.optimize.brentq(lambda x, p=p: below(x) - p, *ends) for p in levels)
    return [float(np.exp(root)) for root in roots]
