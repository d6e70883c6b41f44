"""What the documents say, held against the project."""

import functools
import importlib.util
import re
import shlex
from pathlib import Path

import pytest
import yaml

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.storage.netcdf import write_netcdf
from studies.commands import COMMANDS
from studies.frame.cases import block_settings, cases_of
from studies.frame.closing import close_block
from studies.frame.configuration import merged, written_out
from studies.frame.tables import join_cases
from tests.joints import COARSE
from tests.studied import DEFAULT, study_of

ROOT = Path(__file__).parents[2]
DOCUMENTS = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *(ROOT / f"config/{name}README.md" for name in ("", "walls/")),
    *sorted((ROOT / "docs").rglob("*.md")),
]


def test_the_key_table_and_the_schema_are_those_of_the_keys():
    for file, text in (("README.md", "main"), ("schema.json", "schema")):
        page = (ROOT / "config" / file).read_text(encoding="utf-8")
        assert page == getattr(script("key_table"), text)(), file


def samples(language: str) -> list:
    """Fenced code of a language in all documents, each with its document."""
    found = []
    for document in DOCUMENTS:
        name = document.relative_to(ROOT).as_posix()
        text = document.read_text(encoding="utf-8")
        fences = re.findall(r"^```(\w*)\n(.*?)^```", text, re.S | re.M)
        codes = [code for kind, code in fences if kind == language]
        found += [pytest.param(code, id=f"{name}-{i}") for i, code in enumerate(codes)]
    return found


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A folder with the project's configurations, in which samples may write."""
    for name in ("config", "workflow"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def smoke_study(project):
    """The base case of the smoke study, smaller still, where that study has its results."""
    small = {"study": {"rocks": ["dolerite"]}, "grid": {"cells_x": 12, "cells_y": 12},
             "rocks": {"dolerite": {"max_normal_stress_MPa": 1}}, "output": {"stress_points": 5},
             "seating_stress_MPa": 0.1}  # fmt: skip
    study = study_of(small)
    case = cases_of(study)[0]
    settings = block_settings(study, case, range(2))
    closed = close_block(settings)
    folder = project / "results/smoke"
    folder.mkdir(parents=True)
    write_netcdf(join_cases([case], [closed]), folder / "study.nc")


WITH_PYTHON = [path for path in DOCUMENTS if "```python" in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("document", WITH_PYTHON, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_python_samples_run_one_after_the_other(document, smoke_study, monkeypatch):
    """Without the range of a joint, which takes half a minute (see test_pages), and coarse."""
    quick = functools.partial(jc.close, single=True, numerics=COARSE)
    monkeypatch.setattr(jc, "close", quick)
    codes = re.findall(r"^```python\n(.*?)^```", document.read_text(encoding="utf-8"), re.S | re.M)
    namespace: dict = {}
    for code in codes:
        exec(compile(code, document.name, "exec"), namespace)  # raises where one is wrong


@pytest.mark.parametrize("code", samples("yaml"))
def test_yaml_samples_are_valid_studies(code):
    """What a sample leaves out of a rock of its own is as in dolerite."""
    sample = yaml.safe_load(code)
    for name, rock in sample.get("rocks", {}).items():
        if name not in DEFAULT["rocks"]:
            usual = dict(DEFAULT["rocks"]["dolerite"], levels={})
            if "walls" in rock:
                del usual["jrc"]
            sample["rocks"][name] = merged(usual, rock)
    study_of(written_out(sample))


def command_lines(code: str) -> list[list[str]]:
    """Words of each command of a sample, without comments."""
    lines = [shlex.split(line, comments=True) for line in code.splitlines()]
    return [words for words in lines if words]


@pytest.mark.parametrize("code", [*samples("bash"), *samples("sh")])
def test_shell_samples_name_what_there_is_and_joints_are_closed(code, project, capsys):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    for program, *words in command_lines(code):
        program = program.removeprefix(".venv/bin/")
        if program == "make":
            assert words[0] in targets
            for word in words[1:]:
                key, _, value = word.partition("=")
                assert key in ("CONFIG", "CORES", "PYTHON")
                assert key != "CONFIG" or (ROOT / value).is_file()
        elif program == "jointclosure":
            arguments = cli.parser(words).parse_args(words)
            if words[0] == "simulate":
                assert arguments.run(arguments) == 0
        elif (program, *words[:2]) == ("python", "-m", "studies"):
            cli.parser(words[2:], "studies", COMMANDS, "studies.commands").parse_args(words[2:])
        elif program == "python":
            assert (ROOT / words[0]).is_file()
        elif program == "snakemake":
            paths = [words[words.index(option) + 1] for option in words if option == "--configfile"]
            assert all((ROOT / path).is_file() for path in paths)
        else:
            raise AssertionError(f"who is to run {program}?")


def script(name: str):
    """A script of the workflow, as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / f"workflow/scripts/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
