"""The list of mutants fits the library as it is."""

import shlex
from pathlib import Path

import pytest

from tests.mutants import LEAST, LEAST_LIMITS, ROOT, mutants


def test_each_mutant_changes_one_line_that_is_there():
    listed = mutants()
    assert len(listed) >= LEAST
    assert len(set(listed)) == len(listed)
    assert sum(mutant.kind == "limit" for mutant in listed) >= LEAST_LIMITS


def test_mutants_of_limits_are_in_all_rooms_that_compute():
    rooms = {Path(m.file).parts[-2] for m in mutants() if m.kind == "limit"}
    computing = {
        "assessment",
        "ensembles",
        "joint",
        "measured",
        "parameters",
        "solvers",
        "statistics",
        "uncertainty",
        "walls",
    }
    studies = {path.parent.name for path in (ROOT / "studies").glob("*/study.py")}
    assert computing | studies <= rooms | {"verification"}


@pytest.mark.slow
@pytest.mark.parametrize("tests", sorted({mutant.tests for mutant in mutants()}))
def test_the_tests_of_a_mutant_are_there(tests, capsys):
    """A file or a word that was renamed selects none, and no test would notice the mutant."""
    words = ["--collect-only", "-q", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:xdist"]
    assert pytest.main([*words, *shlex.split(tests)]) == 0, capsys.readouterr().out
