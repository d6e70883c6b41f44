"""Folders of results: files by the type of their content, and a record of who wrote them.

Several commands may write into one folder; the files of an earlier run of a command are replaced.
"""

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.storage.files import atomically, read_text, write_csv, write_text
from jointclosure.storage.netcdf import write_netcdf

RECORD = "written.json"
"""File in a folder of results with the names of the files that each command wrote."""


def write(content: Any, path: str | Path) -> None:
    """Write content in the format of its type and of the suffix of the path.

    It is a dataset (.nc), a mesh (.vtu: points (n, 3) [m], triangles (m, 3), fields (m,) by name),
    an animation (.gif), a figure, a table, a text, or a record for JSON. The file is written
    completely or not at all.
    """
    path = Path(path)
    if isinstance(content, xr.Dataset):
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
    """Write the files of a command to a folder, in place of those of an earlier run of the command.

    ``files`` are contents by name (`write`). The folder is made if needed, in one that exists.
    Files of the earlier run that are not written again are deleted; files of other commands stay.
    All files are first written to a temporary folder inside: if this fails, the earlier files stay.
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
    """Record that a file in a folder belongs to a command: its next run replaces or deletes it.

    The file itself is not written.
    """
    _record(folder, command, [*check_record(folder).get(command, []), name])


def check_record(folder: Path) -> dict[str, list[str]]:
    """Return the names of the files that each command wrote to a folder, by its record.

    There are none without a record. Raise `InputError` if the record cannot be read, or names a
    file in another folder.
    """
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
    """Set the names of the files of a command in the record of a folder."""
    commands = check_record(folder) | {command: sorted({*names})}
    write_text(json.dumps(commands, indent=1, sort_keys=True) + "\n", folder / RECORD)
