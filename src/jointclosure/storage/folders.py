"""Folders of results that several runs may use; files of an earlier run are replaced."""

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.text import read_text, write_text

RECORD = "written.json"
"""File in such a folder with the names of the files that each command wrote."""


def replace_files(folder: Path, command: str, write: Callable[[Path], object]) -> list[str]:
    """Replace the files of a command's earlier run, if no error occurs; return the new names."""
    folder.mkdir(exist_ok=True)
    earlier = written_files(folder, command)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as unfinished:
        write(Path(unfinished))
        names = sorted(os.listdir(unfinished))
        # if the process ends here, the next run has all names in the record
        _record(folder, command, sorted({*earlier, *names}))
        for name in names:
            os.replace(Path(unfinished) / name, folder / name)
    for name in set(earlier) - set(names):
        (folder / name).unlink(missing_ok=True)
    _record(folder, command, names)
    return names


def add_file(folder: Path, command: str, name: str) -> None:
    """Record a file as one of the files of a command, to be replaced with them."""
    _record(folder, command, sorted({*written_files(folder, command), name}))


def written_files(folder: Path, command: str) -> list[str]:
    """Return the names of the files that the last run of a command wrote into a folder."""
    return check_record(folder).get(command, [])


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


def _record(folder: Path, command: str, names: list[str]) -> None:
    commands = check_record(folder) | {command: names}
    write_text(json.dumps(commands, indent=1, sort_keys=True) + "\n", folder / RECORD)
