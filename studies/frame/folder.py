"""Folder of runs: what a run needs of it, and its lock."""

import atexit
import fcntl
import json
import os
import resource
import shutil
import socket
import time
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
_UNUSABLE = "{}\\"
"""Characters in the name of a folder that Snakemake or netCDF replaces."""
_held: list[TextIO] = []


def enter_folder() -> None:
    """Lock the present folder for a run, if it and the limit of open files allow one.

    The lock is held by this process and programs that inherit it, until the last of them ends.
    `InputError` if another run is at work in the folder, or may be.
    """
    folder = os.getcwd()
    if found := sorted(set(_UNUSABLE) & set(folder)):
        raise InputError(
            f"{folder}: a run needs a folder without {' and '.join(found)} in its name"
        )
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if 0 <= most < _OPEN_FILES:
        raise InputError(f"ulimit -n = {most}: must be at least {_OPEN_FILES} for a run")
    if _held or _inherited():
        return
    LOCK.parent.mkdir(exist_ok=True)
    file = open(LOCK, "a+", encoding="utf-8")  # noqa: SIM115 - open until this process ends
    try:
        _lock(file)
    except BaseException:
        file.close()
        raise
    _held.append(file)
    os.set_inheritable(file.fileno(), True)
    os.environ[HELD] = str(file.fileno())
    atexit.register(_unlock, file, os.getpid())
    shutil.rmtree(".snakemake/locks", ignore_errors=True)  # of a Snakemake that was killed


def _inherited() -> bool:
    """Return whether the process that started this one passed its lock of the folder on."""
    try:
        return os.path.samestat(os.fstat(int(os.environ[HELD])), os.stat(LOCK))
    except (KeyError, ValueError, OSError):
        return False


def _lock(file: TextIO) -> None:
    """Lock a file, waiting for a killed run to end, and write this process into it.

    The kernel holds the lock, so that it ends with the process, whatever ends this. On network file
    systems it may not know of other hosts: what one of them has not removed is an error.
    """
    deadline = time.monotonic() + _ENDING
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            locked = True
        except BlockingIOError:
            if time.monotonic() < deadline:
                time.sleep(0.1)
                continue
            raise InputError(f"another run is at work in this folder ({_named(file)})") from None
        except OSError:  # a file system without locks
            locked = False
        break
    left, here = _content(file), _this_process()
    elsewhere = left.get("host") != here["host"] and left.get("boot") != here["boot"]
    if left and (elsewhere or not locked):
        raise InputError(
            f"another run may be at work in this folder ({_named(file)}): "
            f"delete {LOCK} if it has ended"
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


def _content(file: TextIO) -> dict[str, str]:
    """Return the process that a file of a lock names; empty if it names none."""
    file.seek(0)
    try:
        return dict(json.loads(file.read()))
    except (ValueError, TypeError):
        return {}


def _named(file: TextIO) -> str:
    named = {"process": "?", "host": "?", "start": "?"} | _content(file)
    return "process {process} on {host}, since {start}".format(**named)


def _this_process() -> dict[str, str]:
    host = socket.gethostname()
    boot = _BOOT.read_text(encoding="utf-8").strip() if _BOOT.exists() else host
    start = time.strftime("%Y-%m-%d %H:%M:%S")
    return {"process": str(os.getpid()), "host": host, "boot": boot, "start": start}
