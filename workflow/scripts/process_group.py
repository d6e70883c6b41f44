"""Process groups that end within seconds after a request, and with the process that made them.

As a program it replaces a command: `python process_group.py COMMAND ARGUMENT ...`. It needs the
standard library only, as `make setup` runs it before there is an environment.
"""

import os
import select
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

GRACE = 15.0
"""Seconds between the interruption of a process group and its kill."""
SAME_REQUEST = 1.0
"""Seconds within which signals are one request: `timeout` and `make` both send theirs."""
GO_ON = "what is finished stays; the same command goes on from there"


class EndRequest:
    """Request to end this process; true from the first request on.

    Requests are the signals INT, TERM and HUP, and the interruption or death of the `make` that
    started this process: an INT that reaches make alone is not passed on by it.

    Attributes
    ----------
    signal : int
        Signal of the first request; 0 before it.
    repeated : bool
        Whether another request came later, so that no job is waited for.
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


class ForkedGroup:
    """Function in a forked process that leads a new process group, with the interface of `Popen`.

    What is left of the group is killed as soon as its leader or this process has ended, whatever
    ended it: programs that the group starts need not know of this.

    Parameters
    ----------
    function : callable
        Without arguments; it ends or replaces its process.
    """

    def __init__(self, function: Callable[[], object]):
        self.returncode: int | None = None
        sys.stdout.flush()
        ready, leads = os.pipe()
        alive, self._held = os.pipe()
        self.pid = os.fork()
        if not self.pid:
            try:
                os.setsid()
                os.close(leads)
                os.close(self._held)
                _guard(alive)
                function()
            except OSError as error:
                print(error, file=sys.stderr, flush=True)
            finally:
                os._exit(127)
        os.close(leads)
        os.close(alive)
        os.read(ready, 1)  # until the process leads its group, so that signals reach it
        os.close(ready)

    def poll(self) -> int | None:
        """Return the exit status; None before the end."""
        return self._wait(os.WNOHANG)

    def wait(self) -> int | None:
        """Wait for the end, and return the exit status."""
        return self._wait(0)

    def _wait(self, options: int) -> int | None:
        if self.returncode is None:
            process, status = os.waitpid(self.pid, options)
            self.returncode = os.waitstatus_to_exitcode(status) if process else None
        return self.returncode


def _guard(alive: int) -> None:
    """Fork the process that kills this group when its leader, or all that hold a pipe, ended."""
    leader = os.getpid()
    if os.fork():
        return
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    while os.getppid() == leader and not select.select([alive], [], [], 0.2)[0]:
        pass
    os.killpg(0, signal.SIGKILL)


def run_group(command: list[str], request: EndRequest) -> int:
    """Run a command to its end, or until this process is asked to end; its exit status."""
    if request:
        return 128 + request.signal
    process = ForkedGroup(lambda: _replace(command))
    while process.poll() is None:
        if request:
            end_group(process, request, signal.SIGTERM)
            return 128 + request.signal
        time.sleep(0.1)
    kill_group(process)
    return shell_status(process.returncode or 0)


def _replace(command: list[str]) -> None:
    """Become a command, without input and with its usual reactions to signals."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.execvp(command[0], command)


def end_group(process: ForkedGroup, request: EndRequest, number: int = signal.SIGINT) -> None:
    """Signal a process group once, and kill what is left of it after the grace period."""
    _send(process, number)
    deadline = time.monotonic() + GRACE
    while _send(process, 0) and time.monotonic() < deadline and not request.repeated:
        process.poll()  # a leader that is not waited for would stay in the group
        time.sleep(0.1)
    kill_group(process)


def kill_group(process: ForkedGroup) -> None:
    """Kill what is left of the group of a process, and wait for the process."""
    _send(process, signal.SIGKILL)
    process.wait()


def shell_status(returncode: int) -> int:
    """Return the exit status as a shell gives it: 128 plus the signal that ended a process."""
    return 128 - returncode if returncode < 0 else returncode


def _send(process: ForkedGroup, number: int) -> bool:
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
