"""Killed jobs, killed runs and files that are not what they should be: nothing is lost, or wrong.

`JOINTCLOSURE_KILLS=20 pytest -m slow tests/workflow/test_nothing_lost.py` kills twenty times.
"""

import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import psutil
import pytest

from tests.engine.test_forks import processes_in
from tests.workflow.runs import STAMP, answer, assert_same, checkout, planned, studies_command

KILLS = int(os.environ.get("JOINTCLOSURE_KILLS", "3"))
RESULTS = "results/tiny"
STUDY = ["make", "-o", STAMP, "study", "CONFIG=tiny.yaml", "CORES=2"]

pytestmark = pytest.mark.slow


def files_in(folder: Path) -> int:
    return sum(path.is_file() for path in (folder / "results").rglob("*"))


def processes_of(run: subprocess.Popen) -> tuple[list, list]:
    """Snakemake itself, and the jobs under it."""
    try:
        below = psutil.Process(run.pid).children(recursive=True)
        engines = [p for p in below if "snakemake" in p.cmdline()]
        jobs = [p for p in below if any(".snakemake/scripts" in word for word in p.cmdline())]
    except psutil.NoSuchProcess:
        return [], []
    return engines, jobs


def finished(folder: Path) -> str:
    done = answer(STUDY, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("number", range(KILLS))
def test_a_kill_at_any_moment_loses_nothing(study, tmp_path, number):
    """Moments are drawn as a number of files written: how busy the machine is does not count."""
    folder = checkout(tmp_path / "killed")
    chance = random.Random(number)
    moment = chance.randrange(int(0.95 * files_in(study)))
    with open(folder / "output.txt", "w") as output:
        run = subprocess.Popen(
            STUDY, cwd=folder, stdout=output, stderr=output, start_new_session=True
        )
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
    assert_same(folder / RESULTS, study / RESULTS)
    assert [path for path in (folder / "results").rglob(".*") if path.is_file()] == []


def case(number: int) -> str:
    return f"cases/slate-jrc-level_{number}.0.nc"


def test_files_that_are_damaged_changed_or_foreign_are_made_again(study, copied):
    mine, intact = copied / RESULTS, study / RESULTS
    data = bytearray((mine / case(1)).read_bytes())
    data[random.Random(1).randrange(len(data))] ^= 4
    (mine / case(1)).write_bytes(data)
    (mine / case(3)).write_bytes((mine / case(3)).read_bytes()[:-1000])
    shutil.copy(mine / case(1), mine / case(4))
    times = (mine / "study.nc").stat()
    shutil.copy(mine / "pool.nc", mine / "study.nc")
    os.utime(mine / "study.nc", ns=(times.st_atime_ns, times.st_mtime_ns))
    claims = mine / "tables/claims.csv"
    claims.write_text(claims.read_text().replace("undecided", "stands"))
    (mine / "tables/table_3_indifference.csv").write_text("")
    shutil.copy2(mine / "figures/wall_pair.png", mine / "figures/fig_5_closure.png")
    (mine / "tables/max_closure.csv").unlink()
    refused = studies_command("report", mine, "--output", copied / "page.html")
    assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    assert not (copied / "page.html").exists()
    printed = finished(copied)
    assert "3 files are of other settings or code, or damaged" in printed
    assert (
        "results/tiny/study.nc: the file is not as jointclosure wrote it"
        in (mine / "logs/make_study.log").read_text()
    )
    assert_same(mine, intact, "figures")
    assert planned(copied) == {}


def test_any_realisation_is_repeated_by_one_command(copied):
    results = copied / RESULTS
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
