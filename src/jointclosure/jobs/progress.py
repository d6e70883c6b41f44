"""Progress of long work: a bar on a terminal, lines in a log; how far a workflow is."""

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

_BETWEEN_LINES = 10.0
"""Seconds between two lines on a terminal."""


@contextmanager
def bar(title: str) -> Iterator[Callable[[float, str], None]]:
    """A bar with the remaining time on standard error, gone when done; only on a terminal.

    Yields
    ------
    callable
        To be called with the part that is done, from 0 to 1, and a word on what is done now.
    """
    # jobs count without it, and are started by the hundred
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        task = progress.add_task(title, total=1.0)

        def show(done: float, what: str) -> None:
            progress.update(task, completed=done, description=f"{title}: {what}")

        yield show


class Countdown:
    """Counts equal parts of a job, and estimates from those done how long the rest takes.

    Each call counts one part and returns what to say. On a terminal it is
    written there too, every ten seconds at most: jobs that run side by side
    share it, so that there is a line each and no bar.

    Parameters
    ----------
    title : str
        Of the job.
    total : int
        Parts.
    terminal : text stream
        Where lines go if it is a terminal; that of the process by default, even
        where a logbook has taken its standard error.
    """

    def __init__(self, title: str, total: int, terminal: TextIO | None = None):
        self.title, self.total, self.done = title, total, 0
        self._start = self._said = time.monotonic()
        self._terminal = terminal or sys.__stderr__ or sys.stderr

    def __call__(self) -> str:
        self.done += 1
        now = time.monotonic()
        left = (now - self._start) / self.done * (self.total - self.done)
        text = f"{self.done} of {self.total} done, about {duration(left)} left"
        if self._terminal.isatty() and now - self._said > _BETWEEN_LINES:
            self._said = now
            print(f"{self.title}: {text}", file=self._terminal, flush=True)
        return text


def duration(seconds: float) -> str:
    """Seconds as people say them: "0.35 s", "8.2 s", "12 s", "2 min 5 s", "3 h 20 min"."""
    if seconds < 9.95:
        return f"{seconds:.2g} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


class WorkflowProgress:
    """How far a run of Snakemake is, from the lines of its log as they come.

    The remaining time is estimated by kind of job (rule): the jobs that are left by the mean time
    of those that are done, with as many at a time as there were on average. Kinds of which no job
    is done yet are counted and not estimated.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._jobs: dict[str, int] = {}
        self._started: dict[str, float] = {}
        self._took: dict[str, list[float]] = {}
        self._in_table = False
        self._first = 0.0
        self.done = self.total = 0

    def read(self, line: str) -> None:
        """Take in a line of the log."""
        if self._in_table or line.startswith("Job stats:"):
            self._read_table(line)
        elif found := _STARTED.match(line):
            if not self._started:
                self._first = self._clock()
            self._started.setdefault(found[1] or found[2], self._clock())
        elif found := _FINISHED.match(line):
            start = self._started.pop(found[1], self._clock())
            self._took.setdefault(found[2], []).append(self._clock() - start)
        elif found := _STEPS.match(line):
            self.done, self.total = int(found[1]), int(found[2])

    def _read_table(self, line: str) -> None:
        self._in_table = bool(line.strip())
        words = line.split()
        if len(words) == 2 and words[1].isdigit():
            if words[0] == "total":
                self.total = int(words[1])
            elif words[0] != "all":
                self._jobs[words[0]] = int(words[1])

    def text(self) -> str:
        """Jobs that are done, and by kind of job about how long the rest takes."""
        done = f"{self.done} of {self.total} jobs done"
        left = {name: n - len(self._took.get(name, [])) for name, n in self._jobs.items()}
        parts = [
            f"{n} {name} (about {duration(n * self._seconds_a_job(name))})"
            for name, n in left.items()
            if n > 0 and name in self._took
        ]
        untimed = sum(n for name, n in left.items() if name not in self._took)
        parts += [f"{untimed} of kinds not timed yet"] if parts and untimed else []
        return f"{done}; left: {', '.join(parts)}" if parts else done

    def _seconds_a_job(self, rule: str) -> float:
        """Mean time between the ends of a rule's jobs, when as many run at a time as until now."""
        elapsed = self._clock() - self._first
        spent = sum(map(sum, self._took.values()))
        took = self._took[rule]
        return sum(took) / len(took) / max(spent / elapsed if elapsed else 1.0, 1.0)


_STARTED = re.compile(r"(?:Job (\d+): |\s+jobid: (\d+)$)")
_FINISHED = re.compile(r"Finished jobid: (\d+) \(Rule: (\w+)\)")
_STEPS = re.compile(r"(\d+) of (\d+) steps")
