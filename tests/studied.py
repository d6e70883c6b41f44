"""Studies for tests: the paper's, with the changes of a test."""

from pathlib import Path

from studies.frame.configuration import Configuration, configured, merged
from studies.frame.yaml_files import DEFAULT as DEFAULT_FILE
from studies.frame.yaml_files import read_plain

ROOT = Path(__file__).parents[1]
DEFAULT = read_plain(DEFAULT_FILE)


def keys_of(*changes: dict) -> dict:
    """Return the paper's keys with changes merged over them, not checked."""
    return merged(DEFAULT, *changes)


def tiny(experiment: str) -> dict:
    """Return the keys of an experiment so small that it takes seconds."""
    return read_plain(ROOT / f"studies/{experiment}/tiny_{experiment}.yaml")


def study_of(*changes: dict) -> Configuration:
    """Return the configuration of the paper's study with changes, checked."""
    return configured(keys_of(*changes))
