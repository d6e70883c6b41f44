"""Commands in process groups of their own, which end within seconds after a request.

As a program it replaces a command: `python process_group.py COMMAND ARGUMENT ...`. It needs the
standard library only, as `make setup` runs it before there is an environment.
"""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

GRACE = 15.0
"""Seconds between the interruption of a process group and its kill."""
SAME_REQUEST = 1.0
"""Seconds within which signals are one request: `timeout` and `make` both send theirs."""
GO_ON = "what is finished stays; the same command goes on from there"
_PR_SET_PDEATHSIG = 1


class EndRequest:
    """Request to end this process, by INT, TERM or HUP; true from the first on, later ``repeated``.

    The interruption or death of the `make` that started this process is a request too: an INT that
    reaches make alone is not passed on by it.
    """

    def __init__(self) -> None:
        self.signal, self.repeated = 0, False
        self._time = 0.0
        self._parent = os.getppid()
        self._make = _make_above(self._parent) if "MAKELEVEL" in os.environ else 0
        self._make_catches_interrupts = bool(self._make) and _catches_interrupts(self._make)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._receive)

    def __bool__(self) -> bool:
        if self._make and not self.signal:
            interrupted = self._make_catches_interrupts and not _catches_interrupts(self._make)
            if interrupted or os.getppid() != self._parent:
                self._receive(signal.SIGINT)
        return bool(self.signal)

    def __str__(self) -> str:
        return f"ended by {signal.Signals(self.signal).name}: {GO_ON}"

    def _receive(self, number: int, _frame: object = None) -> None:
        if not self.signal:
            self.signal, self._time = number, time.monotonic()
        elif time.monotonic() - self._time > SAME_REQUEST:
            self.repeated = True


def _make_above(process: int) -> int:
    """Return the nearest `make` above a process, over wrappers of Python; else the process."""
    above = process
    while above > 1:
        try:
            name, _, rest = Path(f"/proc/{above}/stat").read_text(encoding="utf-8").rpartition(")")
        except OSError:
            break
        if name.endswith("(make"):
            return above
        above = int(rest.split()[1])
    return process


def _catches_interrupts(process: int) -> bool:
    """Return whether a process handles INT; make drops its handler once interrupted (Linux)."""
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    except OSError:
        return False
    caught = [line.split()[1] for line in status.splitlines() if line.startswith("SigCgt:")]
    return bool(caught) and bool(int(caught[0], 16) >> (signal.SIGINT - 1) & 1)


@contextlib.contextmanager
def group(command: list[str], output: TextIO | None = None) -> Iterator[subprocess.Popen]:
    """Start a command without input as the leader of a process group, and kill what is left of it.

    Where Linux allows it the command is killed when this process is, whatever kills that.
    """
    prctl = getattr(ctypes.CDLL(None), "prctl", lambda *_: None)
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=output,
        start_new_session=True,
        close_fds=False,  # the lock of the folder is inherited
        preexec_fn=lambda: prctl(_PR_SET_PDEATHSIG, signal.SIGKILL),
    )
    try:
        yield process
    finally:
        _send(process, signal.SIGKILL)
        process.wait()


def end_group(process: subprocess.Popen, request: EndRequest, number: int = signal.SIGINT) -> None:
    """Signal a process group once, and wait for its end, for the grace period at most."""
    _send(process, number)
    deadline = time.monotonic() + GRACE
    while _send(process, 0) and time.monotonic() < deadline and not request.repeated:
        process.poll()  # a leader that is not waited for would stay in the group
        time.sleep(0.1)


def run_group(command: list[str], request: EndRequest) -> int:
    """Run a command to its end, or until this process is asked to end; its exit status."""
    if request:
        return 128 + request.signal
    with group(command) as process:
        while process.poll() is None:
            if request:
                end_group(process, request, signal.SIGTERM)
                return 128 + request.signal
            time.sleep(0.1)
    return shell_status(process.returncode)


def shell_status(returncode: int) -> int:
    """Return the exit status as a shell gives it: 128 plus the signal that ended a process."""
    return 128 - returncode if returncode < 0 else returncode


def _send(process: subprocess.Popen, number: int) -> bool:
    """Send a signal to the group of a process; False where none of the group is left."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        return False
    return True


if __name__ == "__main__":
    asked = EndRequest()
    result = run_group(sys.argv[1:], asked)
    if asked:
        print(asked, file=sys.stderr)
    sys.exit(result)
