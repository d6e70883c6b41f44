"""Hard cases: joints that are simulated, and checked by requirements that hold for any joint.

A case is an entry of ``hard_cases.yaml``, merged over that file's defaults. `run_case` simulates
its joint with a solver that passes states at rest to the oracle (`jointclosure.oracle`), and
`failed_requirements` lists the requirements that do not hold.
"""

import faulthandler
import json
import math
import operator
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure import oracle
from jointclosure.assessment.assess import closures_of
from jointclosure.assessment.hardness import FEATURES, features_of
from jointclosure.ensembles import oracle_limits
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.load import stated_load
from jointclosure.joint.simulation import equilibrium, height_datum, simulate_walls
from jointclosure.joint.status import FLAGS, OUTSIDE_MODEL_RANGE, TARGET_JUMPED, failed
from jointclosure.joint.warmup import kernels_of, prepare_kernels
from jointclosure.parameters import OF_ROCK, Choices, Effects, Numerics, Rock
from jointclosure.parameters.units import to_si
from jointclosure.solvers.registry import solver_named
from jointclosure.storage.provenance import commit, processor, versions_of
from jointclosure.uncertainty.variants import COPIES
from studies.frame.keys import validated
from studies.frame.yaml_files import merged
from studies.verification.hard_case_keys import HardCasesKeys, case_keys
from studies.verification.hard_walls import hard_walls
from studies.verification.judged_solver import Judge, JudgedSolver

_LENGTHS = ("displacement_step", "breakage_step")


class CaseOutcome(NamedTuple):
    """Outcome of a case.

    ``dataset`` is None if the case was refused with a ``message``. ``target`` is the maximum stress
    [Pa], ``warned`` are the Python warnings, and ``judge`` has the numbers of the oracle.
    """

    case: dict
    dataset: xr.Dataset | None
    target: float
    status: str
    message: str
    seconds: float
    warned: list[str]
    judge: Judge


def merged_cases(study: dict) -> dict[str, dict]:
    """Return cases by name, merged over the defaults, in SI; one for each way of breakage.

    Raises
    ------
    InputError
        If keys are wrong, a name is not unique, or a case is compared with one that does not exist.
    """
    validated(HardCasesKeys, study, "hard cases")
    cases = {}
    keys = case_keys(study["defaults"])
    for case in study["cases"]:
        alone = merged(study["defaults"], case)
        validated(keys, alone, f"hard cases: {case.get('name')}")
        for method in alone["breakage"]:
            whole = merged(alone, {"numerics": {"breakage": method}})
            name = case["name"] if method == "fixed_step" else f"{case['name']}_{method}"
            if name in cases:
                raise InputError(f"hard cases: only one must have the name {name!r}")
            cases[name] = to_si(whole) | {"name": name}
    for name, case in cases.items():
        compared = case["must"].get("same_as")
        if compared is None:
            continue
        alike = f"{compared['case']}_{case['numerics']['breakage']}"
        compared["case"] = alike if alike in cases else compared["case"]
        if compared["case"] not in cases:
            raise InputError(
                f"hard cases: {name} is compared with {compared['case']!r}, which does not exist"
            )
    return cases


def run_case(case: dict) -> CaseOutcome:
    """Simulate and judge a case's joint, and measure the time; the process caches the outcome."""
    return _run(json.dumps(case, sort_keys=True))


def failed_requirements(outcome: CaseOutcome, cases: dict[str, dict]) -> list[str]:
    """List the general requirements that a case breaks; if none, those of its ``must``.

    ``cases`` are all by name, as some are compared with others.
    """
    failed = broken_requirements(outcome, case_tolerances(outcome.case))
    if outcome.dataset is not None and not failed:
        for name, asked in outcome.case["must"].items():
            failed += _broken_must(outcome, name, asked, cases)
    return failed


