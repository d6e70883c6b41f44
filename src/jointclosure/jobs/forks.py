"""Functions and programs in forked processes, which share the modules that are loaded."""

import atexit
import os
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import NoReturn, TextIO


class ForkedGroup:
    """Function in a forked process and a new process group, with the interface of `Popen`.

    Parameters
    ----------
    function : callable
        Without arguments; its `SystemExit` gives the exit status.
    output : file
        Its standard output and errors.
    """

    def __init__(self, function: Callable[[], object], output: TextIO):
        self.returncode: int | None = None
        sys.stdout.flush()
        leads, waits = os.pipe()
        with open(os.devnull, encoding="utf-8") as empty:
            self.pid = os.fork()
            if not self.pid:
                os.setsid()
                os.close(waits)
                run_forked(function, [empty.fileno(), output.fileno(), output.fileno()])
        os.close(waits)
        os.read(leads, 1)  # until the process leads its group, so that signals reach it
        os.close(leads)

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


def run_forked(function: Callable[[], object], streams: Sequence[int]) -> NoReturn:
    """Run a function in this forked process as a program of its own, and end the process.

    Parameters
    ----------
    function : callable
        Without arguments.
    streams : sequence of int
        Open files that become its standard input, output and errors.
    """
    status = 1
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
            signal.signal(number, signal.SIG_DFL)
        for place, stream in enumerate(streams):
            os.dup2(stream, place)
        function()
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        atexit._run_exitfuncs()  # `sys.exit` would end the callers' frames, which are the parent's
        sys.stdout.flush()
        os._exit(status)
