"""Seals of written files: only the file that a job wrote, of these settings and files, is read.

A seal is a JSON file ``results/<study>/seals/<job>.json``: digests of the ``files`` that the job
wrote and of the sealed ones that they were ``made_from``, by paths from the study's folder, and the
digest of the rule's ``settings``, its code among them. Snakemake compares times and its own notes,
which a file from elsewhere may have too.
"""

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from jointclosure.engine.workers import end_with_parent
from jointclosure.inputs import InputError
from jointclosure.storage.files import END_DIGEST, write_text
from jointclosure.storage.logs import SHOWN, Logbook, logging_to

if TYPE_CHECKING:
    from studies.frame.products import Step

ENGINE = "JOINTCLOSURE_ENGINE"
"""Variable of the environment with the process of Snakemake, if that starts its jobs itself."""
OTHER_SETTINGS = "the file was made with other settings or fewer surfaces, or by other code"
_UNLISTED = "no seal lists the file"
_AGAIN = "delete it and start again; missing files are made again"
_NEED_NO_SEAL = (".nc", ".txt")
"""Suffixes of files without a seal: files of a cache have their key, and notes are not read."""


class ForeignFileError(InputError):
    """Error for a file that does not match its seal, or this configuration."""


class Seal(NamedTuple):
    """Content of a seal; digests by path."""

    settings: str
    files: dict[str, str]
    made_from: dict[str, str]

    def problem(self, listed: dict[str, str], expected: str) -> str:
        """Return why it does not match the files of a study and those listed, empty if it does."""
        for path, digest in self.files.items():
            if os.path.isfile(path) and file_digest(path) != digest:
                return f"{path}: the file is not as jointclosure wrote it"
        first = next(iter(self.files), "")
        if expected and expected != self.settings:
            return f"{first}: {OTHER_SETTINGS}"
        for source, digest in self.made_from.items():
            if listed.get(source, digest) != digest:
                return f"{first}: the file was made from another {source}"
        return ""


@contextmanager
def job(snakemake) -> Iterator[Logbook]:
    """Open the log of a job of Snakemake, check its inputs, and seal its outputs."""
    if engine := os.environ.get(ENGINE):
        end_with_parent(int(engine))
    log = Path(snakemake.log[0])
    try:
        with logging_to(log, snakemake.log.benchmark) as logbook:
            study = study_of(log)
            inputs = [path for path in snakemake.input if Path(path).is_relative_to(study.parent)]
            check_inputs(inputs)
            yield logbook
            if is_sealed(snakemake.output, snakemake.params):
                seal = study / "seals" / log.relative_to(study / "logs").with_suffix(".json")
                seal.parent.mkdir(parents=True, exist_ok=True)
                write_seal(seal, snakemake.output, dict(snakemake.params), inputs)
    except BaseException as error:
        reason = f"{type(error).__name__}: {error}; its log is {log}"
        print(f"{SHOWN}{snakemake.rule} failed: {reason}", file=sys.__stderr__, flush=True)
        raise


def study_of(file: str | Path) -> Path:
    """Return the folder results/<study> in which a file lies."""
    return next(folder for folder in Path(file).parents if folder.parent.name == "results")


def is_sealed(output, params) -> bool:
    """Return whether a job seals its outputs: notes are no input, a file of a cache has a key."""
    return Path(str(output[0])).suffix != ".txt" and not params.get("key")


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
    seal: str | Path, outputs: Iterable[str | Path], settings: Mapping, inputs: Iterable[str | Path]
) -> None:
    """Write the seal, in the folder ``seals`` of a study, of files made of inputs."""
    folder = next(parent.parent for parent in Path(seal).parents if parent.name == "seals")
    read = [os.path.normpath(path) for path in inputs]
    listed = {p: d for study in {*map(study_of, read)} for p, d in sealed_files(study).items()}
    content = {
        "settings": settings_digest(settings),
        "files": {os.path.relpath(path, folder): file_digest(path) for path in outputs},
        "made_from": {os.path.relpath(p, folder): listed[p] for p in read if p in listed},
    }
    write_text(json.dumps(content, indent=1) + "\n", seal)


