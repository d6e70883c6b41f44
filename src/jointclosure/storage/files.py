"""Files that are written completely or not at all; sealed files end with a digest."""

import errno
import glob
import hashlib
import os
import shutil
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import get_ident

import pandas as pd

from jointclosure.inputs import InputError

_SEAL = b"\nsha256 of all before this line: "  # before the digest at the end of a sealed file
END_DIGEST = 64  # length in bytes of the digest at the end of a sealed file
_READ_BYTES = 1_000_000  # at a time; a memory-mapped file would count as memory of the process
_NOT_OF_SPACE = (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EROFS, errno.ENAMETOOLONG)
"""Errors that a full disk cannot cause. A denied permission is not among them: netCDF reports a
full disk as one."""


MAKE_AGAIN = "delete it and start again; missing files are made again"
"""Advice on a file that is damaged, or of another study."""


class DamagedFileError(OSError):
    """Error for a file that is not as it was written."""


def atomically(path: str | Path, write: Callable[[Path], object]) -> None:
    """Write a file completely or not at all.

    ``write`` is called with a temporary path in the same folder, which is then renamed to ``path``.
    Temporary files for this path that killed processes left on this computer are removed first.
    Raise `OSError` if this fails, with the free space on the disk if it may be full.
    """
    path = Path(path)
    written_here = f".{path.stem}.{socket.gethostname()}-"
    temporary = path.with_name(f"{written_here}{os.getpid()}-{get_ident()}{path.suffix}")
    try:
        _remove_litter(path, written_here)
        temporary.touch()  # for an error that names what is wrong with the folder
        write(temporary)
        _flush_to_disk(temporary)
        os.replace(temporary, path)
        _flush_to_disk(path.parent)
    except DamagedFileError:  # from a file that was read by ``write``
        raise
    except OSError as error:
        raise _writing_error(path, error) from error
    finally:
        with suppress(OSError):  # there is no such folder
            temporary.unlink(missing_ok=True)


def _remove_litter(path: Path, written_here: str) -> None:
    """Remove temporary files for a path whose writers were killed on this computer."""
    for litter in path.parent.glob(f"{glob.escape(written_here)}*-*{path.suffix}"):
        pid = litter.name.removeprefix(written_here).split("-")[0]
        if pid.isdecimal():
            import psutil  # only needed if there are such files

            if not psutil.pid_exists(int(pid)):
                litter.unlink(missing_ok=True)


def _flush_to_disk(path: Path) -> None:
    """Wait until a file or folder is on the disk, not only in memory."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _writing_error(path: Path, error: OSError) -> OSError:
    """Return the error to raise for a file that could not be written.

    Its message has the free space on the disk if a lack of it may be the reason.
    """
    message = f"{path}: could not be written ({error})"
    if error.errno in _NOT_OF_SPACE:
        return OSError(message)
    free = shutil.disk_usage(path.parent).free if path.parent.is_dir() else 0
    return OSError(f"{message}; {free / 1e6:.1f} MB are free there")


def seal(path: Path) -> None:
    """Append to a file the digest of its content, by which `check_seal` finds changes."""
    with open(path, "r+b") as file:
        of_content = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(0, os.SEEK_END)
        file.write(_SEAL + of_content.encode())


def check_seal(path: Path) -> None:
    """Raise `DamagedFileError` if any bit of a sealed file has changed, or if it has no seal."""
    left = os.path.getsize(path) - len(_SEAL) - END_DIGEST
    of_content = hashlib.sha256()
    with open(path, "rb") as file:
        while left > 0 and (part := file.read(min(left, _READ_BYTES))):
            of_content.update(part)
            left -= len(part)
        if file.read() != _SEAL + of_content.hexdigest().encode():
            raise DamagedFileError(
                f"{path}: the file is not as jointclosure wrote it (wrong checksum): {MAKE_AGAIN}"
            )


def digest(*parts: object) -> str:
    """Return the SHA-256 digest of settings, by their `repr`.

    They may be numbers, texts, and named tuples and mappings of them. The names and the order of
    fields count, and the names of the types of named tuples.
    """
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def write_csv(frame: pd.DataFrame, path: str | Path, figures: int | None = None) -> None:
    """Write a table as CSV, completely or not at all, without its index.

    Numbers have all digits, or ``figures`` significant digits.
    """
    form = None if figures is None else f"%.{figures}g"
    write_text(frame.to_csv(index=False, float_format=form), path)


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read a table written by `write_csv`, or an input in the same form.

    What follows a # in a line is left out.
    """
    return pd.read_csv(path, comment="#")


def read_text(path: str | Path) -> str:
    """Read a text, such as a log or a CSV; raise `InputError` unless it is UTF-8."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text ({error.reason} at {error.start})") from None


def write_text(text: str, path: str | Path) -> None:
    """Write a text as UTF-8, completely or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
