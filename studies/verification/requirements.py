"""Requirements of every hard case, and of single ones."""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

from jointclosure.joint.protocol import FAILURE, OUTSIDE_MODEL_RANGE, TARGET_JUMPED

LARGEST_UNBREAKABLE_SHARE = 0.1
"""Share of the force on cells that cannot break above which a remark is required; independent of
the protocol's constant."""


def broken_requirements(outcome, tolerances: dict[str, float]) -> list[str]:
    """List the requirements that do not hold for a case, one line each."""
    case = outcome.case
    failed = [f"warned: {text}" for text in outcome.warned]
    answered = outcome.dataset is not None and int(outcome.dataset.status) < FAILURE
    if not (answered if case["expect"] == "answer" else outcome.status == case["expect"]):
        failed.append(f"status {outcome.status}, expected {case['expect']}")
    if outcome.status == "refused":
        if case["message"] not in outcome.message:
            failed.append(f"message of the refusal lacks {case['message']!r}")
        return failed
    failed += _judged(outcome)
    # the status is the result of a failure: it has no closures
    if int(outcome.dataset.status) < FAILURE:
        failed += _curve(outcome, tolerances)
    elif "max_closure" in outcome.dataset and np.isfinite(outcome.dataset.max_closure[-1]):
        failed.append("a failed simulation has a last closure")
    return failed


def _judged(outcome) -> list[str]:
    """Check the oracle's numbers."""
    worst, limits = outcome.judge.worst, outcome.judge.limits
    if not worst:
        return [] if int(outcome.dataset.status) >= FAILURE else ["the oracle saw no state"]
    above = (name for name in limits if not worst[name] <= limits[name])
    return [f"{name} {worst[name]:.3g}, at most {limits[name]:.3g}" for name in above]


def _curve(outcome, tolerances: dict[str, float]) -> list[str]:
    """Check the dataset itself: finite, on target, unloaded to 0."""
    data, failed = outcome.dataset, []
    for name, variable in data.data_vars.items():
        if variable.dtype.kind == "f" and not np.isfinite(variable.values).all():
            failed.append(f"{name} is not finite")
    if "step" not in data.sizes:
        return failed
    target, near, short = outcome.target, tolerances["target"], False
    for cycle in range(1, data.sizes["cycle"] + 1):
        stress = data.normal_stress.values[data.load_cycle.values == cycle]
        short |= bool(stress.max() < target * (1.0 - near))
        if stress.max() < target * (1.0 - outcome.case["may_fall_short"]):
            failed.append(f"cycle {cycle} ends at {stress.max():.6g} Pa of {target:.6g} Pa")
        if stress.max() > target * (1.0 + near):
            failed.append(f"cycle {cycle} ends at {stress.max():.6g} Pa, above {target:.6g} Pa")
        if stress[-1] != 0.0:
            failed.append(f"cycle {cycle} unloads to {stress[-1]:.3g} Pa only")
    share = float((data.locked_share + data.flat_share).max())
    out = outcome.case["effects"]["breakage"] and share > LARGEST_UNBREAKABLE_SHARE
    for bit, name, true in (
        (TARGET_JUMPED, "below its target", short),
        (OUTSIDE_MODEL_RANGE, f"share {share:.3g} of its force on unbreakable cells", out),
    ):
        if bool(int(data.status) & bit) != true:
            failed.append(f"{'lacks' if true else 'has'} a remark: {name}")
    if not np.all(data.max_closure > 0.0):
        failed.append("a maximum closure is not positive")
    excess = float(data.unloading_excess.max())
    if not outcome.case["effects"]["breakage"] and excess > near * target:
        failed.append(f"without breakage unloading exceeds loading by {excess:.3g} Pa")
    return failed


