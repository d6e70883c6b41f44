"""Files of a finished study, as the commands that read them ask for them."""

from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.seals import check_folder


def existing(path: Path) -> Path:
    """A file that a finished study has.

    Raises
    ------
    InputError
        There is no such file.
    """
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; is the study finished?")
    return path


def study_of(folder: Path) -> Path:
    """study.nc of a folder of results in which every sealed file is as it was written.

    Raises
    ------
    InputError
        There is none.
    ForeignFileError
        A sealed file is missing, or not the one that its seal says.
    """
    study = existing(folder / "study.nc")
    check_folder(folder)
    return study
