"""`make`: what a user tells it is data, and what it says is what matters."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jointclosure.storage.files import read_csv
from tests.workflow.runs import NEEDED, ROOT, STAMP, answer, checkout, snakemake


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
    ("key", "name"),
    [("CONFIG", "`touch X`.yaml"), ("PROFILE", "$(shell touch X)"), ("CORES", "a;touch X")],
)
def test_what_make_gets_is_never_run(project, key, name):
    refused = make(project, "study", f"{key}={name}")
    assert refused.returncode != 0
    assert f"{key}={name}: " in refused.stderr
    assert not list(project.rglob("X*"))


FAKE = """import sys, time
print("jointclosure: about 2 core-hours", flush=True)
for number in (1, 2, 3):
    print(f"Finished jobid: {number} (Rule: close)", flush=True)
    print(f"{number} of 3 steps (33%) done", flush=True)
"""
FAILED = "close failed: InputError: grid.cells_x = 2; its log is job.log"
FAILS = f"{FAKE}print('jointclosure: {FAILED}', flush=True); sys.exit(7)"
SILENT = f"{FAKE}print('returned non-zero exit status 137.'); sys.exit(7)"
KILLED = f"{FAKE}import os; os.kill(os.getpid(), 9)"
WAITS = f"{FAKE}time.sleep(600)"
FOLLOW = """import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from following import follow
from process_group import EndRequest
with open('run.log', 'a') as stream:
    command = [sys.executable, '-c', sys.argv[2]]
    sys.exit(follow(command, stream, Path('run.log'), EndRequest()))
"""


def follow(folder: Path, program: str) -> subprocess.Popen:
    """The runner over a program that speaks as Snakemake does."""
    (folder / "run.log").write_text("")
    command = [sys.executable, "-c", FOLLOW, str(ROOT / "workflow/scripts"), program]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, cwd=folder, start_new_session=True, **pipes)


@pytest.fixture
def waiting(tmp_path):
    """A run whose program has done its steps, and waits."""

    def started(program: str = WAITS) -> subprocess.Popen:
        run = follow(tmp_path, program)
        while "3 of 3 steps" not in run.stdout.readline():
            assert run.poll() is None
        return run

    return started


@pytest.mark.parametrize(
    ("program", "status", "words"),
    [
        (FAKE, 0, ()),
        (FAILS, 7, (FAILED, "run.log")),
        (SILENT, 7, ("out of memory", "CORES=1")),
        (KILLED, 128 + 9, ("out of memory", "CORES=1")),
    ],
    ids=["done", "failed", "job killed", "snakemake killed"],
)
def test_a_run_shows_how_far_it_is_and_why_it_failed_and_keeps_the_status(
    tmp_path, program, status, words
):
    run = follow(tmp_path, program)
    printed, wrong = run.communicate()
    assert run.returncode == status, wrong
    assert all(word in wrong for word in words)
    assert {"about 2 core-hours", "3 of 3 steps (33%) done"} <= set(printed.splitlines())
    assert "Finished jobid" not in printed
    assert "Finished jobid: 3" in (tmp_path / "run.log").read_text()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_asked_to_end_says_how_it_goes_on(waiting, number):
    run = waiting()
    os.killpg(run.pid, number)
    printed, wrong = run.communicate()
    assert run.returncode == 128 + number
    assert "the same command goes on from there" in printed
    assert "Traceback" not in wrong


def test_a_second_request_kills_what_heeds_no_interrupt(waiting):
    run = waiting("import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n" + WAITS)
    os.kill(run.pid, signal.SIGINT)
    time.sleep(1.5)
    assert run.poll() is None  # within its grace period
    os.kill(run.pid, signal.SIGINT)
    run.communicate(timeout=5)
    assert run.returncode == 128 + signal.SIGINT


@pytest.mark.parametrize(
    ("limit", "most", "printed"),
    [
        (resource.RLIMIT_NOFILE, 20, "ulimit -n = 20: must be at least"),
        (resource.RLIMIT_FSIZE, 20_000, "make_study.log: could not be written"),  # as a full disk
    ],
    ids=["open files", "room"],
)
def test_a_run_without_open_files_or_room_is_refused_in_a_line(project, limit, most, printed):
    limited = {"preexec_fn": lambda: resource.setrlimit(limit, (most, most))}
    done = make(project, "study", "CONFIG=tiny.yaml", **limited)
    assert done.returncode != 0
    first, last = done.stderr.splitlines()
    assert (printed in first, "Error" in last) == (True, True)


def test_the_name_of_a_folder_may_have_any_sign_of_a_shell(project, tmp_path):
    folder = tmp_path / "a'b \"c $d `e` & (f)\n*;"
    shutil.copytree(project, folder, symlinks=True, ignore=shutil.ignore_patterns(".snakemake"))
    table = "results/tiny/tables/configuration.json"
    snakemake(folder, "--", table, python=str(folder / ".venv/bin/python"))
    assert (folder / table).is_file()


ONE_CASE = """study: {name: NAME, rocks: [slate], pool: null, REQUEST}
grid: {cells_x: 12, cells_y: 12}
rocks:
  slate:
    max_normal_stress_MPa: 1
    levels: {poisson_ratio: null, youngs_modulus_GPa: null, jrc: null}
statistics: {bootstrap_resamples: 10, repetitions: 100, control_variates: 500}
output: {stress_points: 5}
"""


def request(project: Path, name: str, asked: str) -> subprocess.CompletedProcess:
    text = ONE_CASE.replace("NAME", name).replace("REQUEST", f"accuracy: {{{asked}}}")
    (project / f"{name}.yaml").write_text(text)
    return make(project, "study", f"CONFIG={name}.yaml")


@pytest.mark.slow
def test_a_study_adds_surfaces_until_its_accuracy_is_reached(project):
    done = request(project, "accurate", "within: 0.25, most: 400")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "accuracy: continues with 20 surfaces" in done.stdout
    assert "accuracy: mean within 25 % reached" in done.stdout
    table = read_csv(project / "results/accurate/tables/accuracy_reached.csv")
    assert table.met.all()
    assert (table.surfaces >= 20).all()
    again = make(project, "study", "CONFIG=accurate.yaml")
    assert "nothing was left to do" in again.stdout
    refused = request(project, "little", "within: 0.01, budget_core_minutes: 1.0e-6")
    assert refused.returncode != 0
    assert "must be at least" in refused.stderr
