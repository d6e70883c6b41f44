"""`make` and `snakemake` do the same with what a user states, which is data to both."""

import fcntl
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from jointclosure.storage.files import read_csv
from tests.workflow.runs import (
    NEEDED,
    ROOT,
    STAMP,
    answer,
    changed,
    checkout,
    planned,
    run_snakemake,
    snakemake,
    state_of,
)


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return checkout(tmp_path_factory.mktemp("make") / "project")


def make(folder: Path, *words: str, **settings) -> subprocess.CompletedProcess:
    return answer(["make", "-o", STAMP, *words], folder, **settings)


@pytest.fixture
def new(tmp_path):
    """A folder with a line break in its name, which has no environment."""
    folder = tmp_path / "a\nb"
    folder.mkdir()
    for name in NEEDED:
        shutil.copy(ROOT / name, folder)
    return folder


def test_set_up_is_refused_where_it_would_harm_or_fail(new, tmp_path):
    refused = answer(["make", "setup"], new)
    assert "line break" in refused.stderr
    assert not (new / ".venv").exists()
    folder, other = new.rename(tmp_path / "new"), tmp_path / "other"
    for name in ("`touch X`", "$(shell touch X)"):
        refused = answer(["make", "setup", f"PYTHON={name}"], folder)
        assert f"{name} is not installed" in refused.stdout
        assert not (folder / "X").exists()
    other.mkdir()
    (other / "kept").touch()
    (folder / ".venv").symlink_to(other)
    refused = answer(["make", "setup"], folder)
    assert refused.returncode != 0
    assert ".venv is a link" in refused.stdout
    assert (other / "kept").exists()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("CONFIG", "`touch X`.yaml"),
        ("CONFIG", "$(shell touch X)"),
        ("CONFIG", "-n"),
        ("PROFILE", "$(shell touch X)"),
        ("PROFILE", "-n"),
        ("CORES", "a;touch X"),
        ("CORES", "--unlock"),
        ("CORES", "-n"),
    ],
)
def test_what_make_gets_is_neither_a_command_nor_an_option(project, key, value):
    refused = make(project, "study", f"{key}={value}")
    assert refused.returncode != 0
    assert f"{value}: " in refused.stderr
    assert not list(project.rglob("X*"))
    assert not (project / "results").exists()


def test_a_variable_that_make_does_not_have_is_refused(project):
    refused = make(project, "study", "CONFIGURATION=tiny.yaml")
    assert refused.returncode != 0
    assert "CONFIGURATION: not a variable of this Makefile" in refused.stderr


def outputs_in(summary: str) -> list[str]:
    """Files, their rules and what is planned for them, in what `--summary` prints."""
    return sorted(line for line in summary.splitlines() if line.startswith("results/"))


def test_make_and_snakemake_plan_the_same_files_by_the_same_rules(project):
    """Make has no option to look: a profile has it. The configuration's name has odd signs."""
    keys = yaml.safe_load((ROOT / "profiles/default/config.yaml").read_text())
    (project / "look at it").mkdir()
    (project / "look at it/config.yaml").write_text(yaml.safe_dump(keys | {"summary": True}))
    name = "a $b `c` \"d\" 'e'.yaml"
    shutil.copy(project / "tiny.yaml", project / name)
    made = make(project, "study", f"CONFIG={name}", "PROFILE=look at it", "CORES=1")
    assert made.returncode == 0, made.stderr
    listed = outputs_in(made.stdout)
    assert len([line for line in listed if "close_joints" in line]) == 12
    assert listed == outputs_in(snakemake(project, "--summary"))
    assert not (project / "results").exists()


WRONG = [("grid.cells_x", 2), ("study.colour", "red"), ("rocks.slate.jrc", "high")]


@pytest.mark.parametrize("program", ["snakemake", "make"])
def test_a_wrong_configuration_is_refused_in_one_line_a_key(project, program):
    name = changed(project, "wrong.yaml", *WRONG)
    by_make = program == "make"
    refused = (
        make(project, "study", f"CONFIG={name}") if by_make else run_snakemake(project, config=name)
    )
    assert refused.returncode != 0
    lines = (refused.stdout + refused.stderr).splitlines()
    for place, value in WRONG:
        (named,) = [line for line in lines if place in line and str(value) in line]
        assert re.match(rf"  wrong.yaml, line \d+: {place} = ", named)
    assert not [line for line in lines if ".smk" in line]
    assert not [line for line in lines if line.startswith(("Traceback", "rule "))]
    assert not (project / "results").exists()


def test_a_file_that_is_no_yaml_is_refused_in_a_line(project):
    (project / "broken.yaml").write_text("study: {name: broken\n")
    for refused in (
        run_snakemake(project, config="broken.yaml"),
        make(project, "study", "CONFIG=broken.yaml"),
    ):
        assert refused.returncode != 0
        printed = refused.stdout + refused.stderr
        assert "YAML" in printed
        assert "Traceback" not in printed


