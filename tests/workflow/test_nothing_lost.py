"""Runs and jobs that are ended or killed, and files that are not what they should be: all is made.

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
from tests.workflow import runs

RESULTS = "results/tiny"
STUDY = ["make", "-o", runs.STAMP, "study", "CONFIG=tiny.yaml", "CORES=2"]
HEEDED = "import os, signal, sys; signal.signal(2, signal.SIG_DFL); os.execvp('make', sys.argv[1:])"
SECONDS = 30.0
"""Within which all must have ended."""
STRIKES = [
    (signal.SIGKILL, "jobs", 1), (signal.SIGKILL, "snakemake", 1), (signal.SIGKILL, "group", 1),
    (signal.SIGTERM, "make", 1), (signal.SIGINT, "make", 2),
    (signal.SIGTERM, "group", 2), (signal.SIGINT, "group", 1),
]  # fmt: skip
"""Signals, to whom, and how often; make's group is signalled by a terminal and by `timeout`."""
KILLS = int(os.environ.get("JOINTCLOSURE_KILLS", f"{len(STRIKES)}"))

pytestmark = pytest.mark.slow


def started(folder: Path, command: list[str]) -> subprocess.Popen:
    """`make` in a session of its own, with interrupts heeded as from a terminal."""
    with open(folder / "output.txt", "w") as output:
        about = {"stdout": output, "stderr": output, "start_new_session": True}
        return subprocess.Popen([sys.executable, "-c", HEEDED, *command], cwd=folder, **about)


def strike(run: subprocess.Popen, number: int, whom: str) -> bool:
    """Send a signal; whether there was somebody to send it to."""
    try:
        if whom in ("make", "group"):
            (os.killpg if whom == "group" else os.kill)(run.pid, number)
            return True
        words = {"jobs": ".snakemake/scripts", "snakemake": "-m snakemake"}[whom]
        below = psutil.Process(run.pid).children(recursive=True)
        victims = [process for process in below if words in " ".join(process.cmdline())]
        for victim in victims[:1]:
            victim.send_signal(number)
        return bool(victims)
    except (psutil.NoSuchProcess, ProcessLookupError):
        return False


def wait_for_the_end(folder: Path, run: subprocess.Popen) -> str:
    """Wait until nothing works in a folder; what was printed."""
    start = time.monotonic()
    while run.poll() is None or processes_in(folder):
        working = [process.cmdline() for process in processes_in(folder)]
        assert time.monotonic() - start < SECONDS, working
        time.sleep(0.1)
    return (folder / "output.txt").read_text()


def files_in(folder: Path) -> int:
    return sum(path.is_file() for path in (folder / "results").rglob("*"))


def finished(folder: Path) -> str:
    done = runs.answer(STUDY, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("number", range(KILLS))
def test_a_run_that_is_ended_or_killed_at_any_moment_loses_nothing(study, tmp_path, number):
    """Moments are drawn as a number of files written: how busy the machine is does not count."""
    folder, chance = runs.checkout(tmp_path / "killed"), random.Random(number)
    signal_number, whom, times = STRIKES[number % len(STRIKES)]
    moment = chance.randrange(int(0.95 * files_in(study)))
    run = started(folder, STUDY)
    time.sleep(chance.uniform(0.0, 5.0))  # of the start and the plan
    while files_in(folder) < moment or not strike(run, signal_number, whom):
        assert run.poll() is None, "the run ended before it was killed"
        time.sleep(chance.uniform(0.0, 0.1))
    for _ in range(times - 1):
        time.sleep(chance.choice([0.0, 0.01, 0.5, 2.0]))
        strike(run, signal_number, whom)
    if whom in ("make", "group"):
        printed = wait_for_the_end(folder, run)
        assert "Traceback" not in printed
        ended = ("the same command goes on from there", "Results are in")
        assert signal_number == signal.SIGKILL or any(words in printed for words in ended)
    run.wait()
    finished(folder)
    assert processes_in(folder) == []
    runs.assert_same(folder / RESULTS, study / RESULTS)
    assert [path for path in (folder / "results").rglob(".*") if path.is_file()] == []


@pytest.mark.parametrize("whom", ["make", "group"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_set_up_that_is_ended_leaves_no_process_and_no_environment_that_counts(
    tmp_path, number, whom
):
    for name in (*runs.NEEDED, "workflow/scripts/process_group.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(runs.ROOT / name, tmp_path / name)
    run = started(tmp_path, ["make", "setup"])
    time.sleep(random.Random(number).uniform(0.5, 10.0))
    strike(run, number, whom)
    wait_for_the_end(tmp_path, run)
    assert run.returncode != 0
    assert not (tmp_path / runs.STAMP).exists()


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
    refused = runs.studies_command("report", mine, "--output", copied / "page.html")
    assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    assert not (copied / "page.html").exists()
    printed = finished(copied)
    assert "3 files are of other settings or code, or damaged" in printed
    assert (
        "results/tiny/study.nc: the file is not as jointclosure wrote it"
        in (mine / "logs/make_study.log").read_text()
    )
    runs.assert_same(mine, intact, "figures")
    assert runs.planned(copied) == {}


def test_any_realisation_is_repeated_by_one_command(copied):
    results = copied / RESULTS
    again = runs.studies_command("repeat", results, "slate-jrc-level_1", 2)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "identical to the stored results" in again.stdout
    for file in (results / "cases").iterdir():
        file.unlink()  # as where the job failed: the log is enough
    again = runs.studies_command("repeat", results, "slate-jrc-level_1", 2)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "no stored results to compare with" in again.stdout
    missing = runs.studies_command("repeat", results, "slate-jrc-level_1", 3)
    assert missing.returncode == 2
    assert "has no realisation 3" in missing.stderr
