"""The list of mutants fits the library as it is."""

from tests.mutants import LEAST, mutants


def test_each_mutant_changes_one_line_that_is_there():
    assert len(mutants()) >= LEAST
