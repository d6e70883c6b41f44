"""Folders of results that several runs may write into: files of an earlier run do not stay."""

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.text import read_text, write_text

RECORD = "written.json"
"""File of such a folder with the names of what was written into it, by command."""


def replace_files(folder: Path, command: str, write: Callable[[Path], object]) -> list[str]:
    """Put new files into a folder in place of those that an earlier run of a command wrote there.

    Parameters
    ----------
    folder : path
        Made where it does not exist. Files that the record does not name are left alone.
    command : str
        Name of the command, under which the files are recorded.
    write : callable
        Writes the files into the folder that it is given, an empty one beside them: where it
        fails, those of the earlier run stay.

    Returns
    -------
    list of str
        Names of the new files, sorted.

    Raises
    ------
    InputError
        The folder's record cannot be read.
    """
    folder.mkdir(exist_ok=True)
    earlier = written_files(folder, command)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as unfinished:
        write(Path(unfinished))
        names = sorted(os.listdir(unfinished))
        # whatever ends this here, the next run finds all names in the record
        _record(folder, command, sorted({*earlier, *names}))
        for name in names:
            os.replace(Path(unfinished) / name, folder / name)
    for name in set(earlier) - set(names):
        (folder / name).unlink(missing_ok=True)
    _record(folder, command, names)
    return names


def add_file(folder: Path, command: str, name: str) -> None:
    """Record a file that belongs to those of a command, and goes with them."""
    _record(folder, command, sorted({*written_files(folder, command), name}))


def written_files(folder: Path, command: str) -> list[str]:
    """Names of the files that the last run of a command wrote into a folder.

    Raises
    ------
    InputError
        The folder's record cannot be read.
    """
    return _commands(folder).get(command, [])


def check_record(folder: Path) -> None:
    """Raise `InputError` where the record of a folder cannot be read; one without is fine."""
    _commands(folder)


def _commands(folder: Path) -> dict[str, list[str]]:
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
            f"{path}: must be a JSON object of lists of file names, as jointclosure writes it "
            f"({error}); delete it, and what earlier runs wrote into the folder"
        ) from None
    return commands


def _record(folder: Path, command: str, names: list[str]) -> None:
    commands = _commands(folder) | {command: names}
    write_text(json.dumps(commands, indent=1, sort_keys=True) + "\n", folder / RECORD)
