"""Log files of long work, and the time and memory that it took."""

import contextlib
import gc
import os
import resource
import shutil
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

SHOWN = "jointclosure: "  # prefix of lines on standard error that are for the user
FAILED = "failed: "  # prefix of the reason at the end of the log of a failure


class Logbook:
    """Function that writes a line to a log, with the time since the log was opened.

    Every line is flushed at once.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._start = time.monotonic()

    def __call__(self, line: str) -> None:
        print(f"{time.monotonic() - self._start:8.2f} s  {line}", file=self._stream, flush=True)

    def show(self, line: str) -> None:
        """Log a line, and also print it on standard error for the user."""
        self(line)
        print(f"{SHOWN}{line}", file=sys.__stderr__, flush=True)


@contextlib.contextmanager
def logging_to(
    log: str | Path, benchmark: str | Path = os.devnull, raised: bool = False
) -> Iterator[Logbook]:
    """Log the work inside to a file, with everything that it prints.

    Standard output and standard error are redirected to the ``log``, and a `Logbook` for it is
    passed to the work. Folders are made if needed. If the work succeeds, its time [s], the largest
    memory of the process [MB] and the processor time [s] are written to ``benchmark``. If it fails,
    the log gets the traceback and the reason, and is copied to a file whose name ends in
    ``.failed``. Unless errors are ``raised``, as in a script, what was imported before is excluded
    from garbage collection for the rest of the process.

    Raises
    ------
    SystemExit
        If the work fails, so that a script prints no traceback. With ``raised`` the error itself is
        raised instead.
    """
    for path in (log, benchmark):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    used = time.process_time()
    if not raised:  # garbage collection need not look at what a script imported, nor at its end
        gc.freeze()
    with (
        open(log, "w", encoding="utf-8", buffering=1) as stream,
        contextlib.redirect_stdout(stream),
        contextlib.redirect_stderr(stream),
    ):
        try:
            yield Logbook(stream)
        except BaseException as error:
            traceback.print_exception(error, file=stream)
            print(f"{FAILED}{type(error).__name__}: {error}", file=stream, flush=True)
            shutil.copyfile(log, f"{log}.failed")
            if raised:
                raise
            raise SystemExit(1) from None
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    memory = most / (1e6 if sys.platform == "darwin" else 1e3)
    row = f"{time.monotonic() - start:.2f}\t{memory:.2f}\t{time.process_time() - used:.2f}"
    Path(benchmark).write_text(f"s\tmax_rss\tcpu_time\n{row}\n", encoding="utf-8")


def reason_of_failure(log: str | Path) -> str:
    """Return in one line why work failed, by its log (`logging_to`).

    If the log is missing or states no reason, the work was ended from outside.
    """
    file = Path(log)
    if not file.exists():
        return "it ended before its log began"
    lines = file.read_text(encoding="utf-8", errors="replace").split("\n")
    starts = [place for place, line in enumerate(lines) if line.startswith(FAILED)]
    if not starts:
        return "it was ended from outside, by a signal or for lack of memory"
    return " ".join(" ".join(lines[starts[-1] :]).split()).removeprefix(FAILED)