def check_inputs(inputs: Iterable[str | Path]) -> None:
    """Raise `ForeignFileError` unless files of studies match their seals."""
    paths = {os.path.normpath(path) for path in inputs}
    unlisted = {path for path in paths if Path(path).suffix not in _NEED_NO_SEAL}
    for study in sorted(set(map(study_of, paths))):
        for _, _, reason in unmet_seals(study, among=paths):
            raise ForeignFileError(f"{reason}: {_AGAIN}")
        unlisted -= sealed_files(study).keys()
    for path in sorted(unlisted):
        raise ForeignFileError(f"{path}: {_UNLISTED}, so its origin is unknown: {_AGAIN}")


def unmet_seals(
    folder: Path,
    expected: Callable[[Seal], str] = lambda seal: "",
    among: Set[str] | None = None,
) -> Iterator[tuple[Path, Seal | None, str]]:
    """Generate seals of a study that do not match, with the reasons; None for what is no seal.

    ``expected`` gives the `settings_digest` of a seal, empty for any. Seals of no file ``among``
    some do not count: other jobs may write their files.
    """
    listed = sealed_files(folder)
    for path, seal in seals_in(folder).items():
        if seal is None:
            yield path, None, f"{path}: is not a seal of jointclosure"
            continue
        counts = among is None or among & seal.files.keys()
        if counts and (reason := seal.problem(listed, expected(seal))):
            yield path, seal, reason


def sealed_files(folder: Path) -> dict[str, str]:
    """Return digests by path of the files that the seals of a study list."""
    seals = filter(None, seals_in(folder).values())
    return {path: digest for seal in seals for path, digest in seal.files.items()}


def check_folder(folder: Path) -> list[Path]:
    """Return the sealed files of a study; `ForeignFileError` unless all are as they were made."""
    for _, _, reason in unmet_seals(folder):
        raise ForeignFileError(f"{reason}: {_AGAIN}")
    files = [Path(path) for path in sealed_files(folder)]
    for file in files:
        if not file.is_file():
            raise ForeignFileError(f"{file}: is missing, but a job wrote it: start again")
    return files


def seals_in(folder: Path) -> dict[Path, Seal | None]:
    """Return the seals of a study by path; None for what is no seal."""
    seals: dict[Path, Seal | None] = {}
    for path in sorted((folder / "seals").rglob("*.json")):
        seals[path] = None
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            content = json.loads(path.read_text(encoding="utf-8"))
            files, made_from = (
                {os.path.normpath(folder / name): digest for name, digest in content[part].items()}
                for part in ("files", "made_from")
            )
            seals[path] = Seal(content["settings"], files, made_from)
    return seals


def withdraw_unmet(steps: Iterable["Step"], report: Callable[[str], None], remove: bool) -> None:
    """Report sealed files that are not as these steps write them; remove them and what follows."""
    makers = {file: step for step in steps for file in step.files}

    def expected(seal: Seal) -> str:
        maker = makers.get(next(iter(seal.files), ""))
        return settings_digest(maker.params()) if maker else ""

    for folder in sorted({study_of(file) for file in makers}):
        unmet = list(unmet_seals(folder, expected))
        sealed = {file for file, step in makers.items() if is_sealed(step.files, {})}
        foreign = {
            file
            for file in sealed - sealed_files(folder).keys()
            if study_of(file) == folder and Path(file).is_file()
        }
        reasons = [reason for _, _, reason in unmet]
        other = [reason for reason in reasons if OTHER_SETTINGS in reason]
        lines = [reason for reason in reasons if reason not in other] + other[:1]
        if len(other) > 1:
            lines.append(f"{folder}: the same of {len(other) - 1} more jobs")
        for line in (*lines, *(f"{file}: {_UNLISTED}" for file in sorted(foreign))):
            report(f"jointclosure: {line}")
        withdrawn = foreign | {file for _, seal, _ in unmet if seal for file in seal.files}
        for path in [path for path, _, _ in unmet] if remove else ():
            path.unlink(missing_ok=True)
        while remove and withdrawn:  # and what was made of them, with its seals
            for file in withdrawn:
                Path(file).unlink(missing_ok=True)
            seals = seals_in(folder).items()
            made = {
                path: seal for path, seal in seals if seal and seal.made_from.keys() & withdrawn
            }
            for path in made:
                path.unlink()
            withdrawn = {file for seal in made.values() for file in seal.files}
