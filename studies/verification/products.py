"""Joints that are hard to solve, judged by an oracle.

Their steps (docs/model.md) depend on no configuration, and no other step depends on them.
"""

import faulthandler
import sys
from collections.abc import Callable
from typing import Any

import pandas as pd

from jointclosure.compilation.sources import ROOTS
from jointclosure.engine.assess import FEATURES
from jointclosure.joint.warmup import compile_all
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import commit, processor, versions_of
from studies.frame.products import Step
from studies.frame.yaml_files import read_plain
from studies.verification.hard_cases import (
    error_table,
    failed_requirements,
    features_of_case,
    kernels_of_cases,
    merged_cases,
    row_of,
    run_case,
)

FOLDER = "results/hard_cases"
PATIENCE = 10.0
"""Multiple of its budget after which a case counts as endless: the job ends with a traceback."""


def close_hard_cases(
    cases: dict[str, dict], group: str, log: Callable[[str], None]
) -> pd.DataFrame:
    """Close and judge the hard cases of a group; return their rows."""
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
    tables: list[pd.DataFrame],
    order: list[str],
    log: Callable[[str], None],
) -> dict[str, Any]:
    """Join the groups of hard cases in one table, and tabulate their errors."""
    table = pd.concat(tables).set_index("name").loc[order].reset_index()
    versions = versions_of("numpy", "scipy", "numba").items()
    origin = {
        "processor": processor(),
        "versions": " ".join(f"{package} {version}" for package, version in versions),
        "commit": commit(),
    }
    features = table[["name", "hard", *FEATURES]].dropna(subset="contacts_at_max")
    log(f"{int(table.holds.sum())} of {len(table)} hold")
    return {
        "hard_cases.csv": table,
        "hard_case_errors.csv": error_table(table, origin),
        "hard_case_features.csv": lambda path: write_csv(features, path, figures=4),
    }


def steps() -> dict[str, Step]:
    """Return all steps by the names of their rules."""
    cases = merged_cases(read_plain(ROOTS["studies"] / "verification/hard_cases.yaml"))
    groups = sorted({case["group"] for case in cases.values()})
    kernels, tables = f"{FOLDER}/logs/kernels.txt", f"{FOLDER}/tables"
    closed = [f"{FOLDER}/cases/{group}.csv" for group in groups]
    compiled = {"kernels": kernels_of_cases(cases.values())}
    found = {
        "compile_hard_cases": Step(compile_all, [kernels], settings=compiled),
        "present_hard_cases": Step(
            present_hard_cases,
            [
                f"{tables}/hard_cases.csv",
                f"{tables}/hard_case_errors.csv",
                f"{tables}/hard_case_features.csv",
            ],
            {"tables": closed},
            {"order": list(cases)},
        ),
    }
    for group, file in zip(groups, closed, strict=True):
        settings = {"cases": cases, "group": group}
        step = Step(close_hard_cases, [file], {"after": kernels}, settings)
        found[f"close_hard_cases_{group}"] = step
    return found


TARGET = [f"{FOLDER}/tables/hard_cases.csv"]
"""File whose step makes all others."""
