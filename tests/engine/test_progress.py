"""Progress: shown on a terminal, silent elsewhere."""

import pytest

from jointclosure.engine import progress
from jointclosure.engine.progress import Countdown


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by two seconds at each look."""
    seconds = iter(range(0, 1000, 2))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(seconds)))


def test_the_rest_is_estimated_and_reported_a_tenth_at_a_time(clock):
    lines = []
    count = Countdown("joints", 40, lines.append)
    for _ in range(4):
        count()
    count(36)
    assert lines == ["joints: 4 of 40, about 1 min 12 s left", "joints: 40 of 40"]
