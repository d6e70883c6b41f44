"""Hard cases: joints that are closed, and checked by requirements that hold for any joint.

A case is an entry of ``hard_cases.yaml``, merged with that file's defaults. `run_case`
closes its joint with a solver that passes every state at rest to the oracle
(`jointclosure.engine.oracle`), and lists every requirement that does not hold.
"""

import copy
import json
import math
import time
import warnings
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine import judging, oracle
from jointclosure.engine.assess import COPIES, FEATURES, closures_of, features_of
from jointclosure.engine.judging import Judge, JudgedSolver
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.joint.simulation import equilibrium, height_datum, simulate_by
from jointclosure.joint.warmup import compile_kernels, kernels_of
from jointclosure.parameters import OF_ROCK, Choices, Effects, Numerics, Rock, rock_of
from jointclosure.parameters.units import to_si
from jointclosure.solvers.registry import solver_named
from studies.frame.schema import problems
from studies.verification.hard_case_keys import HardCasesKeys, case_keys, hard_walls
from studies.verification.requirements import EXTRA, broken_requirements

_LENGTHS = ("displacement_step", "breakage_step")


class Outcome(NamedTuple):
    """Outcome of a case: the dataset (None if refused), and measurements."""

    case: dict
    dataset: xr.Dataset | None
    target: float
    status: str
    message: str
    seconds: float
    warned: list[str]
    judge: Judge


def merged_cases(study: dict) -> dict[str, dict]:
    """Return cases by name, merged over the defaults, in SI; one for each way of breakage."""
    _refuse(problems(HardCasesKeys, study))
    cases, keys = {}, case_keys(study["defaults"])
    for case in study["cases"]:
        alone = _over_defaults(case, study["defaults"])
        _refuse(f"{case.get('name')}: {line}" for line in problems(keys, alone))
        for method in case.get("breakage", study["defaults"]["breakage"]):
            whole = _over_defaults(case, study["defaults"])
            whole["numerics"]["breakage"] = method
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


def _over_defaults(case: dict, defaults: dict) -> dict:
    whole = copy.deepcopy(defaults | case)
    for part in ("walls", "rock", "effects", "choices", "numerics"):
        if isinstance(whole.get(part), dict) and isinstance(defaults.get(part), dict):
            whole[part] = defaults[part] | whole[part]
    return whole


def _refuse(lines: Iterable[str]) -> None:
    problems = list(lines)
    if problems:
        raise InputError("hard cases:\n" + "\n".join(f"  {line}" for line in problems))


def run_case(case: dict) -> Outcome:
    """Close and judge a case's joint and measure the time; the result is kept for the process."""
    return _run(json.dumps(case, sort_keys=True))


def failed_requirements(outcome: Outcome, cases: dict[str, dict]) -> list[str]:
    """List the requirements that do not hold for a case, one line each."""
    failed = broken_requirements(outcome, tolerances_of(outcome.case))
    if outcome.dataset is not None and not failed:
        for name, asked in outcome.case["must"].items():
            other = run_case(cases[asked["case"]]) if name == "same_as" else None
            failed += EXTRA[name](outcome, asked, other)
    return failed


def row_of(outcome: Outcome, failed: list[str]) -> dict:
    """Return the row of the table for a case."""
    case, data, worst = outcome.case, outcome.dataset, outcome.judge.worst
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
    """Close copies of a case's joint, one if they take long, and return its `FEATURES`."""
    if case["expect"] == "refused" or case["closure"] is not None:
        return dict.fromkeys(FEATURES, math.nan)
    setting, name = _setting(case), "as stated"
    upper, lower = setting.pop("walls")
    load = {"max_normal_stress": _target(case, upper, lower, setting), "cycles": case["cycles"]}
    conditions = Conditions(seating_stress=0.0, unusual_values=True, **setting, **load).checked()
    copies = [(name, 0, copy) for copy in list(COPIES)[: 1 if case["slow"] else None]]
    return features_of(closures_of(copies, name, {name: conditions}, [(upper, lower)]), name, name)


def _measured(outcome: Outcome) -> dict[str, float]:
    """Return the closures of a case for its row; NaN without cycles."""
    data, target = outcome.dataset, outcome.target
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


def curve_of(outcome: Outcome) -> pd.DataFrame:
    """Return the closure curve of a case: case, cycle, branch, closure_m, normal_stress_Pa."""
    data = outcome.dataset
    columns = ["case", "cycle", "branch", "closure_m", "normal_stress_Pa"]
    if data is None or "step" not in data.sizes:
        return pd.DataFrame(columns=columns)
    curve = (data[name].values for name in ("load_cycle", "branch", "closure", "normal_stress"))
    return pd.DataFrame(dict(zip(columns, (outcome.case["name"], *curve), strict=True)))


