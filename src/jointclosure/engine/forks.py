"""Functions in forked processes, which share loaded modules, and processes that end with others."""

import atexit
import ctypes
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from typing import NoReturn

_PR_SET_PDEATHSIG = 1


def end_with_parent(parent: int) -> None:
    """Have this process killed when its parent ends, whatever ends it, or has ended already.

    Parameters
    ----------
    parent : int
        Process that made this one, by its number, which it knew before.
    """
    prctl = getattr(ctypes.CDLL(None), "prctl", None)  # of Linux only
    if prctl is None or prctl(_PR_SET_PDEATHSIG, signal.SIGKILL):
        threading.Thread(target=_kill_without, args=(parent,), daemon=True).start()
    elif os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def _kill_without(parent: int) -> None:
    """Kill this process once it has another parent."""
    while os.getppid() == parent:
        time.sleep(0.2)
    os.kill(os.getpid(), signal.SIGKILL)


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
