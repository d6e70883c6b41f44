"""Commands on finished studies, one module each, as in `jointclosure.cli`; and their files."""

from pathlib import Path

from jointclosure.inputs import InputError

COMMANDS = {
    "compare": "list the differences between two studies",
    "report": "write a page on a finished study",
    "engineering": "tabulate curves and stiffness of a study, with bands over its joints",
    "repeat": "repeat one realisation of a study",
}
"""Names of the modules and their purposes; modules are imported when they are used."""


def existing(path: Path) -> Path:
    """Return the path of a file of a finished study; raise `InputError` if there is none."""
    if not path.is_file():
        raise InputError(f"{path}: file not found; is the study finished?")
    return path


def study_of(folder: Path) -> Path:
    """Return the path of study.nc in a folder of results; raise `InputError` if there is none."""
    return existing(folder / "study.nc")
