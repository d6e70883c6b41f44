"""Progress of long work: a bar on a terminal, lines in a log, nothing elsewhere."""

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
    """Seconds as people say them: "8 s", "2 min 5 s", "3 h 20 min"."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
