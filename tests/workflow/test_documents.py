"""What the documents say, held against the project."""

import functools
import importlib
import re
import shlex
from types import SimpleNamespace

import jinja2
import pytest
import yaml

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.ensembles.quantities import names_of_case
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.cases import cases_of
from studies.frame.configuration import merged, written_out
from studies.frame.datasets import of_case
from studies.frame.experiments import case_point
from studies.frame.joint_tables import join_cases
from studies.frame.settings import surface_settings, walls_of
from studies.frame.simulation import close_joints
from tests.joints import COARSE
from tests.studied import DEFAULT, ROOT, study_of

DOCUMENTS = sorted(p for where in ("", "config/**/", "docs/**/") for p in ROOT.glob(f"{where}*.md"))


@pytest.mark.parametrize(("file", "function"), [("README.md", "main"), ("schema.json", "schema")])
def test_a_description_of_the_keys_is_that_of_the_keys(file, function, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    made = getattr(importlib.import_module("key_table"), function)()
    assert (ROOT / "config" / file).read_text(encoding="utf-8") == made


def test_a_caption_speaks_of_the_law_of_made_walls_only_where_walls_are_made():
    caption = (ROOT / "workflow/report/fig_5_closure.rst").read_text(encoding="utf-8")
    made, scanned = SimpleNamespace(walls=None), SimpleNamespace(walls="slate.txt")
    for rocks, speaks in (
        ({"made": made, "scanned": scanned}, True),
        ({"scanned": scanned}, False),
    ):
        job = SimpleNamespace(
            config={"study": {"realizations": 4}}, params=SimpleNamespace(rocks=rocks)
        )
        assert ("Barton-Bandis" in jinja2.Template(caption).render(snakemake=job)) == speaks


def samples(language: str) -> list:
    """Fenced codes of a language of each document that has one."""
    fence, found = re.compile(rf"^```{language}\n(.*?)^```", re.S | re.M), []
    for document in DOCUMENTS:
        if codes := fence.findall(document.read_text(encoding="utf-8")):
            found.append(pytest.param(codes, id=document.relative_to(ROOT).as_posix()))
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
    point = case_point(study, case, range(2))
    walls = walls_of(surface_settings(point.settings))
    closed = close_joints(point, walls, names_of_case(study.flow))
    folder = project / "results/smoke"
    folder.mkdir(parents=True)
    write_netcdf(join_cases([case], [of_case(closed)]), folder / "study.nc")


@pytest.mark.parametrize("codes", samples("python"))
def test_python_samples_run_one_after_the_other(codes, smoke_study, monkeypatch):
    """Without the range of a joint, which takes half a minute (see test_pages), and coarse."""
    quick = functools.partial(jc.close, single=True, numerics=COARSE)
    monkeypatch.setattr(jc, "close", quick)
    namespace: dict = {}
    for code in codes:
        exec(code, namespace)  # raises where one is wrong


@pytest.mark.parametrize("codes", samples("yaml"))
def test_yaml_samples_are_valid_studies(codes):
    """What a sample leaves out of a rock of its own is as in dolerite."""
    for sample in map(yaml.safe_load, codes):
        for name, rock in sample.get("rocks", {}).items():
            if name not in DEFAULT["rocks"]:
                usual = dict(DEFAULT["rocks"]["dolerite"], levels={})
                if "walls" in rock:
                    del usual["jrc"]
                sample["rocks"][name] = merged(usual, rock)
        study_of(written_out(sample))


SHELL_SAMPLES = pytest.mark.parametrize("codes", samples("(?:bash|sh)"))


def commands_in(codes):
    """Programs of this project and their words in each line of shell samples."""
    lines = [shlex.split(line, comments=True) for code in codes for line in code.splitlines()]
    return [(line[0].removeprefix(".venv/bin/"), line[1:]) for line in lines if line]


@SHELL_SAMPLES
def test_shell_samples_name_what_there_is(codes, project):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    rules = re.findall(
        r"^(?: {4})?(?:rule|checkpoint) (\w+):",
        "\n".join(file.read_text() for file in (ROOT / "workflow/rules").glob("*.smk")),
        re.M,
    )
    for program, words in commands_in(codes):
        if program == "make":
            assert words[0] in targets
            for word in words[1:]:
                key, _, value = word.partition("=")
                assert key in ("CONFIG", "CORES", "PROFILE", "PYTHON")
                assert key != "CONFIG" or (ROOT / value).is_file()
        elif program == "snakemake":
            for word in words:
                assert word.startswith(("-", "results/")) or word in rules or (ROOT / word).exists()
        elif program == "jointclosure":
            cli.parser(words).parse_args(words)
        else:
            raise AssertionError(f"who is to run {program}?")


@SHELL_SAMPLES
def test_joints_of_shell_samples_are_closed(codes, project, capsys):
    for program, words in commands_in(codes):
        if program == "jointclosure" and words[0] == "simulate":
            arguments = cli.parser(words).parse_args(words)
            assert arguments.run(arguments) == 0
