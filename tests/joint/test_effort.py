"""A slowdown is seen without a clock: what joints take is held against a stored budget."""

import pytest

from jointclosure.solvers import fast
from tests.effort import COUNTS, JOINTS, budget, counts

MARGIN = 1.05
"""Of a count: a sum in another order rounds otherwise, and a joint may take another course."""
FEW = 5


def exceeded(name: str) -> list[str]:
    found, stored = counts(name), budget().loc[name]
    return [
        f"{count}: {found[count]}, budget {stored[count]} (python -m tests.effort rewrites it)"
        for count in COUNTS
        if found[count] > MARGIN * stored[count] + FEW
    ]


def test_the_budget_has_all_joints_and_all_counts_are_counted():
    stored = budget()
    assert list(stored.index) == list(JOINTS)
    assert list(stored.columns) == list(COUNTS)
    assert (stored.max() > 100).all()
    assert (stored.drop(index="reference") > 0).sum().min() >= 5


@pytest.mark.parametrize("name", JOINTS)
def test_closing_a_joint_takes_no_more_than_its_budget(name):
    assert exceeded(name) == []


def test_what_makes_the_solver_slower_exceeds_the_budget(monkeypatch):
    """Without the extrapolation of the interaction, more breaks."""
    monkeypatch.setattr(fast, "_note_rates", lambda *_: None)
    assert any("breakage_steps" in line for line in exceeded("fixed_step_current_peaks"))
    monkeypatch.undo()
    monkeypatch.setattr(fast, "PROVISIONAL_TOLERANCES", ())  # always solved as exactly as asked
    assert any("solver_iterations" in line for line in exceeded("resolved"))
