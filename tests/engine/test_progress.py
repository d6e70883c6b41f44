"""Progress: shown on a terminal, silent elsewhere."""

import io

import pytest
from rich.console import Console

from jointclosure.engine import progress
from jointclosure.engine.progress import Countdown, WorkflowProgress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by two seconds at each look."""
    seconds = iter(range(0, 1000, 2))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(seconds)))


def test_the_rest_is_estimated_from_what_is_done(clock):
    count = Countdown("one", 10, io.StringIO())
    assert count() == "1 of 10 done, about 18 s left"
    assert count() == "2 of 10 done, about 16 s left"


def test_a_terminal_gets_a_line_every_ten_seconds(clock):
    terminal = Terminal()
    count = Countdown("one", 12, terminal)
    for _ in range(12):
        count()
    assert terminal.getvalue().splitlines() == [
        "one: 6 of 12 done, about 12 s left",
        "one: 12 of 12 done, about 0 s left",
    ]


def console(terminal):
    return lambda stderr: Console(stderr=stderr, force_terminal=terminal)


LOG = """Job stats:
job               count
--------------  -------
make_surfaces         1
close_surfaces        4
all                   1
total                 6

Job 3: Generate the surface pairs
Finished jobid: 3 (Rule: make_surfaces)
1 of 6 steps (17%) done
"""


def test_what_is_left_of_a_workflow_is_estimated_by_kind_of_job():
    now = [0.0]
    run = WorkflowProgress(lambda: now[0])
    for line in LOG.splitlines(keepends=True):
        run.read(line)
        now[0] += 1.0
    assert run.text() == "1 of 6 jobs done"  # nothing is known yet of what takes long
    for job in (4, 5):
        run.read(f"Job {job}: Close\n")
    now[0] += 20.0
    for job in (4, 5):
        run.read(f"Finished jobid: {job} (Rule: close_surfaces)\n")
    run.read("3 of 6 steps (50%) done\n")
    # two more of 20 s each, side by side
    assert run.text() == "3 of 6 jobs done; left: 2 close_surfaces (about 20 s)"


def test_the_remaining_time_of_jobs_one_after_the_other_does_not_depend_on_the_moment():
    now = [0.0]
    run = WorkflowProgress(lambda: now[0])
    for line in LOG.splitlines(keepends=True):
        run.read(line)
    for job in (4, 5):
        run.read(f"Job {job}: Close\n")
        now[0] += 20.0
        run.read(f"Finished jobid: {job} (Rule: close_surfaces)\n")
        now[0] += 5.0
    run.read("Job 6: Close\n")
    for _ in range(3):
        assert "2 close_surfaces (about 40 s)" in run.text()
        now[0] += 4.0


def test_kinds_of_jobs_that_none_is_done_of_are_never_estimated_by_the_others():
    run = WorkflowProgress(clock=iter(range(100)).__next__)
    log = LOG.replace("make_surfaces         1", "make_surfaces         3")
    for line in log.splitlines(keepends=True):
        run.read(line)
    assert run.text().startswith("1 of 6 jobs done; left: 2 make_surfaces (about ")
    assert run.text().endswith("s), 4 jobs not yet timed")