def test_the_name_of_a_folder_may_have_any_sign_of_a_shell(project, tmp_path):
    folder = tmp_path / "a'b \"c $d `e` & (f)\n*;"
    kept = shutil.ignore_patterns(".snakemake", "results")
    shutil.copytree(project, folder, symlinks=True, ignore=kept)
    table = "results/tiny/tables/configuration.json"
    snakemake(folder, "--", table, python=str(folder / ".venv/bin/python"))
    assert (folder / table).is_file()


@pytest.fixture
def at_work(project):
    """The lock of a study that is at work, as another process holds it."""
    results = project / "results/tiny"
    results.mkdir(parents=True)
    with open(results / ".lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield project
    shutil.rmtree(project / "results")


def test_a_second_run_of_a_study_is_refused(at_work):
    before = state_of(at_work)
    refused = run_snakemake(at_work)
    assert refused.returncode != 0
    printed = refused.stdout + refused.stderr
    assert "another run of the study tiny is at work here" in printed
    assert "Traceback" not in printed
    assert ".smk" not in printed
    assert "--unlock" not in printed
    assert state_of(at_work) == before


def test_a_study_that_is_at_work_may_be_looked_at(at_work):
    before = state_of(at_work)
    assert planned(at_work)["close_joints"] == 12
    assert state_of(at_work) == before


def test_another_study_runs_beside_one_that_is_at_work(at_work):
    table = "results/smallest/tables/configuration.json"
    snakemake(at_work, "--", table, config="smallest.yaml")
    assert (at_work / table).is_file()


@pytest.mark.slow
@pytest.mark.parametrize(
    "shown",
    [
        r"^\d+ of 40 jobs are done, about .* left$",
        r"^slate: mean net closure since seating .* mm on cycle 1",
        "Results are in results/tiny/",
    ],
    ids=["progress", "closures", "place of results"],
)
def test_a_run_shows_what_a_user_waits_for(study, shown):
    assert re.search(shown, (study / "printed.txt").read_text(), re.M)


@pytest.mark.slow
def test_make_does_nothing_for_a_finished_study(study):
    done = make(study, "study", "CONFIG=tiny.yaml")
    assert (done.returncode, "Nothing to be done" in done.stdout + done.stderr) == (0, True)


ONE_CASE = """study: {name: NAME, rocks: [slate], pool: null, REQUEST}
grid: {cells_x: 12, cells_y: 12}
rocks:
  slate:
    max_normal_stress_MPa: 1
    levels:
      {poisson_ratio: null, youngs_modulus_GPa: null, compressive_strength_MPa: null, jrc: null}
statistics: {bootstrap_resamples: 10, repetitions: 100, control_variates: 500}
output: {stress_points: 5}
"""


def request(folder: Path, name: str, asked: str) -> str:
    """Write a study of one case with an accuracy; its file."""
    text = ONE_CASE.replace("NAME", name).replace("REQUEST", f"accuracy: {{{asked}}}")
    (folder / f"{name}.yaml").write_text(text)
    return f"{name}.yaml"


def rounds_of(folder: Path) -> list[dict]:
    """Plans of all rounds of a study whose accuracy was requested."""
    plans = (folder / "results/accurate/accuracy").glob("round_*.json")
    return sorted((json.loads(plan.read_text()) for plan in plans), key=lambda p: p["round"])


def accurate_study(folder: Path) -> str:
    """Write a study with an accuracy to a checkout; its configuration."""
    return request(checkout(folder), "accurate", "within: 0.25, most: 400")


@pytest.fixture(scope="module")
def accurate(tmp_path_factory):
    """Folder and configuration of a study that `make` ended with an accuracy, and its print."""
    folder = tmp_path_factory.mktemp("accurate") / "make"
    config = accurate_study(folder)
    done = make(folder, "study", f"CONFIG={config}")
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, config, done.stdout + done.stderr


@pytest.mark.slow
def test_surfaces_are_added_until_an_accuracy_is_reached(accurate):
    folder, _, printed = accurate
    assert "accuracy: mean within 25 % reached" in printed
    rounds = rounds_of(folder)
    assert rounds[-1]["ended"]
    assert len(rounds) > 2, "no surface was added"
    table = read_csv(folder / "results/accurate/tables/accuracy_reached.csv")
    assert table.met.all()
    assert (table.surfaces == rounds[-1]["cases"]).all()


@pytest.mark.slow
def test_make_and_snakemake_add_the_same_surfaces(accurate, tmp_path):
    folder, config, _ = accurate
    direct = tmp_path / "direct"
    accurate_study(direct)
    snakemake(direct, config=config)
    assert rounds_of(direct) == rounds_of(folder)
    assert planned(direct, config=config) == planned(folder, config=config) == {}


@pytest.mark.slow
def test_an_accuracy_that_its_budget_cannot_pay_is_refused(project):
    config = request(project, "little", "within: 0.01, budget_core_minutes: 1.0e-6")
    for refused in (
        make(project, "study", f"CONFIG={config}"),
        run_snakemake(project, config=config),
    ):
        assert refused.returncode != 0
        assert "must be at least" in refused.stdout + refused.stderr