def _same_as(outcome, asked: dict, other) -> list[str]:
    """Check that closures are those of another case, times a factor if lengths are scaled."""
    failed = []
    if other.dataset is None:
        return [f"{other.case['name']} gave nothing to compare with"]
    factor = outcome.case["scale_lengths"] / other.case["scale_lengths"]
    for name in ("max_closure", "residual_closure"):
        mine, theirs = (x.dataset[name].values for x in (outcome, other))
        theirs = theirs * factor
        size = np.abs(other.dataset.max_closure.values).max() * factor
        off = float(np.abs(mine[: theirs.size] - theirs[: mine.size]).max()) / size
        if not off <= asked["within"]:
            failed.append(f"{name} differs from {asked['case']} by {off:.3g}")
    return failed


def _no_drift(outcome, asked: dict, other) -> list[str]:
    """Check that residual closure does not drift over the cycles after a given one."""
    residual = outcome.dataset.residual_closure.values[asked["from_cycle"] - 1 :]
    closure = float(outcome.dataset.max_closure.values[-1])
    drift = float(np.ptp(residual)) / closure
    return [] if drift <= asked["within"] else [f"residual closure drifts by {drift:.3g}"]


def _nothing_breaks(outcome, asked: bool, other) -> list[str]:
    steps = int(outcome.dataset.breakage_steps)
    return [] if (steps == 0) == asked else [f"{steps} breakage steps"]


def _contact_fraction(outcome, asked: dict, other) -> list[str]:
    """Check that the largest fraction of cells in contact lies in a range."""
    fraction = float(outcome.dataset.contact_fraction.values.max())
    fits = asked["least"] <= fraction <= asked["most"]
    return [] if fits else [f"contact fraction {fraction:.3g}"]


def _closure(outcome, asked: dict, other) -> list[str]:
    """Check that the first cycle's closure is the known one [m]."""
    closure = float(outcome.dataset.max_closure.values[0])
    off = abs(closure / asked["value"] - 1.0)
    return [] if off <= asked["within"] else [f"closure {closure:.8g} m, expected {asked['value']}"]


def _no_force(outcome, asked: bool, other) -> list[str]:
    force = float(np.abs(outcome.dataset.force.values).sum())
    return [] if (force == 0.0) == asked else [f"force {force:.3g} N"]


def _forgets(outcome, asked: dict, other) -> list[str]:
    """Check that the maximum closure of every cycle from the second on is that of the second."""
    closures = outcome.dataset.max_closure.values[1:]
    spread = float(np.ptp(closures) / closures.max())
    return [] if spread <= asked["within"] else [f"maximum closures spread by {spread:.3g}"]


EXTRA: dict[str, Callable[..., list[str]]] = {
    "same_as": _same_as,
    "no_drift": _no_drift,
    "nothing_breaks": _nothing_breaks,
    "contact_fraction": _contact_fraction,
    "no_force": _no_force,
    "closure": _closure,
    "forgets": _forgets,
}
"""Requirements of single cases, by their key under ``must``."""


ERRORS: dict[str, tuple[str, ...]] = {"forces": ("residual", "without_overlap", "without_force")}
ERRORS |= {name: (name,) for name in ("load", "volume", "strength")}
"""Errors of a case, all relative: the largest of these fields of `oracle.Verdict`."""
GROWTH = 4.0
"""Allowed ratio of an error to the stored one."""
FLOOR = 64.0 * np.finfo(float).eps
"""Error below which nothing is judged: rounding of sums."""


def error_table(cases: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """Tabulate the errors of the judged cases, with what gave them."""
    judged = cases[cases.states_judged > 0]
    table = pd.DataFrame({"name": judged.name, "group": judged.group})
    for error, fields in ERRORS.items():
        largest = judged[[f"oracle_{field}" for field in fields]].max(axis=1)
        table[error] = [float(f"{value:.3g}") for value in largest]
    return table.assign(**origin)


def grown_errors(stored: Mapping, worst: Mapping[str, float]) -> list[str]:
    """List the errors that have grown beyond `GROWTH`, one line each."""
    grown = []
    for error, fields in ERRORS.items():
        for field in fields:
            if not worst[field] <= GROWTH * max(float(stored[error]), FLOOR):
                grown.append(
                    f"{field} is {worst[field]:.3g}, {stored[error]:.3g} is stored for {error} "
                    f"({stored['processor']}, {stored['versions']})"
                )
    return grown
