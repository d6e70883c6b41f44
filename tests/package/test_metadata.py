"""One version, one list of extras: what is written twice agrees."""

import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

import jointclosure as jc
from jointclosure.inputs import InputError
from jointclosure.inputs.extras import EXTRAS, needs

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def names(requirements: list[str]) -> set[str]:
    return {Requirement(text).name.lower() for text in requirements}


def test_the_version_is_that_of_pyproject():
    """Set up again where this fails after a change of the version: it is read as installed."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert jc.__version__ == PROJECT["version"] == citation["version"]


def test_the_extras_that_are_told_of_are_those_of_pyproject():
    declared = PROJECT["optional-dependencies"]
    assert set(EXTRAS) == set(declared) - {"slurm", "kubernetes"}  # their modules are Snakemake's
    for extra, modules in EXTRAS.items():
        assert {module.lower() for module in modules} == names(declared[extra]) - {"jointclosure"}


def test_the_library_needs_neither_snakemake_nor_plots():
    for extra in EXTRAS.values():
        assert not names(PROJECT["dependencies"]) & {module.lower() for module in extra}


def test_a_missing_module_names_its_extra_in_one_line():
    with pytest.raises(InputError) as caught, needs("report", "a page"):
        raise ModuleNotFoundError("No module named 'plotly'", name="plotly.offline")
    assert "a page needs plotly" in str(caught.value)
    assert "pip install 'jointclosure[report]'" in str(caught.value)
