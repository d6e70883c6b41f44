"""Files of a finished study, for the commands that read them."""

from pathlib import Path

from jointclosure.inputs import InputError
from studies.frame.jobs.seals import check_folder


def existing(path: Path) -> Path:
    """Return the path of a file of a finished study."""
    if not path.is_file():
        raise InputError(f"{path}: file not found; is the study finished?")
    return path


def study_of(folder: Path) -> Path:
    """Return the path of study.nc in a folder of results after checking all seals."""
    study = existing(folder / "study.nc")
    check_folder(folder)
    return study