def row_of(outcome: CaseOutcome, failed: list[str]) -> dict:
    """Return the row of the table for a case."""
    case = outcome.case
    data = outcome.dataset
    worst = outcome.judge.worst
    return {
        **{name: case[name] for name in ("name", "group", "hard", "must_hold")},
        "expected": case["expect"],
        "status": outcome.status,
        "holds": not failed,
        "failed": "; ".join(failed),
        **_measured(outcome),
        "steps": data.sizes.get("step", 1) if data is not None else 0,
        "states_judged": outcome.judge.states,
        **{f"oracle_{name}": worst.get(name, math.nan) for name in oracle.Verdict._fields},
        "warnings": "; ".join(outcome.warned),
        "message": outcome.message,
        "budget_s": case["seconds"],
        "seconds": round(outcome.seconds, 3),
        "within_budget": outcome.seconds <= case["seconds"],
    }


def features_of_case(case: dict) -> dict[str, float]:
    """Simulate copies of a case's joint (one if it is slow), and return its `FEATURES`."""
    if case["expect"] == "refused" or case["closure"] is not None:
        return dict.fromkeys(FEATURES, math.nan)
    setting = _setting(case)
    name = "as stated"
    upper, lower = setting.pop("walls")
    load = load_of(case, _target(case, upper, lower, setting))
    conditions = Conditions(seating_stress=0.0, unusual_values=True, **setting, **load).checked()
    copies = [(name, 0, copy) for copy in list(COPIES)[: 1 if case["slow"] else None]]
    return features_of(closures_of(copies, name, {name: conditions}, [(upper, lower)]), name, name)


def _measured(outcome: CaseOutcome) -> dict[str, float]:
    """Return closures [m] and stresses [Pa] of a case for its row; NaN without cycles."""
    data = outcome.dataset
    target = outcome.target
    none = dict.fromkeys(("max_closure_1_m", "max_closure_last_m"), math.nan)
    row = none | {"residual_closure_last_m": math.nan, "target_Pa": target}
    row["max_stress_Pa"] = math.nan if data is None else float(np.max(data.normal_stress.values))
    row |= {"unloading_excess_over_target": math.nan, "breakage_steps": 0}
    if data is None or "max_closure" not in data:
        return row
    return row | {
        "max_closure_1_m": float(data.max_closure[0]),
        "max_closure_last_m": float(data.max_closure[-1]),
        "residual_closure_last_m": float(data.residual_closure[-1]),
        "unloading_excess_over_target": float(data.unloading_excess.max()) / target,
        "breakage_steps": int(data.breakage_steps),
    }


def kernels_of_cases(cases: Iterable[dict]) -> list[list[str]]:
    """Return the kernels of the cases that are simulated, see `joint.warmup.kernels_of`."""
    answered = (case for case in cases if case["expect"] != "refused")
    return kernels_of(map(_model, answered))


def _model(case: dict) -> tuple[Effects, Choices, Numerics]:
    """Return effects, choices and numerics of a case, unchecked: the simulation checks them."""
    changed = Choices()._replace(**case["choices"]), Numerics()._replace(**case["numerics"])
    return Effects(**case["effects"]), *changed


@lru_cache(maxsize=None)
def _run(frozen: str) -> CaseOutcome:
    case = json.loads(frozen)
    if case["expect"] != "refused":  # kernels are compiled before the time is measured
        prepare_kernels([_model(case)])
    setting = _setting(case)
    upper, lower = setting.pop("walls")
    walls = (wall - height_datum(wall) for wall in (upper, lower))
    model = (setting[name] for name in ("spacing", "rock", "effects", "choices"))
    given = oracle.PristineJoint(*walls, *model)
    judge = Judge(given, case_tolerances(case))
    dataset = None
    message = ""
    target = math.nan
    start = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            if case["closure"] is not None:
                stated = setting | {"closure": case["closure"], "unusual_values": True}
                dataset = equilibrium(upper, lower, **stated)
            else:
                target = _target(case, upper, lower, setting)
                stated = setting | load_of(case, target)
                conditions = Conditions(seating_stress=0.0, unusual_values=True, **stated)
                dataset = simulate_walls(
                    upper, lower, conditions.checked(),
                    solver_of=lambda name: JudgedSolver(solver_named(name), judge),
                )  # fmt: skip
            bits = int(dataset.status)
            status = " ".join(name for bit, name in FLAGS.items() if bits & bit) or "success"
        except InputError as error:
            status = "refused"
            message = str(error)
    seconds = time.perf_counter() - start
    if case["closure"] is not None and dataset is not None and not failed(dataset):
        total = float(dataset.normal_stress) * upper.size * setting["spacing"] ** 2
        force = dataset.force.values
        judge(oracle.State(given.upper, given.lower, force, case["closure"], total))
    warned = [f"{w.category.__name__}: {w.message}" for w in caught]
    return CaseOutcome(case, dataset, target, status, message, seconds, warned, judge)


