"""Lock of a run: two runs in one folder are refused, whatever ended the former one."""

import atexit
import fcntl
import json
import os
import resource
import shutil
import socket
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TextIO

from jointclosure.inputs import InputError

LOCK = Path(".snakemake/jointclosure.lock")
HELD = "JOINTCLOSURE_LOCK"
"""Variable of the environment with the number of the locked file, for programs that inherit it."""
_BOOT = Path("/proc/sys/kernel/random/boot_id")
_ENDING = 2.0
"""Seconds within which the processes of a killed run have ended."""
_OPEN_FILES = 128
"""Open files that a run may have at once; on two cores it has less than 40."""
_held: list[TextIO] = []


def enter_folder() -> None:
    """Lock the present folder for a run; `InputError` if another may be at work, or none can be.

    The lock is held by this process and programs that inherit it, until the last of them ends.
    """
    folder = os.getcwd()
    if found := sorted(set("{}\\") & set(folder)):  # Snakemake or netCDF replaces these
        raise InputError(
            f"{folder}: a run needs a folder without {' and '.join(found)} in its name"
        )
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if 0 <= most < _OPEN_FILES:
        raise InputError(f"ulimit -n = {most}: must be at least {_OPEN_FILES} for a run")
    with suppress(KeyError, ValueError, OSError):  # else the process that started this has no lock
        if os.path.samestat(os.fstat(int(os.environ[HELD])), os.stat(LOCK)):
            return
    if _held:
        return
    LOCK.parent.mkdir(exist_ok=True)
    with ExitStack() as opened:
        file = opened.enter_context(open(LOCK, "a+", encoding="utf-8"))
        _lock(file)
        opened.pop_all()  # it is open until this process ends
    _held.append(file)
    os.set_inheritable(file.fileno(), True)
    os.environ[HELD] = str(file.fileno())
    atexit.register(_unlock, file, os.getpid())
    shutil.rmtree(".snakemake/locks", ignore_errors=True)  # of a Snakemake that was killed


def _lock(file: TextIO) -> None:
    """Lock a file, waiting for a killed run to end, and write this process into it.

    The kernel holds the lock, so that it ends with the process, whatever ends this. On network file
    systems it may not know of other hosts: what one of them has not removed is an error.
    """
    deadline, locked = time.monotonic() + _ENDING, False
    while not locked:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            locked = True
        except BlockingIOError:
            if time.monotonic() > deadline:
                named = _holder(file)[1]
                raise InputError(f"another run is at work in this folder ({named})") from None
            time.sleep(0.1)
        except OSError:  # a file system without locks
            break
    (left, named), here = _holder(file), _this_process()
    elsewhere = left.get("host") != here["host"] and left.get("boot") != here["boot"]
    if left and (elsewhere or not locked):
        raise InputError(
            f"another run may be at work in this folder ({named}): delete {LOCK} if it has ended"
        )
    try:
        _write(file, json.dumps(here))
    except OSError as error:
        raise InputError(f"{LOCK}: could not be written ({error})") from error


def _unlock(file: TextIO, owner: int) -> None:
    """Remove the name of the process that ends, but not when one of its forks does."""
    if os.getpid() == owner and not file.closed:
        _write(file, "")
        file.close()


def _write(file: TextIO, text: str) -> None:
    file.truncate(0)
    file.write(text)
    file.flush()


def _holder(file: TextIO) -> tuple[dict[str, str], str]:
    """Return the process that a file of a lock names, empty for none, and words for it."""
    file.seek(0)
    left = {}
    with suppress(ValueError, TypeError):
        left = dict(json.loads(file.read()))
    known = {"process": "?", "host": "?", "start": "?"} | left
    return left, "process {process} on {host}, since {start}".format(**known)


def _this_process() -> dict[str, str]:
    host = socket.gethostname()
    boot = _BOOT.read_text(encoding="utf-8").strip() if _BOOT.exists() else host
    start = time.strftime("%Y-%m-%d %H:%M:%S")
    return {"process": str(os.getpid()), "host": host, "boot": boot, "start": start}
