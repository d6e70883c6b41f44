"""The run ends with an error where a check of the results has failed, and says which."""

import importlib.util
from pathlib import Path

import pandas as pd
import pytest

SCRIPT = Path(__file__).parents[2] / "workflow/scripts/require_checks.py"
PASSED = {"check": "least force", "required": "not negative", "found": "0", "passed": True}
FAILED = {"check": "volume", "required": "at most 1e-12", "found": "2e-9 of it", "passed": False}


@pytest.fixture
def require(tmp_path):
    """Require the checks of some rows; the note that is left, or None."""
    spec = importlib.util.spec_from_file_location("require_checks", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"

    def required(*rows):
        pd.DataFrame(rows).to_csv(table, index=False)
        script.main(str(table), str(note), lambda line: None)

    return required, note


def test_a_failed_check_ends_the_run_naming_it_and_leaves_no_note(require):
    required, note = require
    with pytest.raises(SystemExit) as ended:
        required(PASSED, FAILED)
    assert "volume: 2e-9 of it, required at most 1e-12" in str(ended.value)
    assert "least force" not in str(ended.value)
    assert not note.exists()


def test_checks_that_passed_leave_a_note(require):
    required, note = require
    required(PASSED, PASSED)
    assert note.read_text() == "2 checks passed\n"
