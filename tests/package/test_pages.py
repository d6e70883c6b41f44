"""Stored results state their origin, and pages are made of them."""

import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from jointclosure.cli import main as cli
from jointclosure.inputs import InputError
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.configuration import merged, merged_study
from studies.frame.yaml_files import provenance

sys.path.insert(0, str(Path(__file__).parents[2] / "docs/site"))
import publish
import templates

ROOT = templates.ROOT
ORIGINS = sorted([*ROOT.glob("studies/*/published/*/origin.json"),
                  *ROOT.glob("benchmarks/results/*/origin.json")])  # fmt: skip
SOLVER = "5cfd014e"
"""Commit of the present solver; later ones: same bits."""


@pytest.mark.parametrize("page", templates.pages(), ids=lambda page: page.name)
def test_a_committed_page_is_what_its_template_gives(page):
    template = templates.pages()[page]
    different = f"{page.name} differs: edit {template}, then make docs"
    assert page.read_text(encoding="utf-8") == templates.made(template), different


def commit_of(path):
    """The commit that a stored result names."""
    return json.loads(path.read_text(encoding="utf-8"))["commit"]


@pytest.mark.parametrize("path", ORIGINS, ids=lambda path: path.parent.name)
def test_a_stored_result_names_its_commit(path):
    assert commit_of(path)


@pytest.mark.parametrize("path", ORIGINS, ids=lambda path: path.parent.name)
def test_a_stored_result_is_listed_if_its_solver_is_older(path):
    git = ["git", "-C", str(ROOT), "merge-base", "--is-ancestor", SOLVER, commit_of(path)]
    status = subprocess.run(git, check=False, capture_output=True).returncode
    if status > 1:
        pytest.skip("the history is not here")
    assert (status == 1) == (path.parent.name in templates.OLDER_SOLVER)


def test_results_that_are_not_complete_replace_nothing_that_was_stored(tmp_path, monkeypatch):
    stored, run = tmp_path / "studies/mismatch/published/mismatch", tmp_path / "mismatch"
    shutil.copytree(ROOT / "studies/mismatch/published/mismatch", stored)
    shutil.copytree(stored, run / "tables")
    monkeypatch.setattr(templates, "ROOT", tmp_path)
    publish.publish(run, "mismatch")
    origin = json.loads((stored / "origin.json").read_text(encoding="utf-8"))
    assert origin["commit"]
    (run / "tables/mismatch_shifts.csv").unlink()
    with pytest.raises(InputError, match=r"not complete, mismatch_shifts\.csv lacks"):
        publish.publish(run, "mismatch")
    assert (stored / "mismatch_shifts.csv").is_file()


def test_a_stored_experiment_names_the_origin_of_its_joints(tmp_path, monkeypatch):
    """They are in a file a job, in a folder of the results."""
    run = tmp_path / "mismatch"
    shutil.copytree(ROOT / "studies/mismatch/published/mismatch", run / "tables")
    keys = merged(merged_study(), {"study": {"name": "mismatch", "root_seed": 7}})
    about = provenance(keys) | {"provenance_commit": "0123456789ab"}
    (run / "mismatch").mkdir()
    write_netcdf(xr.Dataset(attrs=about), run / "mismatch/slate.nc")
    monkeypatch.setattr(templates, "ROOT", tmp_path)
    stored = publish.publish(run, "mismatch", "mismatch.csv")
    origin = json.loads((stored / "origin.json").read_text(encoding="utf-8"))
    assert (origin["commit"], origin["root_seed"]) == ("0123456789ab", 7)
    assert origin["configuration"]["differs"]["study.root_seed"] == 7


@pytest.mark.slow
def test_the_readmes_command_prints_the_closures_that_the_readme_states(tmp_path, capsys):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    command = re.search(r"jointclosure (close [^\n]+)", text).group(1)
    assert cli.main([*shlex.split(command), "--output", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    ranges = r"0\.\d+ \(0\.\d+ to 0\.\d+\)"
    line, _ = re.findall(r"^net closure since seating \(mm\).*", printed, re.M)  # of both ranges
    assert re.findall(ranges, line) == re.findall(f"({ranges}) mm on the", text)


def test_the_readme_names_the_command_by_which_the_check_runs_the_tests():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    check = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert "make test" in check
    assert "`make test`" in readme


def test_logs_that_pages_name_are_those_of_the_rules():
    folders = {
        name.split("/")[0]
        for path in ROOT.glob("docs/*.md")
        for name in re.findall(r"logs/([\w<>]+/?)", path.read_text(encoding="utf-8"))
    }
    rules = "".join(path.read_text("utf-8") for path in ROOT.glob("workflow/rules/*.smk"))
    assert "choose_effects" in folders
    assert {name for name in folders if f"/logs/{name}" not in rules} == set()


def test_names_in_contributing_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w./]*\w[\w./]*)`", re.sub(r"```.*?```", "", text, flags=re.S)))
    command = ["git", "ls-files", "--cached"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    listed = done.stdout.split()
    sources = [ROOT / name for name in listed if re.search(r"(\.py|\.smk|\.yaml|file)$", name)]
    words = set(re.findall(r"\w+", "\n".join(path.read_text("utf-8") for path in sources)))
    places = "/" + "\n/".join(listed)
    missing = {
        name
        for name in named
        if f"/{name.strip('/')}" not in places and not set(re.findall(r"\w+", name)) <= words
    }
    assert missing == set()