def _setting(case: dict) -> dict:
    """Return walls and arguments of `simulate` of a case, with its lengths and stresses scaled."""
    lengths = case["scale_lengths"]
    stresses = case["scale_stresses"]
    walls = case["walls"]
    spacing = case["spacing"]
    stated = (walls[name] for name in ("height", "jrc", "seed"))
    made = hard_walls(walls["kind"], walls["cells"], spacing, *stated)
    offsets = zip(made, walls["offset"], strict=True)
    pair = [walls["factor"] * lengths * wall + offset for wall, offset in offsets]

    def scaled(rock: dict) -> Rock:
        in_pascals = (name for name in rock if OF_ROCK[name].si_unit == "Pa")
        return Rock(**rock | {name: rock[name] * stresses for name in in_pascals})

    rocks = [scaled(rock) for rock in (case["rock"], case["lower_rock"] or case["rock"])]
    if case["swapped"]:
        pair = pair[::-1]
        rocks = rocks[::-1]
    effects, choices, numerics = _model(case)
    steps = {
        name: lengths * value
        for name, value in numerics._asdict().items()
        if name in case["numerics"] and name.endswith(_LENGTHS)
    }
    if choices.largest_radius is not None:
        choices = choices._replace(largest_radius=lengths * choices.largest_radius)
    setting = {"walls": pair, "spacing": spacing * lengths, "rock": (rocks[0], rocks[1])}
    return setting | {
        "effects": effects,
        "choices": choices,
        "numerics": numerics._replace(**steps),
    }


def _target(case: dict, upper, lower, setting: dict) -> float:
    """Return the maximum stress [Pa]: that of the case, or the elastic one of the first step."""
    if not case["target_is_first_step"]:
        return case["scale_stresses"] * max(case["history"] or [case["max_normal_stress"]])
    step = setting["numerics"].displacement_step
    elastic = equilibrium(upper, lower, closure=step, unusual_values=True, **setting)
    return float(elastic.normal_stress)


def load_of(case: dict, target: float) -> dict[str, Any]:
    """Return the load as keywords of `simulate`: ``target`` [Pa] and cycles, or the history."""
    if case["history"] is None:
        return {"max_normal_stress": target, "cycles": case["cycles"]}
    return {"max_normal_stress": [case["scale_stresses"] * turn for turn in case["history"]]}


def case_tolerances(case: dict) -> dict[str, float]:
    """Return the limits of the oracle's numbers, and of the relative distance to the target."""
    numerics = Numerics()._replace(**case["numerics"])
    by_stress = case["closure"] is None
    limits = oracle_limits.tolerances_of(Effects(**case["effects"]), numerics, by_stress)
    return limits | {"target": numerics.stress_tolerance}


LARGEST_UNBREAKABLE_SHARE = 0.1
"""Share of the force on cells that cannot break above which a remark is required; independent of
the protocol's constant."""


def broken_requirements(outcome, tolerances: dict[str, float]) -> list[str]:
    """List the general requirements (status, warnings, oracle, curve) that a case breaks."""
    case = outcome.case
    broken = [f"warned: {text}" for text in outcome.warned]
    answered = outcome.dataset is not None and not failed(outcome.dataset)
    if not (answered if case["expect"] == "answer" else outcome.status == case["expect"]):
        broken.append(f"status {outcome.status}, expected {case['expect']}")
    if outcome.status == "refused":
        if case["message"] not in outcome.message:
            broken.append(f"message of the refusal lacks {case['message']!r}")
        return broken
    broken += _beyond_limits(outcome)
    # a failed simulation has a status, but no closures
    if not failed(outcome.dataset):
        broken += _wrong_in_dataset(outcome, tolerances)
    elif "max_closure" in outcome.dataset and np.isfinite(outcome.dataset.max_closure[-1]):
        broken.append("a failed simulation has a last closure")
    return broken