def kernels_of_cases(cases: Iterable[dict]) -> list[list[str]]:
    """Return the kernels of the cases that are closed, see `joint.warmup.kernels_of`."""
    answered = (case for case in cases if case["expect"] != "refused")
    return kernels_of(map(_model, answered))


def _model(case: dict) -> tuple[Effects, Choices, Numerics]:
    """Return effects, choices and numerics, which the simulation refuses if out of range."""
    changed = Choices()._replace(**case["choices"]), Numerics()._replace(**case["numerics"])
    return Effects(**case["effects"]), *changed


_compile_once = lru_cache(maxsize=None)(compile_kernels)


@lru_cache(maxsize=None)
def _run(frozen: str) -> Outcome:
    case = json.loads(frozen)
    if case["expect"] != "refused":  # kernels are compiled before the time is measured
        effects, choices, numerics = _model(case)
        compiled = Choices(peaks=choices.peaks, strength_bound=choices.strength_bound)
        _compile_once(effects, compiled, numerics.solver, numerics.breakage)
    setting = _setting(case)
    upper, lower = setting.pop("walls")
    walls = (wall - height_datum(wall) for wall in (upper, lower))
    model = (setting[name] for name in ("spacing", "rock", "effects", "choices"))
    given = oracle.Joint(*walls, *model)
    judge = Judge(given, tolerances_of(case))
    dataset, message, target = None, "", math.nan
    start = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            if case["closure"] is not None:
                stated = setting | {"closure": case["closure"], "unusual_values": True}
                dataset = equilibrium(upper, lower, **stated)
            else:
                target = _target(case, upper, lower, setting)
                stated = setting | {"max_normal_stress": target, "cycles": case["cycles"]}
                conditions = Conditions(seating_stress=0.0, unusual_values=True, **stated)
                dataset = simulate_by(
                    lambda name: JudgedSolver(solver_named(name), judge), upper, lower, conditions
                )
            bits = int(dataset.status)
            status = " ".join(name for bit, name in FLAGS.items() if bits & bit) or "success"
        except InputError as error:
            status, message = "refused", str(error)
    seconds = time.perf_counter() - start
    if case["closure"] is not None and dataset is not None and int(dataset.status) < FAILURE:
        total = float(dataset.normal_stress) * upper.size * setting["spacing"] ** 2
        force = dataset.force.values
        judge(oracle.State(given.upper, given.lower, force, case["closure"], total))
    warned = [f"{w.category.__name__}: {w.message}" for w in caught]
    return Outcome(case, dataset, target, status, message, seconds, warned, judge)


def _setting(case: dict) -> dict:
    """Return walls and arguments of `simulate` of a case, with lengths and stresses scaled."""
    lengths, stresses = case["scale_lengths"], case["scale_stresses"]
    walls, spacing = case["walls"], case["spacing"]
    stated = (walls[name] for name in ("height", "jrc", "seed"))
    made = hard_walls(walls["kind"], walls["cells"], spacing, *stated)
    offsets = zip(made, walls["offset"], strict=True)
    pair = [walls["factor"] * lengths * wall + offset for wall, offset in offsets]

    def scaled(rock: dict) -> Rock:
        in_pascals = (name for name in rock if OF_ROCK[name].si_unit == "Pa")
        return rock_of(rock | {name: rock[name] * stresses for name in in_pascals})

    rocks = [scaled(rock) for rock in (case["rock"], case["lower_rock"] or case["rock"])]
    if case["swapped"]:
        pair, rocks = pair[::-1], rocks[::-1]
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
    """Return the maximum stress [Pa], which may be that at the end of the first step."""
    if not case["target_is_first_step"]:
        return case["max_normal_stress"] * case["scale_stresses"]
    step = setting["numerics"].displacement_step
    elastic = equilibrium(upper, lower, closure=step, unusual_values=True, **setting)
    return float(elastic.normal_stress)


def tolerances_of(case: dict) -> dict[str, float]:
    """Return the limits of the oracle's numbers, and of the distance to the target, by name."""
    numerics = Numerics()._replace(**case["numerics"])
    by_stress = case["closure"] is None
    limits = judging.tolerances_of(Effects(**case["effects"]), numerics, by_stress)
    return limits | {"target": numerics.stress_tolerance}
