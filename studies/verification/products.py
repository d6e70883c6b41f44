"""Joints that are hard to solve, judged by an oracle, and tests of the paper's formulas and sweep.

Their steps (docs/model.md) depend on no configuration, and no other step depends on them.
"""

import faulthandler
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.compilation.sources import ROOTS
from jointclosure.engine.assess import FEATURES
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import commit, processor, versions_of
from studies.frame.files import read_plain
from studies.frame.jobs import compile_all
from studies.frame.products import Step, figure_files
from studies.verification import printed, sweeps
from studies.verification.analytic import analytic_table
from studies.verification.hard_cases import (
    curve_of,
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
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Close and judge the hard cases of a group; return their rows, and their closure curves."""
    rows, curves = [], []
    for name, case in cases.items():
        if case["group"] != group:
            continue
        faulthandler.dump_traceback_later(PATIENCE * case["seconds"], exit=True, file=sys.stderr)
        outcome = run_case(case)
        failed = failed_requirements(outcome, cases)
        faulthandler.cancel_dump_traceback_later()
        rows.append(row_of(outcome, failed) | features_of_case(case))
        curves.append(curve_of(outcome))
        log(f"{name}: {outcome.status}, {outcome.seconds:.2f} s, {'; '.join(failed) or 'holds'}")
    return pd.DataFrame(rows), pd.concat(curves)


def measure_numerics() -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Measure the errors of the paper's formulas and sweep, of ours, and of elastic joints."""
    half_ranges = np.logspace(-9, -0.5, 52)
    parts = [
        printed.cubic_errors(np.logspace(-12, 12, 97)),
        printed.far_field_errors(np.logspace(0, 9, 109)),
        *(printed.quartic_errors(half_ranges, base) for base in (78e9, 1e-9)),
        sweeps.convergence_histories(),
    ]
    return pd.concat(parts), sweeps.load_table(), analytic_table()


def present_hard_cases(
    tables: list[pd.DataFrame],
    curves: list[pd.DataFrame],
    formulas: pd.DataFrame,
    loads: pd.DataFrame,
    order: list[str],
    log: Callable[[str], None],
) -> dict[str, Any]:
    """Join the groups of hard cases in one table with their errors; draw cases and errors."""
    from studies.verification.figures import hard_case_page, numerics_figure

    table = pd.concat(tables).set_index("name").loc[order].reset_index()
    rows = pd.DataFrame(printed.formula_rows(formulas, loads))
    whole = pd.concat([table, rows], ignore_index=True)
    versions = versions_of("numpy", "scipy", "numba").items()
    origin = {
        "processor": processor(),
        "versions": " ".join(f"{package} {version}" for package, version in versions),
        "commit": commit(),
    }
    features = table[["name", "hard", *FEATURES]].dropna(subset="contacts_at_max")
    log(f"{int(whole.holds.sum())} of {len(whole)} hold")
    return {
        "hard_cases.csv": whole,
        "hard_case_errors.csv": error_table(table, origin),
        "hard_case_features.csv": lambda path: write_csv(features, path, figures=4),
        "hard_cases": hard_case_page(table, pd.concat(curves)),
        "numerics": numerics_figure(formulas),
    }


def steps() -> dict[str, Step]:
    """Return all steps by the names of their rules."""
    cases = merged_cases(read_plain(ROOTS["studies"] / "verification/hard_cases.yaml"))
    groups = sorted({case["group"] for case in cases.values()})
    kernels, tables = f"{FOLDER}/logs/kernels.txt", f"{FOLDER}/tables"
    numerics = [f"{tables}/{name}.csv" for name in ("numerics", "sweep_loads", "analytic")]
    closed = [f"{FOLDER}/cases/{group}.csv" for group in groups]
    curves = [f"{FOLDER}/cases/{group}.curves.csv" for group in groups]
    compiled = {"kernels": kernels_of_cases(cases.values())}
    found = {
        "compile_hard_cases": Step(compile_all, [kernels], settings=compiled),
        "measure_numerics": Step(measure_numerics, numerics, {"after": kernels}),
        "present_hard_cases": Step(
            present_hard_cases,
            [
                f"{tables}/hard_cases.csv",
                f"{tables}/hard_case_errors.csv",
                f"{tables}/hard_case_features.csv",
                *figure_files(("hard_cases", "numerics"), f"{FOLDER}/figures"),
            ],
            {"tables": closed, "curves": curves, "formulas": numerics[0], "loads": numerics[1]},
            {"order": list(cases)},
        ),
    }
    for group, *files in zip(groups, closed, curves, strict=True):
        settings = {"cases": cases, "group": group}
        step = Step(close_hard_cases, files, {"after": kernels}, settings)
        found[f"close_hard_cases_{group}"] = step
    return found


TARGET = [f"{FOLDER}/tables/analytic.csv", f"{FOLDER}/tables/hard_cases.csv"]
"""Files whose steps make all others."""
