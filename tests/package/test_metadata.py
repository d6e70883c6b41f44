"""One version, one list of extras: what is written twice agrees."""

import inspect
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

import jointclosure as jc
from jointclosure.cli.options import documented
from jointclosure.inputs.extras import EXTRAS
from jointclosure.measured.joints import MeasuredJoint

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def names(requirements: list[str]) -> set[str]:
    return {Requirement(text).name.lower() for text in requirements}


def test_the_version_is_that_of_pyproject():
    """Set up again where this fails after a change of the version: it is read as installed."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert jc.__version__ == PROJECT["version"] == citation["version"]


def test_the_extras_are_those_of_pyproject_and_none_is_needed_by_the_library():
    declared = PROJECT["optional-dependencies"]
    assert set(EXTRAS) == set(declared) - {"slurm", "kubernetes"}  # their modules are Snakemake's
    for extra, modules in EXTRAS.items():
        of_extra = {module.lower() for module in modules}
        assert of_extra == names(declared[extra]) - {"jointclosure"}
        assert not names(PROJECT["dependencies"]) & of_extra


@pytest.mark.parametrize(
    "name", [name for name in jc.__all__ if inspect.isfunction(getattr(jc, name))]
)
def test_each_argument_of_a_public_function_is_documented(name):
    """The commands take the help of their options from there."""
    function = getattr(jc, name)
    arguments = inspect.signature(function).parameters.keys()
    if "conditions" in arguments:
        assert {"conditions", *jc.Conditions._fields} <= arguments
        arguments -= set(jc.Conditions._fields)
    if "curve" in arguments:
        assert {*MeasuredJoint._fields} <= arguments & documented(MeasuredJoint).keys()
        arguments -= set(MeasuredJoint._fields)
    assert arguments <= documented(function).keys()
