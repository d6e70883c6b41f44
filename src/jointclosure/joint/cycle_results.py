"""Results of each load cycle: closures, stiffness as laboratories report it, hysteresis."""

from typing import Any

import numpy as np
import scipy
import xarray as xr

from jointclosure.joint.history import Branch, History, history_of
from jointclosure.joint.status import LOADING

CHORD_START = 0.5
"""Stress at which the chord of the net stiffness starts, over the maximum of the cycle."""
_LOOP_ROUNDING = 1e-12  # difference of closures over the closure, up to which it is rounding


def unloading_excess(joint: xr.Dataset, minima: np.ndarray) -> np.ndarray:
    """Return the largest excess (cycles,) [Pa] of the stress of unloading over that of loading.

    Both are compared at equal gross closure; the excess is at least 0. ``joint`` is a Dataset of
    `simulate`. The excess is NaN where unloading did not end at or below the stress ``minima``
    (cycles,) [Pa]. Closures below the first of a loading that did not start from 0 are left out.
    """
    history = history_of(joint)
    excess = np.full(len(minima), np.nan)
    for index, cycle in history.unloaded_cycles(minima):
        excess[index] = _excess(history, cycle.loading, cycle.unloading)
    return excess


def _excess(history: History, loading: Branch, unloading: Branch) -> float:
    """Return the largest excess of stress [Pa] of an unloading over its loading at equal closure.

    It is at least 0. At closures below those of the loading, the stress of loading counts as 0 if
    the loading started from 0, and otherwise as infinite: these closures are left out.
    """
    closure = history.gross.values
    stress = history.stress
    # keep the last of several steps at one closure
    at, last = np.unique(closure[loading.steps][::-1], return_index=True)
    loaded = stress[loading.steps][::-1][last]
    after = closure[unloading.steps[1:]]
    unloaded = stress[unloading.steps[1:]]
    next_one = np.minimum(np.searchsorted(at, after), at.size - 1)
    if np.array_equal(at[next_one], after):
        below = loaded[next_one]  # both branches have the same steps: no interpolation
    else:
        below = np.minimum(loaded[next_one], loaded[np.maximum(next_one - 1, 0)])
        if at.size > 1 and np.any(unloaded >= below):
            # a monotone cubic lies between its neighbours, and is not needed above unloading
            cubic = scipy.interpolate.PchipInterpolator(at, loaded)
            below = cubic(np.clip(after, at[0], at[-1]))
    below[after < at[0]] = 0.0 if stress[loading.steps[0]] == 0.0 else np.inf
    return max(0.0, float(np.max(unloaded - below)))


def hysteresis(joint: xr.Dataset) -> np.ndarray:
    """Return the share (cycles,) [1] of the work of loading that unloading does not give back.

    Works are over the gross closure. The share is NaN for a cycle without unloading, and for one
    whose loading took no work.
    """
    history = history_of(joint)
    shares = np.full(joint.max_closure.size, np.nan)
    for index, cycle in history.unloaded_cycles(np.full(shares.size, np.inf)):
        given = _work(history, cycle.loading)
        back = -_work(history, cycle.unloading)
        shares[index] = 1.0 - back / given if given > 0.0 else np.nan
    return shares


def _work(history: History, branch: Branch) -> float:
    """Return the work per area [J/m2] on a branch: its stress integrated over the gross closure."""
    return np.trapezoid(history.stress[branch.steps], history.gross.values[branch.steps])


def largest_jump(joint: xr.Dataset) -> float:
    """Return the largest jump of a joint at constant stress, over the closure of its loading [1].

    A jump is the gross closure from a peak of the stress to where the loading exceeds this peak. A
    group of asperities breaks at once in it. A jump that lasts to the end of the loading counts as
    well. The largest jump of all cycles counts.
    """
    history = history_of(joint)
    shares = []
    for cycle in range(1, joint.max_closure.size + 1):
        loading = history.branch(cycle, LOADING).steps
        if not loading.size:
            continue
        closure = history.gross.values[loading]
        stress = np.append(history.stress[loading], np.inf)
        reached = np.maximum.accumulate(stress)
        before, beyond = (np.searchsorted(reached, reached[:-1], at) for at in ("left", "right"))
        low = stress[beyond - 1]
        high = stress[beyond]
        share = (reached[:-1] - low) / (high - low)
        end = closure[beyond - 1] + share * np.append(np.diff(closure), 0.0)[beyond - 1]
        closed = closure[-1] - closure[0]
        shares.append(float(np.max(end - closure[before])) / closed if closed > 0.0 else 0.0)
    return max(shares)


def loop_between(loading: Any, unloading: Any) -> Any:
    """Return closures of unloading less closures of loading at the same stresses.

    Differences within rounding are 0.
    """
    loop = unloading - loading
    return loop * (abs(loop) > _LOOP_ROUNDING * abs(loading))


def net_responses(joint: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the results of each cycle as laboratories report them: arrays (cycles,) by name.

    They are net closures [m], the net stiffness [Pa/m] and the stress [Pa] up to which steps have
    their full size (`History.landing_stresses`). The stiffness is that of the chord of a loading
    from half of its maximum, or from a higher former maximum, to its maximum. Results of a cycle
    that was not completed are NaN.
    """
    history = history_of(joint)
    closures = history.net.cycle_closures()
    responses = {
        f"{name}_net": closures[name]
        for name in ("max_closure", "max_closure_seated", "residual_closure_seated")
    }
    stiffness = []
    for cycle, maximum in zip(history.cycles, history.maxima, strict=True):
        start = max(CHORD_START * maximum, history.former_maxima[cycle.number - 1])
        stiffness.append(history.net.secant_stiffness(cycle.number, start, maximum))
    responses["stiffness_net"] = np.array(stiffness)
    responses["landing_stress"] = history.landing_stresses
    completed = np.isfinite(joint.max_closure.values)
    not_begun = (0, completed.size - history.begun)
    return {
        name: np.where(completed, np.pad(values, not_begun, constant_values=np.nan), np.nan)
        for name, values in responses.items()
    }
