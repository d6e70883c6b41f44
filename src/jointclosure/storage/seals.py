"""Seals: which files a job of the workflow wrote, with what settings, and from which files.

A seal is a JSON file ``results/<study>/seals/<job>.json``, an output of its job like any other:

- ``files``: digests of the files that the job wrote, by their paths from the study's folder;
- ``made_from``: digests of the sealed files that it read;
- ``settings``: the digest of the rule's parameters, the digest of its code included.

Tables stay plain CSV. The digest of a netCDF file is the one that the file ends with.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.files import END_DIGEST, atomically

_AGAIN = "delete it and start again, what is missing is made anew"
_NEED_NO_SEAL = (".nc", ".txt")
"""Case files bear their settings themselves, and the readers check these; notes are not read."""


OTHER_SETTINGS = "the file was made with other settings, or by other code"


class ForeignFileError(InputError):
    """A file that is not the one that its seal, or this configuration, says."""


def settings_digest(settings: Mapping) -> str:
    """Digest of the parameters of a rule."""
    text = json.dumps(dict(settings), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def file_digest(path: str | Path) -> str:
    """SHA-256 of a file; of netCDF the one at its end, which whoever reads the file checks."""
    with open(path, "rb") as file:
        if Path(path).suffix == ".nc":
            file.seek(max(os.path.getsize(path) - END_DIGEST, 0))
            return file.read().decode(errors="replace")
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_seal(
    seal: str | Path, outputs: Iterable[str], settings: Mapping, inputs: Iterable[str], seals
) -> None:
    """Seal what a job wrote.

    Parameters
    ----------
    seal : path
        In a folder ``seals`` of the study's folder, or below it.
    outputs, inputs : iterable of paths
        What the job wrote, and read.
    settings : mapping
        What its rule told it.
    seals : iterable of paths
        Seals of those inputs that have one.
    """
    folder, listed = _folder(seal), _listed(seals)
    read = {path: listed[path] for path in map(os.path.normpath, inputs) if path in listed}
    content = {
        "settings": settings_digest(settings),
        "files": {os.path.relpath(path, folder): file_digest(path) for path in outputs},
        "made_from": {os.path.relpath(path, folder): digest for path, digest in read.items()},
    }
    text = json.dumps(content, indent=1) + "\n"
    atomically(seal, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def check_inputs(inputs: Iterable[str | Path], seals: Iterable[str | Path]) -> None:
    """Raise `ForeignFileError` unless files are those that their seals list."""
    paths = [Path(seal) for seal in seals]
    for seal in paths:
        if reason := _reason(seal, paths):
            raise ForeignFileError(reason)
    listed = _listed(paths)
    for path in map(os.path.normpath, inputs):
        if path not in listed and Path(path).suffix not in _NEED_NO_SEAL:
            raise ForeignFileError(f"{path}: no seal says what it was made from: {_AGAIN}")


def unmet_seals(
    folder: str | Path, expected: Callable[[Path], str] = lambda seal: ""
) -> Iterator[tuple[Path, str]]:
    """Seals of a study that are not met, each with the reason.

    Parameters
    ----------
    folder : path
        Of the study's results.
    expected : callable
        Gives the `settings_digest` that a seal must have, empty where any will do.
    """
    seals = sorted((Path(folder) / "seals").rglob("*.json"))
    for seal in seals:
        if reason := _reason(seal, seals, expected(seal)):
            yield seal, reason


def check_folder(folder: str | Path) -> list[Path]:
    """Raise `ForeignFileError` unless every sealed file of a study is there and as it was written.

    Returns
    -------
    list of Path
        The sealed files, job by job.
    """
    for _, reason in unmet_seals(folder):
        raise ForeignFileError(reason)
    files = [Path(path) for path in _listed(sorted((Path(folder) / "seals").rglob("*.json")))]
    for file in files:
        if not file.is_file():
            raise ForeignFileError(f"{file}: is missing, though a job wrote it: start again")
    return files


def _reason(seal: Path, seals: Iterable[Path], expected: str = "") -> str:
    """Why a seal is not met, empty if it is."""
    try:
        said = _content(seal)
        files, settings = _paths(seal, said["files"]), said["settings"]
        sources = _paths(seal, said["made_from"])
    except (ValueError, KeyError, TypeError, AttributeError):
        return f"{seal}: is no seal of jointclosure: {_AGAIN}"
    for path, digest in files.items():
        if os.path.isfile(path) and file_digest(path) != digest:
            return f"{path}: the file is not as jointclosure wrote it: {_AGAIN}"
    first = next(iter(files), str(seal))
    if expected and expected != settings:
        return f"{first}: {OTHER_SETTINGS}: {_AGAIN}"
    listed = _listed(other for other in seals if other != seal)
    for source, digest in sources.items():
        if listed.get(source, digest) != digest:
            return f"{first}: the file was made from another {source}: {_AGAIN}"
    return ""


def _content(seal: Path) -> dict:
    return json.loads(Path(seal).read_text(encoding="utf-8"))


def _listed(seals: Iterable[str | Path]) -> dict[str, str]:
    """Digests of all files that seals list, by path."""
    listed: dict[str, str] = {}
    for seal in seals:
        try:
            listed |= _paths(Path(seal), _content(Path(seal))["files"])
        except (ValueError, KeyError, TypeError, AttributeError):
            continue  # `_reason` says so of that seal
    return listed


def _paths(seal: str | Path, files: Mapping[str, str]) -> dict[str, str]:
    folder = _folder(seal)
    return {os.path.normpath(folder / path): digest for path, digest in files.items()}


def _folder(seal: str | Path) -> Path:
    """The study's folder of a seal."""
    return next(parent.parent for parent in Path(seal).parents if parent.name == "seals")
