"""Seals: records of the files that a job of the workflow wrote, its settings and its inputs.

A seal is a JSON file ``results/<study>/seals/<job>.json``, an output of its job:

- ``files``: digests of the files that the job wrote, by their paths from the study's folder;
- ``made_from``: digests of the sealed files that it read;
- ``settings``: the digest of the rule's parameters, including the digest of its code.

Tables are plain CSV. The digest of a netCDF file is the one at the end of the file.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.files import END_DIGEST, atomically

_AGAIN = "delete it and start again; missing files are made again"
_NEED_NO_SEAL = (".nc", ".txt")
"""Suffixes of files without a seal: case files contain their settings, which readers check, and
notes are not read."""


OTHER_SETTINGS = "the file was made with other settings, or by other code"


class ForeignFileError(InputError):
    """Error for a file that does not match its seal, or this configuration."""


def settings_digest(settings: Mapping) -> str:
    """Return the digest of the parameters of a rule."""
    text = json.dumps(dict(settings), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a file; for netCDF the one at its end, which readers check."""
    with open(path, "rb") as file:
        if Path(path).suffix == ".nc":
            file.seek(max(os.path.getsize(path) - END_DIGEST, 0))
            return file.read().decode(errors="replace")
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_seal(
    seal: str | Path, outputs: Iterable[str], settings: Mapping, inputs: Iterable[str], seals
) -> None:
    """Write the seal of a job's files.

    Parameters
    ----------
    seal : path
        Path in the folder ``seals`` of the study's folder, or below it.
    outputs, inputs : iterable of paths
        Files that the job wrote, and read.
    settings : mapping
        Parameters of its rule.
    seals : iterable of paths
        Seals of the inputs that have one.
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
    """Raise `ForeignFileError` unless files match the seals that list them."""
    paths = [Path(seal) for seal in seals]
    for seal in paths:
        if reason := _reason(seal, paths):
            raise ForeignFileError(reason)
    listed = _listed(paths)
    for path in map(os.path.normpath, inputs):
        if path not in listed and Path(path).suffix not in _NEED_NO_SEAL:
            raise ForeignFileError(
                f"{path}: no seal lists the file, so its origin is unknown: {_AGAIN}"
            )


def unmet_seals(
    folder: str | Path, expected: Callable[[Path], str] = lambda seal: ""
) -> Iterator[tuple[Path, str]]:
    """Generate seals of a study that do not match, with the reasons.

    Parameters
    ----------
    folder : path
        Folder of the study's results.
    expected : callable
        Returns the `settings_digest` that a seal must have, empty to accept any.
    """
    seals = sorted((Path(folder) / "seals").rglob("*.json"))
    for seal in seals:
        if reason := _reason(seal, seals, expected(seal)):
            yield seal, reason


def check_folder(folder: str | Path) -> list[Path]:
    """Raise `ForeignFileError` unless every sealed file of a study exists and is as it was written.

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
            raise ForeignFileError(f"{file}: is missing, but a job wrote it: start again")
    return files


def seal_beside(path: str) -> str:
    """Return the seal that lists a file of results/<study>; empty if none does or needs to.

    It finds the seal of a file of another study, which no job of this one makes.
    """
    parts = Path(path).parts
    if parts[:1] != ("results",) or Path(path).suffix in _NEED_NO_SEAL:
        return ""
    seals = sorted(Path(*parts[:2], "seals").rglob("*.json"))
    name = os.path.normpath(path)
    return next((seal.as_posix() for seal in seals if name in _listed([seal])), "")


def _reason(seal: Path, seals: Iterable[Path], expected: str = "") -> str:
    """Return why a seal does not match, empty if it does."""
    try:
        content = _content(seal)
        files, settings = _paths(seal, content["files"]), content["settings"]
        sources = _paths(seal, content["made_from"])
    except (ValueError, KeyError, TypeError, AttributeError):
        return f"{seal}: is not a seal of jointclosure: {_AGAIN}"
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
    """Return digests of all files that seals list, by path."""
    listed: dict[str, str] = {}
    for seal in seals:
        try:
            listed |= _paths(Path(seal), _content(Path(seal))["files"])
        except (ValueError, KeyError, TypeError, AttributeError):
            continue  # `_reason` reports this seal
    return listed


def _paths(seal: str | Path, files: Mapping[str, str]) -> dict[str, str]:
    folder = _folder(seal)
    return {os.path.normpath(folder / path): digest for path, digest in files.items()}


def _folder(seal: str | Path) -> Path:
    """Return the study's folder of a seal."""
    return next(parent.parent for parent in Path(seal).parents if parent.name == "seals")