def _beyond_limits(outcome) -> list[str]:
    """List the numbers of the oracle that exceed their limits."""
    worst = outcome.judge.worst
    limits = outcome.judge.limits
    if not worst:
        return [] if failed(outcome.dataset) else ["the oracle saw no state"]
    above = (name for name in limits if not worst[name] <= limits[name])
    return [f"{name} {worst[name]:.3g}, at most {limits[name]:.3g}" for name in above]


def _wrong_in_dataset(outcome, tolerances: dict[str, float]) -> list[str]:
    """List what is wrong in the dataset: numbers, stresses reached, remarks, closures."""
    data = outcome.dataset
    failed = []
    stepped = "step" in data.sizes
    cycles = stated_load(**load_of(outcome.case, outcome.target)).load_cycles if stepped else ()
    turns = np.array([0.0, *(load.minimum for load in cycles)])
    opened = np.maximum(turns[:-1], turns[1:]) == 0.0  # others have no closures since seating
    for name, variable in data.data_vars.items():
        values = variable.values[opened] if name.endswith("_seated") else variable.values
        if variable.dtype.kind == "f" and not np.isfinite(values).all():
            failed.append(f"{name} is not finite")
    if not cycles:
        return failed
    near = tolerances["target"]
    short = False
    for cycle, (target, minimum) in enumerate(cycles, start=1):
        stress = data.normal_stress.values[data.load_cycle.values == cycle]
        short |= bool(stress.max() < target * (1.0 - near))
        if stress.max() < target * (1.0 - outcome.case["may_fall_short"]):
            failed.append(f"cycle {cycle} ends at {stress.max():.6g} Pa of {target:.6g} Pa")
        if stress.max() > target * (1.0 + near):
            failed.append(f"cycle {cycle} ends at {stress.max():.6g} Pa, above {target:.6g} Pa")
        if abs(stress[-1] - minimum) > near * minimum:
            failed.append(f"cycle {cycle} unloads to {stress[-1]:.3g} Pa, not {minimum:.3g} Pa")
    share = float((data.locked_share + data.flat_share).max())
    if share > 1.0 + 1e-12:
        failed.append(f"a share {share:.3g} of its force is on unbreakable cells")
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
    if not outcome.case["effects"]["breakage"] and excess > near * outcome.target:
        failed.append(f"without breakage unloading exceeds loading by {excess:.3g} Pa")
    return failed


def _same_as(data: xr.Dataset, asked: dict, other: xr.Dataset, factor: float) -> float:
    """Return the largest relative difference from closures of another case times ``factor``."""
    size = np.abs(other.max_closure.values).max() * factor
    off = 0.0
    for name in ("max_closure", "residual_closure"):
        mine = data[name].values
        theirs = factor * other[name].values
        off = max(off, float(np.abs(mine[: theirs.size] - theirs[: mine.size]).max()) / size)
    return off


EXTRA: dict[str, tuple[Callable[..., Any], str]] = {
    "same_as": (_same_as, "a closure differs from {case} by {:.3g}"),
    "no_drift": (
        lambda data, asked: (
            np.ptp(data.residual_closure.values[asked["from_cycle"] - 1 :]) / data.max_closure[-1]
        ),
        "residual closure drifts by {:.3g}",
    ),
    "nothing_breaks": (lambda data, asked: data.breakage_steps, "{:g} breakage steps"),
    "contact_fraction": (
        lambda data, asked: data.contact_fraction.max(),
        "contact fraction {:.3g}",
    ),
    "no_force": (lambda data, asked: np.abs(data.force).sum(), "force {:.3g} N"),
    "closure": (
        lambda data, asked: abs(data.max_closure[0] / asked["value"] - 1.0),
        "closure is off by {:.3g}, expected {value} m",
    ),
    "forgets": (
        lambda data, asked: np.ptp(data.max_closure.values[1:]) / data.max_closure[1:].max(),
        "maximum closures from the second on spread by {:.3g}",
    ),
}
"""Requirements of single cases by their key under ``must``: a number, and the text if it is wrong.

The key states whether the number is 0 (true or false), at most ``within``, or from ``least`` to
``most``.
"""


