"""Logs of the workflow's scripts."""

import contextlib
import shutil
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO


class Logbook:
    """Log of lines with the time since its start, flushed one by one."""

    def __init__(self, stream: TextIO):
        self._stream, self._start = stream, time.monotonic()

    def __call__(self, line: str) -> None:
        print(f"{time.monotonic() - self._start:8.2f} s  {line}", file=self._stream, flush=True)


@contextlib.contextmanager
def logging_to(path: str | Path) -> Iterator[Logbook]:
    """Open a logbook in a file, which also receives standard output and errors.

    After a failure it is copied to `failed_log`, as a repeated job overwrites the file.
    """
    with (
        open(path, "w", encoding="utf-8", buffering=1) as stream,
        contextlib.redirect_stdout(stream),
        contextlib.redirect_stderr(stream),
    ):
        try:
            yield Logbook(stream)
        except BaseException as error:
            traceback.print_exception(error, file=stream)
            print(f"failed: {type(error).__name__}: {error}", file=stream, flush=True)
            shutil.copyfile(path, failed_log(path))
            print(f"{path}: {error}", file=sys.__stderr__, flush=True)
            raise


def failed_log(path: str | Path) -> Path:
    """Return the path of the log of a failed job."""
    return Path(f"{path}.failed")
