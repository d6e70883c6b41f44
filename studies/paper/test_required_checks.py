"""A failed check of the results ends a run."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from tests.studied import ROOT

COLUMNS = ["ensemble", "check", "required", "found", "passed"]


PASSED = ("cases", "least force", "not negative", "0", True)


FAILED = ("pool", "volume", "at most 1e-12", "2e-9 of it", False)


def require_checks(table, note):
    """Run the script of the rule `require_checks`."""
    rule = SimpleNamespace(input=[str(table)], output=[str(note)], log=[f"{note}.log"])
    script = ROOT / "workflow/scripts/require_checks.py"
    runpy.run_path(str(script), {"snakemake": rule}, "__main__")


@pytest.fixture
def failed_check(tmp_path):
    """Table of checks of which one failed, the note on those that pass, and the log's end."""
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    pd.DataFrame([PASSED, FAILED], columns=COLUMNS).to_csv(table, index=False)
    with pytest.raises(SystemExit):
        require_checks(table, note)
    return table, note, Path(f"{note}.log").read_text().splitlines()[-1]


def test_a_failed_check_ends_the_run_naming_it(failed_check):
    table, _, last = failed_check
    assert last.startswith(f"failed: InputError: {table}: results fail their checks: ")
    assert last.endswith(" volume (pool): 2e-9 of it, required at most 1e-12")
    assert "least force" not in last


def test_a_failed_check_leaves_no_note(failed_check):
    assert not failed_check[1].exists()


def test_checks_that_pass_leave_a_note(tmp_path):
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    pd.DataFrame([PASSED, PASSED], columns=COLUMNS).to_csv(table, index=False)
    require_checks(table, note)
    assert note.read_text() == "2 checks that have a limit passed\n"