def _broken_must(outcome: CaseOutcome, name: str, asked: Any, cases: dict[str, dict]) -> list[str]:
    """Return the text of a requirement under ``must`` that a case breaks, or an empty list."""
    number, words = EXTRA[name]
    compared: tuple = ()
    if name == "same_as":
        other = run_case(cases[asked["case"]])
        if other.dataset is None:
            return [f"{asked['case']} gave nothing to compare with"]
        lengths = (one.case["scale_lengths"] for one in (outcome, other))
        compared = other.dataset, operator.truediv(*lengths)
    value = float(number(outcome.dataset, asked, *compared))
    if isinstance(asked, bool):
        return [] if (value == 0.0) == asked else [words.format(value)]
    fits = asked.get("least", 0.0) <= value <= asked.get("most", asked.get("within"))
    return [] if fits else [words.format(value, **asked)]


ERRORS: dict[str, tuple[str, ...]] = {"forces": ("residual", "without_overlap", "without_force")}
ERRORS |= {name: (name,) for name in ("load", "volume", "strength")}
"""Relative errors of a case, each the largest of these fields of `oracle.Verdict`."""
GROWTH = 4.0
"""Allowed ratio of an error to the stored one."""
FLOOR = 64.0 * np.finfo(float).eps
"""Error up to which none counts as grown: that of rounding in sums."""


def error_table(cases: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """Tabulate the errors of the judged cases, with columns of their ``origin``."""
    judged = cases[cases.states_judged > 0]
    table = pd.DataFrame({"name": judged.name, "group": judged.group})
    for error, fields in ERRORS.items():
        largest = judged[[f"oracle_{field}" for field in fields]].max(axis=1)
        table[error] = [float(f"{value:.3g}") for value in largest]
    return table.assign(**origin)


def grown_errors(stored: Mapping, worst: Mapping[str, float]) -> list[str]:
    """List the errors that have grown beyond `GROWTH`, one line each.

    ``stored`` is a row of `error_table`, ``worst`` has the fields of `oracle.Verdict`.
    """
    grown = []
    for error, fields in ERRORS.items():
        for field in fields:
            if not worst[field] <= GROWTH * max(float(stored[error]), FLOOR):
                grown.append(
                    f"{field} is {worst[field]:.3g}, {stored[error]:.3g} is stored for {error} "
                    f"({stored['processor']}, {stored['versions']})"
                )
    return grown


PATIENCE = 10.0
"""Multiple of its expected time after which a case counts as endless, and ends the job."""


def close_hard_cases(
    cases: dict[str, dict], group: str, log: Callable[[str], None]
) -> pd.DataFrame:
    """Simulate and judge the hard cases of a group, and return a table of them."""
    rows = []
    for name, case in cases.items():
        if case["group"] != group:
            continue
        faulthandler.dump_traceback_later(PATIENCE * case["seconds"], exit=True, file=sys.stderr)
        outcome = run_case(case)
        failed = failed_requirements(outcome, cases)
        faulthandler.cancel_dump_traceback_later()
        rows.append(row_of(outcome, failed) | features_of_case(case))
        log(f"{name}: {outcome.status}, {outcome.seconds:.2f} s, {'; '.join(failed) or 'holds'}")
    return pd.DataFrame(rows)


def present_hard_cases(
    tables: list[pd.DataFrame], order: list[str]
) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Join the groups of hard cases in a table, in ``order``; return it, errors and features."""
    table = pd.concat(tables).set_index("name").loc[order].reset_index()
    versions = versions_of("numpy", "scipy", "numba").items()
    origin = {
        "processor": processor(),
        "versions": " ".join(f"{package} {version}" for package, version in versions),
        "commit": commit(),
    }
    features = table[["name", "hard", *FEATURES]].dropna(subset="contacts_at_max")
    return table, error_table(table, origin), features
