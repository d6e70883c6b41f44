"""Results that pages show: which files of each run they need, and where they lie.

A folder has the tables (CSV) and figures (PNG) of one run, and origin.json: commit,
version, root seed, date and configuration that made them. publish.py stores them.
"""

import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
STORED = ROOT
ORIGIN = "origin.json"


class StoredError(Exception):
    """A stored result that is not there, or results that cannot be stored."""


class Run(NamedTuple):
    """Files that are kept of a run: names without their suffixes."""

    tables: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()


RUNS = {
    "paper": Run(
        tables=(
            "table_1_rocks", "table_3_indifference", "table_3_joint_tests", "claims", "checks",
            "conclusions", "elasticities", "max_closure", "table_3_predictive",
        ),
        figures=("table_3_predictive",),
    ),
    "large_pool": Run(("table_3_joint_tests",)),
    "accuracy": Run(
        tables=("accuracy_cost", "accuracy_settings", "accuracy_sources"),
        figures=("accuracy_regularised",),
    ),
    "accuracy_biases": Run(
        ("accuracy_split", "accuracy_methods"), ("accuracy_total",)
    ),
    "effects": Run(figures=("effects",)),
    "effects_auto": Run(
        ("effects_regions", "effects_auto_summary"), ("effects_regions",)
    ),
    "conclusions": Run(("earlier_readings",)),
    "readings_average": Run(
        ("readings_average", "readings_average_tests", "readings_average_claims")
    ),
    "mismatch": Run(("mismatch", "mismatch_shifts"), ("mismatch",)),
    "misalignment": Run(("misalignment",), ("misalignment",)),
    "size": Run(
        ("size", "size_exponents", "size_collapse", "size_barton_bandis"), ("size",)
    ),
    "global_sensitivity": Run(
        tables=(
            "global_sensitivity_indices",
            "global_sensitivity_elasticities",
            "global_sensitivity_conclusions",
            "global_sensitivity_margins",
            "global_sensitivity_estimate",
        ),
        figures=(
            "global_sensitivity_indices",
            "global_sensitivity_conclusions",
            "global_sensitivity_convergence",
        ),
    ),
    "global_sensitivity_full": Run(("global_sensitivity_estimate",)),
    "continuum": Run(("continuum", "continuum_codes"), ("continuum",)),
    "measured_fit": Run(
        tuple(f"measured_fit{part}" for part in ("", "_known", "_example"))
    ),
    "measured_joints": Run(
        ("measured_joints", "measured_joints_predictions"), ("measured_joints",)
    ),
    "hard_cases": Run(("hard_case_errors", "analytic"), ("numerics",)),
    "flow": Run(("flow",)),
    "solver_speed": Run(("elastic", "reference")),
    "versions": Run(("versions",)),
    "peers": Run(("peers",)),
    "start_up": Run(("start_up",)),
    "growth": Run(("growth_beyond",), ("growth",)),
    "growth_once": Run(("growth_once",)),
    # finished inquiries, whose code has left (docs/decisions/0020-finished-inquiries.md)
    "along_curve": Run(figures=("along_curve_elasticities",)),
    "jrc_range": Run(("jrc_range", "jrc_range_claims")),
    "variance_reduction": Run(("variance_reduction",)),
}  # fmt: skip
"""Files that pages and the package need, by run; the only list of them."""


def folder_of(run: str) -> Path:
    """Folder of a stored run: of a study, or of a benchmark."""
    places = [*STORED.glob(f"studies/*/results/{run}"), STORED / "benchmarks/results" / run]
    return places[0]


def path_of(run: str, table: str) -> Path:
    """Where a table of a run is kept; `StoredError` where no page needs it."""
    kept = RUNS.get(run, Run())
    if table not in kept.tables:
        raise StoredError(f"{run}/{table}.csv is not in RUNS (docs/site/stored.py)")
    return folder_of(run) / f"{table}.csv"


def stored(run: str, table: str) -> pd.DataFrame:
    """Read a table of a run; `StoredError` where it is not stored."""
    path = path_of(run, table)
    if not path.is_file():
        raise StoredError(f"{path.relative_to(ROOT)} is not stored: make publish STUDY=...")
    return _read(path)


_read = cache(read_csv)


def origin(run: str) -> dict:
    """Read what made the stored results of a run."""
    path = folder_of(run) / ORIGIN
    if not path.is_file():
        raise StoredError(f"{path.relative_to(ROOT)} is not stored: make publish STUDY=...")
    return json.loads(path.read_text(encoding="utf-8"))
