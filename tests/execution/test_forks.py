"""No process outlives the one that it works for, whatever ends that."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.processes import processes_in, python

FORK = """
import ctypes, os, time
from jointclosure.execution.workers import end_with_parent
{before}
parent = os.getpid()
if os.fork():
    time.sleep({parent})
else:
    time.sleep({child})
    end_with_parent(parent)
    time.sleep(600)
"""
NO_PRCTL = "ctypes.CDLL = lambda name: None  # as on other systems than Linux"
POOL = """
import time
from jointclosure.execution.workers import in_processes
list(in_processes(time.sleep, [(600,), (600,)], workers=2))
"""


def wait_for_processes(folder: Path, least: int, most: float = 60.0) -> None:
    """Wait for a number of processes in a folder, or for none."""
    deadline = time.monotonic() + most
    while (found := len(processes_in(folder))) < least or found > 0 == least:
        assert time.monotonic() < deadline, [p.cmdline() for p in processes_in(folder)]
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("program", "processes"),
    [
        (FORK.format(before="", parent=600, child=0), 2),
        (FORK.format(before=NO_PRCTL, parent=600, child=0), 2),
        (POOL, 3),
    ],
    ids=["fork", "fork without prctl", "pool of processes"],
)
def test_children_end_with_a_parent_that_is_killed(tmp_path, program, processes):
    run = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path)
    wait_for_processes(tmp_path, processes)
    time.sleep(0.2)  # a fork is there before it asks to end with its parent
    run.send_signal(signal.SIGKILL)
    run.wait()
    wait_for_processes(tmp_path, 0, most=5.0)


@pytest.mark.parametrize("before", ["", NO_PRCTL])
def test_a_child_ends_whose_parent_has_ended_before(tmp_path, before):
    program = FORK.format(before=before, parent=0.1, child=0.5)
    python("-c", program, cwd=tmp_path)
    wait_for_processes(tmp_path, 0, most=5.0)
