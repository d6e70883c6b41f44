"""One version, one list of extras: what is written twice agrees."""

import importlib.metadata
import re
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.version import Version

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


def test_no_module_writes_a_version_of_its_own():
    for file in (ROOT / "src").rglob("*.py"):
        assert PROJECT["version"] not in re.findall(r'"([\d.]+)"', file.read_text("utf-8")), file


def test_the_extras_that_are_told_of_are_those_of_pyproject():
    declared = PROJECT["optional-dependencies"]
    assert set(EXTRAS) == set(declared) - {"slurm", "kubernetes"}  # their modules are Snakemake's
    for extra, modules in EXTRAS.items():
        assert {module.lower() for module in modules} == names(declared[extra]) - {"jointclosure"}


def test_the_library_needs_neither_snakemake_nor_plots():
    for extra in EXTRAS.values():
        assert not names(PROJECT["dependencies"]) & {module.lower() for module in extra}


def test_the_lock_has_one_version_of_each_package_for_all_pythons():
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = re.findall(r"^([A-Za-z0-9._-]+)==(\S+)", lock, re.M)
    assert len(locked) == len({name for name, _ in locked}) > 100
    assert "://" not in lock
    for text in PROJECT["dependencies"]:
        wanted = Requirement(text)
        assert Version(dict(locked)[wanted.name.lower()]) in wanted.specifier


def test_what_is_installed_is_what_is_locked():
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    for name in ("numpy", "numba", "scipy", "pandas", "xarray"):
        assert f"\n{name}=={importlib.metadata.version(name)} " in lock


def test_a_missing_module_names_its_extra_in_one_line():
    with pytest.raises(InputError) as caught, needs("report", "a page"):
        raise ModuleNotFoundError("No module named 'plotly'", name="plotly.offline")
    assert "a page needs plotly" in str(caught.value)
    assert "pip install 'jointclosure[report]'" in str(caught.value)


def test_another_missing_module_is_no_matter_of_the_extra():
    with pytest.raises(ModuleNotFoundError), needs("report", "a page"):
        raise ModuleNotFoundError("No module named 'x'", name="x")
