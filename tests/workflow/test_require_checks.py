"""The run ends with an error where a check of the results has failed, and says which."""

import importlib.util
from pathlib import Path

import pandas as pd
import pytest

from jointclosure.config.plain import to_plain
from jointclosure.parameters import Numerics

SCRIPTS = Path(__file__).parents[2] / "workflow/scripts"
PASSED = {
    "ensemble": "cases",
    "check": "least force",
    "required": "not negative",
    "found": "0",
    "passed": True,
}
FAILED = {
    "ensemble": "pool",
    "check": "volume",
    "required": "at most 1e-12",
    "found": "2e-9 of it",
    "passed": False,
}


def loaded(name):
    """A script of the workflow as a module."""
    spec = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


@pytest.fixture
def require(tmp_path):
    """Require the checks of some rows; the note that is left, or None."""
    script = loaded("require_checks")
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"

    def required(*rows):
        pd.DataFrame(rows).to_csv(table, index=False)
        script.main(str(table), str(note), lambda line: None)

    return required, note


def test_a_failed_check_ends_the_run_naming_it_and_leaves_no_note(require):
    required, note = require
    with pytest.raises(SystemExit) as ended:
        required(PASSED, FAILED)
    assert "volume (pool): 2e-9 of it, required at most 1e-12" in str(ended.value)
    assert "least force" not in str(ended.value)
    assert not note.exists()


def test_checks_that_passed_leave_a_note(require):
    required, note = require
    required(PASSED, PASSED)
    assert note.read_text() == "2 checks passed\n"


def test_the_pool_is_checked_as_well_as_the_cases(monkeypatch, tmp_path):
    script = loaded("check_results")
    monkeypatch.setattr(script, "read_netcdf", lambda file, without: file)
    monkeypatch.setattr(
        script,
        "check_results",
        lambda data, numerics, number, name: pd.DataFrame(
            [PASSED | {"ensemble": name, "found": f"{number} in {data}"}]
        ),
    )
    settings = {"numerics": to_plain(Numerics()), "realizations": {"cases": 20, "pool": 48}}
    table = tmp_path / "checks.csv"
    script.main(["study.nc", "pool.nc"], settings, str(table), lambda line: None)
    rows = pd.read_csv(table)
    assert rows.ensemble.tolist() == ["cases", "pool"]
    assert rows.found.tolist() == ["20 in study.nc", "48 in pool.nc"]
