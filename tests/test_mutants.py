"""The list of mutants fits the library as it is."""

from pathlib import Path

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
