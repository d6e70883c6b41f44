"""Progress of long work: bar on a terminal, lines in a log, progress of a workflow."""

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
    """Show a bar with the remaining time on standard error, only on a terminal.

    Yields
    ------
    callable
        Called with the completed part, from 0 to 1, and a description of the present step.
    """
    # jobs do without it, and hundreds of them are started
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


@contextmanager
def closing_bar(cycles: int) -> Iterator[Callable[[int, str, float], None]]:
    """Show a bar for the load cycles of a joint, and yield what `jointclosure.simulate` reports to.

    The first loading takes about five times as long as a later cycle: 4 to 10 were measured on
    joints of the paper's size without roll-off whose later cycles were solved and not replayed; the
    first unloading takes a third of a cycle.
    """
    first = 5.0
    with bar("closing") as show:

        def report(cycle: int, branch: str, share: float) -> None:
            share = min(share, 1.0) if branch == "loading" else 1.0
            done = first * share if cycle == 1 else first + cycle - 2 + share
            show(done / (first + cycles - 1), f"cycle {cycle} of {cycles}, {branch}")

        yield report


class Countdown:
    """Count of the equal parts of a job, with an estimate of the remaining time.

    Each call counts one part and returns a line on the progress. A terminal also shows it, at most
    every ten seconds: parallel jobs share the terminal, so that lines replace a bar.

    Parameters
    ----------
    title : str
        Title of the job.
    total : int
        Number of parts.
    terminal : text stream
        Terminal for the lines; by default that of the process, even if a logbook receives
        its standard error.
    """

    def __init__(self, title: str, total: int, terminal: TextIO | None = None):
        self.title, self.total, self.done = title, total, 0
        self._start = self._shown = time.monotonic()
        self._terminal = terminal or sys.__stderr__ or sys.stderr

    def __call__(self) -> str:
        self.done += 1
        now = time.monotonic()
        left = (now - self._start) / self.done * (self.total - self.done)
        text = f"{self.done} of {self.total} done, about {duration(left)} left"
        if self._terminal.isatty() and now - self._shown > _BETWEEN_LINES:
            self._shown = now
            print(f"{self.title}: {text}", file=self._terminal, flush=True)
        return text


def duration(seconds: float) -> str:
    """Format seconds: "0.35 s", "8.2 s", "12 s", "2 min 5 s", "3 h 20 min"."""
    if seconds < 9.95:
        return f"{seconds:.2g} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


class WorkflowProgress:
    """Progress of a run of Snakemake, from the lines of its log.

    The remaining time is estimated for each rule, from the mean time of its finished jobs and the
    average number of parallel jobs. Jobs of rules without a finished job are only counted.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._jobs: dict[str, int] = {}
        self._started: dict[str, float] = {}
        self._took: dict[str, list[float]] = {}
        self._in_table = False
        self._busy_before = self._busy_since = 0.0
        self.done = self.total = 0

    def read(self, line: str) -> None:
        """Read a line of the log."""
        if self._in_table or line.startswith("Job stats:"):
            self._read_table(line)
        elif match := _STARTED.match(line):
            if not self._started:
                self._busy_since = self._clock()
            self._started.setdefault(match[1] or match[2], self._clock())
        elif match := _FINISHED.match(line):
            now = self._clock()
            self._took.setdefault(match[2], []).append(now - self._started.pop(match[1], now))
            if not self._started:
                self._busy_before += now - self._busy_since
        elif match := _STEPS.match(line):
            self.done, self.total = int(match[1]), int(match[2])

    def finished(self, *rules: str) -> bool:
        """Return whether all jobs of some rules have finished in this run."""
        return all(0 < self._jobs.get(rule, 0) <= len(self._took.get(rule, [])) for rule in rules)

    def awaited(self, rule: str) -> bool:
        """Return whether jobs of a rule are left."""
        return len(self._took.get(rule, [])) < self._jobs.get(rule, 0)

    def _read_table(self, line: str) -> None:
        self._in_table = bool(line.strip())
        words = line.split()
        if len(words) == 2 and words[1].isdigit():
            if words[0] == "total":
                self.total = int(words[1])
            elif words[0] != "all":
                self._jobs[words[0]] = int(words[1])

    def text(self) -> str:
        """Describe the finished jobs, and the remaining time by rule."""
        done = f"{self.done} of {self.total} jobs done"
        left = {name: n - len(self._took.get(name, [])) for name, n in self._jobs.items()}
        parts = [
            f"{n} {name} (about {duration(n * self._seconds_a_job(name))})"
            for name, n in left.items()
            if n > 0 and name in self._took
        ]
        untimed = sum(n for name, n in left.items() if name not in self._took)
        parts += [f"{untimed} jobs not yet timed"] if parts and untimed else []
        return f"{done}; left: {', '.join(parts)}" if parts else done

    def _seconds_a_job(self, rule: str) -> float:
        """Return the mean time between ends of a rule's jobs, in parallel as so far."""
        now = self._clock()
        busy = self._busy_before + (now - self._busy_since if self._started else 0.0)
        spent = sum(map(sum, self._took.values())) + sum(now - s for s in self._started.values())
        took = self._took[rule]
        return sum(took) / len(took) / max(spent / busy if busy else 1.0, 1.0)


_STARTED = re.compile(r"(?:Job (\d+): |\s+jobid: (\d+)$)")
_FINISHED = re.compile(r"Finished jobid: (\d+) \(Rule: (\w+)\)")
_STEPS = re.compile(r"(\d+) of (\d+) steps")
