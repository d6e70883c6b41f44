"""What is written twice agrees: versions, extras, public names and contracts of imports."""

import ast
import inspect
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

import jointclosure as jc
from jointclosure.inputs.extras import EXTRAS
from jointclosure.inputs.keywords import documented
from jointclosure.measured.joint_arguments import MeasuredJoint

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def names(requirements: list[str]) -> set[str]:
    return {Requirement(text).name.lower() for text in requirements}


def test_the_version_is_that_of_pyproject():
    """Set up again where this fails after a change of the version: it is read as installed."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert jc.__version__ == PROJECT["version"] == citation["version"]


DECLARED = PROJECT["optional-dependencies"]


def test_the_extras_are_those_of_pyproject():
    assert set(EXTRAS) == set(DECLARED) - {"slurm", "kubernetes"}  # their modules are Snakemake's
    for extra, modules in EXTRAS.items():
        assert {name.lower() for name in modules} == names(DECLARED[extra]) - {"jointclosure"}


def test_the_library_needs_no_module_of_an_extra():
    for modules in EXTRAS.values():
        assert not names(PROJECT["dependencies"]) & {module.lower() for module in modules}


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


def test_every_public_name_is_what_its_module_defines():
    stub = ast.parse(Path(jc.__file__).with_suffix(".pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    modules = {alias.name: node.module for node in imports for alias in node.names}
    assert jc.__all__ == sorted(modules)
    for name, module in modules.items():
        public = getattr(jc, name)
        if inspect.ismodule(public):
            assert public.__name__ == f"jointclosure.{module}.{name}"
        else:
            assert public.__module__ == f"jointclosure.{module}"
    assert dir(jc) == sorted([*jc.__all__, "__version__"])
    with pytest.raises(AttributeError, match="simulte"):
        jc.simulte  # noqa: B018


def test_every_study_is_in_the_contracts_of_imports():
    held = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    studies = {f"studies.{file.parent.name}" for file in ROOT.glob("studies/*/page.md.j2")}
    (layers,) = (each["layers"][0] for each in held if each["name"].startswith("Studies build"))
    (alone,) = (each["modules"] for each in held if each["name"].startswith("No study imports"))
    assert set(layers.split(" | ")) == set(alone) == studies - {"studies.paper"}
