"""Files that are written completely or not at all; sealed ones end with a digest."""

import errno
import glob
import hashlib
import os
import shutil
import socket
import tempfile
from collections.abc import Callable
from pathlib import Path

_SEAL = b"\nsha256 of all before this line: "
END_DIGEST = 64
"""Length in bytes of the digest at the end of a sealed file."""
_READ_BYTES = 1_000_000
"""Number of bytes read at a time; a memory-mapped file would count as memory of the process."""
_NOT_OF_SPACE = (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EROFS, errno.ENAMETOOLONG)
"""Errors that a full disk cannot cause; netCDF reports one as a denied permission, or by a
number."""


class DamagedFileError(OSError):
    """Error for a file that is not as it was written."""


def atomically(path: str | Path, write: Callable[[Path], object]) -> None:
    """Call ``write`` with a temporary path, then rename it; `OSError` may name the free space."""
    path = Path(path)
    try:
        _remove_litter(path)
        handle, name = tempfile.mkstemp(
            dir=path.parent,
            prefix=f".{path.stem}.{socket.gethostname()}-{os.getpid()}-",
            suffix=path.suffix,
        )
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        _to_disk(temporary)
        os.replace(temporary, path)
        _to_disk(path.parent)
    except DamagedFileError:  # from a file that was read by ``write``
        raise
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _remove_litter(path: Path) -> None:
    """Remove temporary files for a path whose writers were killed on this computer."""
    written_here = f".{path.stem}.{socket.gethostname()}-"
    for litter in path.parent.glob(f"{glob.escape(written_here)}*-{8 * '?'}{path.suffix}"):
        pid = litter.name.removeprefix(written_here).split("-")[0]
        if pid.isdecimal() and not _runs(int(pid)):
            litter.unlink(missing_ok=True)


def _runs(pid: int) -> bool:
    import psutil  # only needed if there are such files

    try:
        return psutil.Process(pid).status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    except psutil.Error as error:
        return isinstance(error, psutil.AccessDenied)


def _to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _not_written(path: Path, error: OSError) -> OSError:
    """Return the error to be raised, with the free space on the disk if that may be the reason."""
    message = f"{path}: could not be written ({error})"
    if error.errno in _NOT_OF_SPACE:
        return OSError(message)
    free = shutil.disk_usage(path.parent).free if path.parent.is_dir() else 0
    return OSError(f"{message}; {free / 1e6:.1f} MB are free there")


def seal(path: Path) -> None:
    """Append the digest of a file to it."""
    with open(path, "r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(0, os.SEEK_END)
        file.write(_SEAL + digest.encode())


def check_seal(path: Path) -> None:
    """Raise `DamagedFileError` if a sealed file is not as it was written, in any bit."""
    left = os.path.getsize(path) - len(_SEAL) - END_DIGEST
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while left > 0 and (part := file.read(min(left, _READ_BYTES))):
            digest.update(part)
            left -= len(part)
        if file.read() != _SEAL + digest.hexdigest().encode():
            raise DamagedFileError(
                f"{path}: the file is not as jointclosure wrote it (wrong checksum): "
                "delete it and start again; missing files are made again"
            )
