"""A study in which all inputs vary, of seconds: rows that are added."""

import pytest

from studies.frame.config.files import read_plain
from studies.frame.experiments import cached
from tests.studied import checked_study
from tests.workflow.test_pipeline import ROOT

KEYS = read_plain(ROOT / "tests/workflow/tiny_global_sensitivity.yaml")


@pytest.mark.slow
def test_rows_that_are_added_close_no_others():
    few, many = (
        {name: entry.key for name, entry in cached(checked_study(keys), SECTION).items()}
        for keys in (KEYS, KEYS | {SECTION: KEYS[SECTION] | {"rows": 32}})
    )
    assert len(many) - len(few) == 4  # two new blocks of each rock
    assert few.items() <= many.items()


SECTION = "global_sensitivity"
