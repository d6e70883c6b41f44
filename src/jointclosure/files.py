"""Files that are whole or absent, and that show when they were changed.

A file is written under a temporary name in its folder, brought to the disk and
then renamed. A sealed one ends with a digest of all before it, so that one
changed bit is an error and never a number.
"""

import glob
import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

_SEAL = b"\nsha256 of all before this line: "
END_DIGEST = 64
"""Bytes at the end of a sealed file that are its digest."""
_SEAL_BYTES = len(_SEAL) + END_DIGEST

_READ_BYTES = 1_000_000
"""Read at a time: mapped whole, a file would count as memory."""


class DamagedFileError(OSError):
    """A file that is not as it was written."""


def atomically(path: str | Path, write: Callable[[Path], None]) -> None:
    """Call ``write`` with a temporary path, then rename it to ``path``.

    Raises
    ------
    OSError
        The file could not be written; says how much room its disk has. Errors
        that ``write`` raises otherwise are passed on.
    """
    path = Path(path)
    try:
        for litter in path.parent.glob(f".{glob.escape(path.stem)}.{8 * '?'}{path.suffix}"):
            litter.unlink(missing_ok=True)  # of a writer that was killed
        handle, name = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix
        )
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        os.chmod(temporary, 0o666 & ~_umask())
        _to_disk(temporary)
        os.replace(temporary, path)
        _to_disk(path.parent)
    except DamagedFileError:  # of a file that was read meanwhile
        raise
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _not_written(path: Path, error: Exception) -> OSError:
    free = shutil.disk_usage(path.parent).free if path.parent.is_dir() else 0
    return OSError(f"{path}: could not be written ({error}); {free / 1e6:.1f} MB are free there")


def seal(path: Path) -> None:
    """Append the digest of a file to it."""
    with open(path, "r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(0, os.SEEK_END)
        file.write(_SEAL + digest.encode())


def check_seal(path: Path) -> None:
    """Raise `DamagedFileError` if a sealed file is not as it was written, in any bit."""
    left = os.path.getsize(path) - _SEAL_BYTES
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while left > 0 and (part := file.read(min(left, _READ_BYTES))):
            digest.update(part)
            left -= len(part)
        if file.read() != _SEAL + digest.hexdigest().encode():
            raise DamagedFileError(
                f"{path}: the file is not as jointclosure wrote it (its checksum is not met): "
                "delete it and start again, what is missing is made anew"
            )


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
