"""Files and folders that are written completely or not at all; sealed files end with a digest.

Folders of results may be used by several runs; files of an earlier run are replaced.
"""

import errno
import glob
import hashlib
import json
import os
import shutil
import socket
import tempfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import get_ident
from typing import Any

import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs

RECORD = "written.json"  # in a folder of results: the names of the files that each command wrote
_SEAL = b"\nsha256 of all before this line: "  # before the digest at the end of a sealed file
END_DIGEST = 64  # length in bytes of the digest at the end of a sealed file
_READ_BYTES = 1_000_000  # at a time; a memory-mapped file would count as memory of the process
_NOT_OF_SPACE = (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EROFS, errno.ENAMETOOLONG)
"""Errors that a full disk cannot cause. netCDF reports a full disk as a denied permission, or by a
number."""


MAKE_AGAIN = "delete it and start again; missing files are made again"
"""Advice on a file that is damaged, or of another study."""


class DamagedFileError(OSError):
    """Error for a file that is not as it was written."""


def atomically(path: str | Path, write: Callable[[Path], object]) -> None:
    """Call ``write`` with a temporary path, then rename it; `OSError` may name the free space."""
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
    """Return the error to be raised, with the free space on the disk if that may be the reason."""
    message = f"{path}: could not be written ({error})"
    if error.errno in _NOT_OF_SPACE:
        return OSError(message)
    free = shutil.disk_usage(path.parent).free if path.parent.is_dir() else 0
    return OSError(f"{message}; {free / 1e6:.1f} MB are free there")


def seal(path: Path) -> None:
    """Append the digest of a file to it."""
    with open(path, "r+b") as file:
        of_content = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(0, os.SEEK_END)
        file.write(_SEAL + of_content.encode())


def check_seal(path: Path) -> None:
    """Raise `DamagedFileError` if a sealed file is not as it was written, in any bit."""
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
    """Return a digest of settings: of numbers, texts, and named tuples and mappings of them."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def write_csv(frame: pd.DataFrame, path: str | Path, figures: int | None = None) -> None:
    """Write a table; numbers have all digits, or ``figures`` significant ones."""
    form = None if figures is None else f"%.{figures}g"
    write_text(frame.to_csv(index=False, float_format=form), path)


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read a table written by `write_csv`, or an input in the same form."""
    return pd.read_csv(path, comment="#")


def read_text(path: str | Path) -> str:
    """Read a text, such as a log or a CSV; raise `InputError` unless it is UTF-8."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text ({error.reason} at {error.start})") from None


def write_text(text: str, path: str | Path) -> None:
    """Write a text, completely or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write(content: Any, path: str | Path) -> None:
    """Write content by its type and the suffix of the path, completely or not at all.

    It is a dataset (.nc), a mesh (.vtu: points (n, 3) [m], triangles (m, 3), fields (m,) by name),
    an animation (.gif), a figure, a table, a text, or a record for JSON.
    """
    path = Path(path)
    if path.suffix == ".nc":
        from jointclosure.storage.netcdf import write_netcdf  # a library that few jobs need

        write_netcdf(content, path)
    elif path.suffix == ".vtu":
        with needs("exchange", "VTU"):
            import meshio
        points, triangles, fields = content
        data = {name: [values] for name, values in fields.items()}
        mesh = meshio.Mesh(points, [("triangle", triangles)], cell_data=data)
        atomically(path, partial(mesh.write, file_format="vtu"))
    elif path.suffix == ".gif":
        atomically(path, partial(content.save, writer="pillow", dpi=100))
    elif hasattr(content, "savefig"):  # a PDF without a time stamp
        metadata = {"CreationDate": None} if path.suffix == ".pdf" else None
        atomically(path, partial(content.savefig, metadata=metadata))
        content.set_layout_engine("none")  # laid out once, for all formats
    elif isinstance(content, pd.DataFrame):
        write_csv(content, path)
    else:
        text = content if isinstance(content, str) else json.dumps(content, indent=1) + "\n"
        write_text(text, path)


def replace_files(folder: Path, command: str, files: Mapping[str, Any]) -> None:
    """Replace the files of a command's earlier run by others, which are contents by name.

    If an error occurs, the earlier files stay.
    """
    folder.mkdir(exist_ok=True)
    earlier = check_record(folder).get(command, [])
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as unfinished:
        for name, content in files.items():
            write(content, Path(unfinished) / name)
        # if the process ends here, the next run has all names in the record
        _record(folder, command, [*earlier, *files])
        for name in files:
            os.replace(Path(unfinished) / name, folder / name)
    for name in set(earlier) - set(files):
        (folder / name).unlink(missing_ok=True)
    _record(folder, command, files)


def add_file(folder: Path, command: str, name: str) -> None:
    """Record a file as one of the files of a command, to be replaced with them."""
    _record(folder, command, [*check_record(folder).get(command, []), name])


def check_record(folder: Path) -> dict[str, list[str]]:
    """Return the files of each command by a folder's record; `InputError` if it cannot be read."""
    path = folder / RECORD
    if not path.is_file():
        return {}
    try:
        commands = json.loads(read_text(path))
        names = [name for files in commands.values() for name in files]
        if any(Path(name).name != name for name in names):
            raise ValueError("a name with a folder")
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: must be a JSON object of lists of file names, as written by jointclosure "
            f"({error}); delete it, and the files of earlier runs in the folder"
        ) from None
    return commands


def _record(folder: Path, command: str, names: Iterable[str]) -> None:
    """Write the names of a command's files to the record of a folder."""
    commands = check_record(folder) | {command: sorted({*names})}
    write_text(json.dumps(commands, indent=1, sort_keys=True) + "\n", folder / RECORD)
