"""What long work shows of its progress."""

import pytest

from jointclosure.execution.progress import remaining


def test_no_remaining_time_is_shown_before_a_tenth_of_the_work_is_done():
    assert remaining(20.0, done=0.0, left=100.0) is None
    assert remaining(20.0, done=9.0, left=91.0) is None
    assert remaining(20.0, done=10.0, left=90.0) == pytest.approx(180.0)
    assert remaining(20.0, done=100.0, left=0.0) == 0.0
