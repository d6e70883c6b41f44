"""What long work shows of its progress."""

import sys
import time

import pytest

from jointclosure.execution.progress import remaining, seconds_of_process
from tests.processes import python


def test_no_remaining_time_is_shown_before_a_tenth_of_the_work_is_done():
    assert remaining(20.0, done=0.0, left=100.0) is None
    assert remaining(20.0, done=9.0, left=91.0) is None
    assert remaining(20.0, done=10.0, left=90.0) == pytest.approx(180.0)
    assert remaining(20.0, done=100.0, left=0.0) == 0.0


LATE = """
import time
time.sleep(0.5)
from jointclosure.execution.progress import seconds_of_process
assert seconds_of_process() > 0.5
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_the_time_of_a_process_has_what_came_before_the_first_import(tmp_path):
    python("-c", LATE, cwd=tmp_path)


def test_the_time_of_a_process_goes_on():
    before = seconds_of_process()
    time.sleep(0.05)
    assert seconds_of_process() - before >= 0.03
