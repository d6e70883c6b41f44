"""Killed jobs, killed runs and files that are not what they should be: nothing is lost, or wrong.

`JOINTCLOSURE_KILLS=20 pytest -m slow tests/workflow/test_nothing_lost.py` kills twenty times.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from tests.engine.test_forks import processes_in
from tests.workflow.test_pipeline import ROOT, checkout, snakemake, studies_command

KILLS = int(os.environ.get("JOINTCLOSURE_KILLS", "3"))
STAMP = ".venv/jointclosure-is-set-up"

pytestmark = pytest.mark.slow


def project(folder: Path) -> Path:
    """A checkout with its Makefile and the environment of these tests."""
    checkout(folder)
    shutil.copy(ROOT / "Makefile", folder)
    (folder / ".venv").symlink_to(sys.prefix)
    return folder


def make_study(folder: Path) -> subprocess.Popen:
    """Start `make study`, in a session of its own, with its output in a file."""
    command = ["make", "-o", STAMP, "study", "CONFIG=tiny.yaml", "CORES=2"]
    with open(folder / "output.txt", "a") as output:
        return subprocess.Popen(
            command, cwd=folder, stdout=output, stderr=output, start_new_session=True
        )


def finished(folder: Path) -> None:
    process = make_study(folder)
    assert process.wait() == 0, (folder / "output.txt").read_text()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A finished study."""
    folder = project(tmp_path_factory.mktemp("undisturbed"))
    finished(folder)
    return folder


def files_in(folder: Path) -> int:
    return sum(path.is_file() for path in (folder / "results").rglob("*"))


def assert_same(folder: Path, other: Path) -> None:
    found = studies_command("compare", "--exact", folder / "results/tiny", other / "results/tiny")
    assert found.returncode == 0, found.stdout + found.stderr
    tables = sorted(path.name for path in (other / "results/tiny/tables").iterdir())
    assert tables == sorted(path.name for path in (folder / "results/tiny/tables").iterdir())
    for name in tables:
        one, two = (where / "results/tiny/tables" / name for where in (folder, other))
        assert one.read_bytes() == two.read_bytes(), name


def processes_of(run: subprocess.Popen) -> tuple[list, list]:
    """Snakemake itself, and the jobs under it."""
    try:
        below = psutil.Process(run.pid).children(recursive=True)
        engines = [p for p in below if "snakemake" in p.cmdline()]
        jobs = [p for p in below if any(".snakemake/scripts" in word for word in p.cmdline())]
    except psutil.NoSuchProcess:
        return [], []
    return engines, jobs


@pytest.mark.parametrize("number", range(KILLS))
def test_a_kill_at_any_moment_loses_nothing(undisturbed, tmp_path, number):
    """Moments are drawn as a number of files written: how busy the machine is does not count."""
    folder = project(tmp_path)
    chance = random.Random(number)
    moment = chance.randrange(int(0.95 * files_in(undisturbed)))
    run = make_study(folder)
    victims = []
    while not victims or files_in(folder) < moment:
        assert run.poll() is None, "the run ended before it was killed"
        time.sleep(chance.uniform(0.0, 0.1))
        engines, jobs = processes_of(run)
        victims = (jobs, engines, [psutil.Process(run.pid)])[number % 3]
    if number % 3 == 2:
        os.killpg(run.pid, signal.SIGKILL)  # make with all that is in its group
    else:
        chance.choice(victims).kill()
    run.wait()
    finished(folder)
    assert processes_in(folder) == []
    assert_same(folder, undisturbed)
    litter = [path for path in (folder / "results").rglob(".*") if path.is_file()]
    assert litter == []


@pytest.fixture
def copied(undisturbed, tmp_path):
    folder = tmp_path / "copied"
    shutil.copytree(undisturbed, folder, symlinks=True)
    return folder


CASE = "results/tiny/cases/slate-jrc-level_1.0.nc"


def flip_a_bit(folder: Path) -> None:
    data = bytearray((folder / CASE).read_bytes())
    data[random.Random(1).randrange(len(data))] ^= 4
    (folder / CASE).write_bytes(data)


def truncate(folder: Path) -> None:
    (folder / CASE).write_bytes((folder / CASE).read_bytes()[:-1000])


def take_another_case(folder: Path) -> None:
    shutil.copy(folder / "results/tiny/cases/slate-jrc-level_3.0.nc", folder / CASE)


@pytest.mark.parametrize("spoil", [flip_a_bit, truncate, take_another_case])
def test_a_case_file_that_is_not_its_own_is_made_anew(undisturbed, copied, spoil):
    spoil(copied)
    (copied / "results/tiny/study.nc").unlink()
    finished(copied)
    assert (
        "1 files are of other settings or code, or damaged" in (copied / "output.txt").read_text()
    )
    assert_same(copied, undisturbed)


def test_a_results_folder_that_is_read_only_is_said(tmp_path):
    folder = project(tmp_path)
    (folder / "results").mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "ro,size=64k", "tmpfs", str(folder / "results")]
    if not shutil.which("mount") or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        answer = snakemake(folder)
    finally:
        subprocess.run(["umount", "--lazy", str(folder / "results")], check=True)
    assert answer.returncode != 0
    assert "Read-only file system" in answer.stderr
    assert "results/tiny" in answer.stderr


def test_a_disk_that_fills_up_is_said_and_the_next_run_finishes(undisturbed, tmp_path):
    folder = project(tmp_path)
    (folder / "results").mkdir()
    disk = str(folder / "results")
    command = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", disk]
    if not shutil.which("mount") or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        answer = snakemake(folder)
        assert answer.returncode != 0
        assert "No space left on device" in answer.stderr or "MB are free there" in answer.stderr
        subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
        finished(folder)
        assert_same(folder, undisturbed)
    finally:
        subprocess.run(["umount", "--lazy", disk], check=True)


def test_any_realisation_is_repeated_by_one_command(copied):
    results = copied / "results/tiny"
    again = studies_command("repeat", results, "slate-jrc-level_1", 2)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "identical to the stored results" in again.stdout
    for file in (results / "cases").iterdir():
        file.unlink()  # as where the job failed: the log is enough
    again = studies_command("repeat", results, "slate-jrc-level_1", 2)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "no stored results to compare with" in again.stdout
    missing = studies_command("repeat", results, "slate-jrc-level_1", 3)
    assert missing.returncode == 2
    assert "has no realisation 3" in missing.stderr
