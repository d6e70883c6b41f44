"""The project's folder, and the studies that its configurations describe.

The workflow has Snakemake merge configurations; this is for what runs beside it.
"""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import yaml

from jointclosure.config.configuration import (
    checked,
    merged,
    read_plain,
    read_schema,
    written_out,
)
from jointclosure.config.presets import chosen_numerics
from jointclosure.inputs import InputError
from jointclosure.sources import PACKAGE

_DEFAULT, _SCHEMA = "config/default.yaml", "workflow/schemas/config.schema.yaml"
_MEASURED = "workflow/resources/accuracy_settings.csv"
SHIPPED = PACKAGE / "shipped"
"""Copies of these three in a package that was installed from a wheel (pyproject.toml)."""


def project_folder(*near: Path) -> Path:
    """The project's folder, that of ``config/default.yaml``: the first found at or above a path.

    Outside of a project it is the copy that the package bears.
    """
    for path in (*near, SHIPPED):
        for folder in (path.resolve(), *path.resolve().parents):
            if (folder / _DEFAULT).is_file() and (folder / _SCHEMA).is_file():
                return folder
    raise InputError(
        f"found no {_DEFAULT} at or above {', '.join(str(path.resolve()) for path in near)}: "
        "run this in the project's folder"
    )


def merged_study(project: Path, path: Path | None) -> dict:
    """The default configuration and a file over it, not yet checked.

    Raises
    ------
    InputError
        The file is not there, or is no plain YAML.
    """
    files = [project / _DEFAULT] + ([path] if path else [])
    for file in files:
        if not file.is_file():
            raise InputError(f"{file}: there is no such file")
    return merged(*(written_out(read_plain(file)) for file in files))


def settled(settings: dict, project: Path, read: Callable[[Path], pd.DataFrame]) -> dict:
    """A merged configuration as the workflow would run it: choices made, checked.

    Parameters
    ----------
    settings, project, read
        As for `decided`.

    Raises
    ------
    ConfigurationError
        As `checked`.
    """
    return checked(decided(settings, project, read)[0], read_schema(project / _SCHEMA))


def decided(
    settings: dict, project: Path, read: Callable[[Path], pd.DataFrame]
) -> tuple[dict, str]:
    """A merged configuration whose words stand for numbers, not yet checked.

    Parameters
    ----------
    settings : dict
    project : path
    read : callable
        Reads the table that ``numerics.preset`` and ``accuracy`` choose from.

    Returns
    -------
    settings : dict
    said : str
        A sentence on the numerics that were chosen, empty where none were.

    Raises
    ------
    InputError
        As `jointclosure.config.presets.chosen_numerics`.
    """
    settings = written_out(settings)
    if not all(isinstance(settings[key], dict) for key in ("numerics", "effects", "rocks")):
        return settings, ""  # the schema says what they must be
    default = read_plain(project / _DEFAULT)["numerics"]
    chosen = chosen_numerics(settings, default, lambda: read(project / _MEASURED))
    return settings | {"numerics": chosen.numerics}, chosen.said


def value_of(text: str) -> object:
    """A value as a configuration would have it: a number, a word, a list."""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise InputError(f"{text!r}: is no value of a configuration") from None
