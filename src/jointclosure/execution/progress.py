"""Progress of long work: a bar on a terminal, lines in a log, and the time that it took."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

_BETWEEN_LINES = 30.0  # time [s] between two lines of progress
_PART = 0.1  # share of the work between two lines of progress
_IMPORTED = time.perf_counter()
FIRST_LOADING = 5.0  # its time over that of a later cycle that is not replayed: 4 to 10 measured


@contextmanager
def bar(title: str) -> Iterator[Callable[[float, str], None]]:
    """Show a progress bar on a terminal, or print lines of progress now and then elsewhere.

    Yield a function that is to be called with the finished share of the work and the present step.
    """
    # jobs do without it, and hundreds of them are started
    from rich import console, progress

    screen = console.Console(stderr=True)
    columns = (*progress.Progress.get_default_columns(), progress.TimeElapsedColumn())
    off = not screen.is_terminal
    with progress.Progress(*columns, console=screen, transient=True, disable=off) as shown:
        task = shown.add_task(title, total=1.0)
        last = [time.monotonic()]

        def show(done: float, what: str) -> None:
            shown.update(task, completed=done, description=f"{title}: {what}")
            if off and time.monotonic() - last[0] > _BETWEEN_LINES:
                last[0] = time.monotonic()
                print(f"{title}: {100.0 * done:.0f} %, {what}", flush=True)

        yield show


@contextmanager
def load_cycle_bar(cycles: int) -> Iterator[Callable[[int, str, float], None]]:
    """Show the progress of simulating a joint by its load cycles, as a `bar`.

    Yield a function to be given as ``report`` to `jointclosure.simulate`.
    """
    with bar("simulating") as show:

        def report(cycle: int, branch: str, share: float) -> None:
            share = min(share, 1.0) if branch == "loading" else 1.0
            done = FIRST_LOADING * share if cycle == 1 else FIRST_LOADING + cycle - 2 + share
            show(done / (FIRST_LOADING + cycles - 1), f"cycle {cycle} of {cycles}, {branch}")

        yield report


def remaining(seconds: float, done: float, left: float) -> float | None:
    """Return the time [s] that the rest of some work will take, as the work before did.

    ``seconds`` is the time of the part ``done``; ``left`` is the rest, in the same unit of work.
    Return None before a tenth is done.
    """
    return seconds * left / done if 0.0 < _PART * (done + left) <= done else None


class Countdown:
    """Count of the finished parts of some work, which reports the remaining time now and then.

    It is called with a number of parts that are finished, by default one. ``report`` is then called
    with a line of text after a tenth of the ``total``, after `_BETWEEN_LINES`, and at the end.
    """

    def __init__(self, title: str, total: int, report: Callable[[str], None]):
        self.title = title
        self.total = total
        self.done = 0
        self._report = report
        self._part = 0.0
        self._start = self._shown = time.monotonic()

    def __call__(self, parts: int = 1) -> None:
        self.done += parts
        now = time.monotonic()
        part = self.done / self.total
        if part >= self._part + _PART or now - self._shown > _BETWEEN_LINES or part == 1.0:
            self._shown = now
            self._part = part
            left = (now - self._start) / self.done * (self.total - self.done)
            of = f"{self.title}: {self.done} of {self.total}"
            self._report(f"{of}, about {duration(left)} left" if left else of)


def seconds_of_process() -> float:
    """Return the wall time [s] since this process started, imports included.

    On systems without /proc it is the time since this module was imported.
    """
    try:
        fields = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        started = int(fields[19]) / os.sysconf("SC_CLK_TCK")
        return time.clock_gettime(time.CLOCK_BOOTTIME) - started
    except (OSError, AttributeError):
        return time.perf_counter() - _IMPORTED


def duration(seconds: float) -> str:
    """Format a time [s]: "0.35 s", "8.2 s", "12 s", "2 min 5 s", "3 h 20 min"."""
    if seconds < 9.95:
        return f"{seconds:.2g} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
