"""Averages over models that could have given a published table, weighted by its likelihood.

The log-likelihood of a table is the sum over its entries, as in
`jointclosure.statistics.joint_tests`. Entries depend on each other, so such a sum separates models
more sharply than the table does. Weights are therefore proportional to the likelihood to a power,
the `sharpness`: the power at which the weights of tables that were drawn from the models are, on
average, the most probable for the model from which each was drawn. Before the table is seen, all
models are equally probable.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.joint_tests import log_densities

_SHARPNESS = (1e-3, 10.0)
"""Range of the power of the likelihood."""


class Comparison(NamedTuple):
    """Log densities of all entries of tables under all models.

    Densities are estimated from one half of the repetitions of a model and evaluated at the other
    half, in both directions (first axis).

    ``observed`` (2, models, entries): those of the published table.
    ``drawn`` (2, models, sources, tables, entries): those of tables drawn from each model (source).
    """

    observed: np.ndarray
    drawn: np.ndarray


def compare(lengths, observed) -> Comparison:
    """Evaluate a published table and repetitions of all models under each model.

    Parameters
    ----------
    lengths : array (models, R, entries)
        Lengths of repeated studies, infinite without a root.
    observed : array (entries,)
        Published lengths, in the same unit and order; NaN or infinite for a dash.

    Raises
    ------
    InputError
        If shapes do not fit, or there are fewer than two models or 100 repetitions.
    """
    lengths, observed = np.asarray(lengths, dtype=float), np.asarray(observed, dtype=float)
    if lengths.ndim != 3 or observed.shape != lengths.shape[2:]:
        raise InputError(
            f"lengths {lengths.shape} and observed {observed.shape}: must be (models, repetitions, "
            "entries) and (entries,)"
        )
    models, repetitions, entries = lengths.shape
    if models < 2 or repetitions < 100:
        raise InputError(
            f"lengths: {models} models with {repetitions} repetitions, must be 2 and 100 or more"
        )
    even = repetitions - repetitions % 2
    halves = lengths[:, 0:even:2], lengths[:, 1:even:2]
    of_halves = []
    for half, other in (halves, halves[::-1]):
        tables = np.concatenate([observed[None], half.reshape(-1, entries)])
        of_halves.append(np.stack([log_densities(model, tables) for model in other]))
    both = np.stack(of_halves)
    drawn = both[:, :, 1:].reshape(2, models, models, even // 2, entries)
    return Comparison(both[:, :, 0], drawn)


def weights(comparison: Comparison, entries) -> np.ndarray:
    """Return the probability (models,) of each model after some entries of the table are seen.

    Parameters
    ----------
    comparison : Comparison
    entries : array of bool (entries,)
        Entries that are seen.
    """
    seen = _of_entries(comparison, entries)
    power = sharpness(seen.drawn)
    return scipy.special.softmax(power * seen.observed.mean(axis=0))


def sharpness(likelihoods: np.ndarray) -> float:
    """Return the power of the likelihood at which weights are calibrated.

    Parameters
    ----------
    likelihoods : array (2, models, sources, tables)
        Log-likelihoods of drawn tables, as in `Comparison`, summed over entries.
    """
    own = np.arange(likelihoods.shape[1])

    def loss(log_power: float) -> float:
        logs = scipy.special.log_softmax(np.exp(log_power) * likelihoods, axis=1)
        return -float(logs[:, own, own].mean())

    bounds = tuple(np.log(_SHARPNESS))
    return float(np.exp(scipy.optimize.minimize_scalar(loss, bounds=bounds, method="bounded").x))


def p_averaged(comparison: Comparison, entries, weight) -> float:
    """Return the share of repetitions of the average that are at least as unlikely as the table.

    The average draws each repetition from one of the models, chosen by their weights; the
    likelihood of a table under it is the mean of those under the models, by weight.

    Parameters
    ----------
    comparison : Comparison
    entries : array of bool (entries,)
        Entries that are tested.
    weight : array (models,)
        Weights of the models, which sum to 1.
    """
    tested = _of_entries(comparison, entries)
    scale = np.asarray(weight, dtype=float)
    drawn = scipy.special.logsumexp(tested.drawn, axis=1, b=scale[:, None, None])
    observed = scipy.special.logsumexp(tested.observed, axis=1, b=scale)
    return _share(drawn, observed[:, None, None], scale)


def p_selected(comparison: Comparison, entries, weight) -> float:
    """Return the p of `p_averaged`, each table being judged under its likeliest model.

    It includes the choice of a model by the table that is then tested.
    """
    tested = _of_entries(comparison, entries)
    return _share(tested.drawn.max(axis=1), tested.observed.max(axis=1)[:, None, None], weight)


def _share(drawn: np.ndarray, observed: np.ndarray, weight) -> float:
    """Average the shares of tables (2, sources, tables) that are no likelier than the observed."""
    as_unlikely = np.count_nonzero(drawn <= observed, axis=(0, 2))
    return float(np.dot(weight, (1 + as_unlikely) / (1 + 2 * drawn.shape[2])))


def _of_entries(comparison: Comparison, entries) -> Comparison:
    """Sum log densities over some entries."""
    return Comparison(*(logs[..., np.asarray(entries, bool)].sum(axis=-1) for logs in comparison))
