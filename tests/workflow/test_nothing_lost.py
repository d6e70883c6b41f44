"""No result is lost or wrong, whatever ends a run or spoils a file.

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

from tests.processes import processes_in
from tests.workflow import runs

RESULTS = "results/tiny"
HEEDED = (
    "import os, signal, sys; signal.signal(2, signal.SIG_DFL); os.execvp(sys.argv[1], sys.argv[1:])"
)
SECONDS = {signal.SIGKILL: 15.0, signal.SIGTERM: 30.0, signal.SIGINT: 30.0}
"""Within which all must have ended, on a machine that others use too."""
STRIKES = [
    (signal.SIGKILL, "make", 1), (signal.SIGTERM, "make", 1), (signal.SIGINT, "group", 1),
    (signal.SIGKILL, "group", 1), (signal.SIGTERM, "group", 1), (signal.SIGINT, "group", 2),
    (signal.SIGKILL, "snakemake", 1), (signal.SIGTERM, "make", 2), (signal.SIGKILL, "a job", 1),
    (signal.SIGTERM, "group", 2),
]  # fmt: skip
"""Signals, to whom, and how often; make's group is signalled by a terminal and by `timeout`."""
KILLS = int(os.environ.get("JOINTCLOSURE_KILLS", f"{len(STRIKES)}"))


def make(config: str = "smallest.yaml") -> list[str]:
    return ["make", "-o", runs.STAMP, "study", f"CONFIG={config}", "CORES=2"]


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
        words = {"a job": ".snakemake/scripts", "snakemake": "bin/snakemake"}[whom]
        below = psutil.Process(run.pid).children(recursive=True)
        victims = [process for process in below if words in " ".join(process.cmdline())]
        for victim in victims[-1:]:  # `timeout` has the words of Snakemake too, and precedes it
            victim.send_signal(number)
        return bool(victims)
    except (psutil.NoSuchProcess, ProcessLookupError):
        return False


def wait_for_the_end(folder: Path, run: subprocess.Popen, seconds: float) -> str:
    """Wait until nothing works in a folder; what was printed."""
    deadline = time.monotonic() + seconds
    while run.poll() is None or processes_in(folder):
        assert time.monotonic() < deadline, processes_in(folder)
        time.sleep(0.1)
    return (folder / "output.txt").read_text()


PROGRAM = """#!{python}
import pathlib, signal, subprocess, time
{before}
subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "sleep", "600"])
pathlib.Path("ready").touch()
time.sleep(600)
"""
HEEDLESS = "for number in (2, 15): signal.signal(number, signal.SIG_IGN)"


def made_to_wait(folder: Path, before: str = "") -> None:
    """A folder whose program in the place of Snakemake starts a job, and waits."""
    for name in ("Makefile", "tiny.yaml"):
        shutil.copy(runs.ROOT / name if name == "Makefile" else runs.HERE / name, folder)
    program = folder / ".venv/bin/snakemake"
    program.parent.mkdir(parents=True)
    program.write_text(PROGRAM.format(python=sys.executable, before=before))
    checker = program.with_name("python")  # which make asks whether the configuration is plain
    checker.write_text("#!/bin/sh\nexit 0\n")
    for file in (program, checker):
        file.chmod(0o755)


def waiting_make(folder: Path, before: str) -> subprocess.Popen:
    """`make` whose program in the place of Snakemake has started a job, and waits."""
    made_to_wait(folder, before)
    run = started(folder, make("tiny.yaml"))
    while not (folder / "ready").exists():
        assert run.poll() is None, (folder / "output.txt").read_text()
        time.sleep(0.05)
    # make, timeout, the program, and its job
    assert len(processes_in(folder)) == 4
    return run


needs_linux = pytest.mark.skipif(not shutil.which("setpriv"), reason="no setpriv, thus no Linux")


@needs_linux
@pytest.mark.parametrize("whom", ["make", "group", "snakemake"])
def test_nothing_is_left_of_a_make_that_is_killed(tmp_path, whom):
    run = waiting_make(tmp_path, HEEDLESS)
    assert strike(run, signal.SIGKILL, whom)
    wait_for_the_end(tmp_path, run, SECONDS[signal.SIGKILL])
    assert run.returncode != 0


@needs_linux
@pytest.mark.parametrize("before", ["", HEEDLESS], ids=["heeded", "not heeded"])
@pytest.mark.parametrize(
    ("number", "whom"),
    [(signal.SIGTERM, "make"), (signal.SIGTERM, "group"), (signal.SIGINT, "group")],
)
def test_a_make_that_is_asked_to_end_ends_with_all_below_it(tmp_path, number, whom, before):
    """What heeds no signal is killed 15 seconds later."""
    run = waiting_make(tmp_path, before)
    assert strike(run, number, whom)
    wait_for_the_end(tmp_path, run, SECONDS[number])
    assert run.returncode != 0


SLOW_SETPRIV = """#!/bin/sh
case "$*" in *{word}*) echo $PPID >> reached; sleep 2;; esac
exec {setpriv} "$@"
"""


@pytest.fixture
def slow_setpriv(tmp_path, monkeypatch):
    """A function that slows down how the kernel is asked to end what has a word in its command."""

    def slow_down(word: str) -> None:
        program = tmp_path / "slow/setpriv"
        program.parent.mkdir()
        program.write_text(SLOW_SETPRIV.format(word=word, setpriv=shutil.which("setpriv")))
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")

    return slow_down


def who_asks(folder: Path, run: subprocess.Popen, number: int) -> int:
    """Wait for the process that starts the slow one of a number; its number."""
    reached = folder / "reached"
    while not reached.exists() or len(starters := reached.read_text().split()) < number:
        assert run.poll() is None
        time.sleep(0.05)
    return int(starters[-1])


@needs_linux
@pytest.mark.parametrize("number", [1, 2], ids=["make", "timeout"])
def test_nothing_starts_whose_starter_was_killed_before_it(tmp_path, slow_setpriv, number):
    """`make` starts a shell, which is replaced by `timeout`, which starts Snakemake."""
    made_to_wait(tmp_path)
    slow_setpriv("bin/snakemake")
    run = started(tmp_path, make("tiny.yaml"))
    os.kill(who_asks(tmp_path, run, number), signal.SIGKILL)
    wait_for_the_end(tmp_path, run, SECONDS[signal.SIGTERM])
    assert not (tmp_path / "ready").exists()


@needs_linux
def test_a_job_does_not_start_where_snakemake_has_ended_before_it(tmp_path, slow_setpriv):
    folder = runs.checkout(tmp_path / "early")
    slow_setpriv("state_configuration")
    table = folder / RESULTS / "tables/configuration.json"
    words = ["-m", "snakemake", str(table.relative_to(folder)), "--configfile", "tiny.yaml"]
    run = started(folder, [sys.executable, *words])
    os.kill(who_asks(folder, run, 1), signal.SIGKILL)
    wait_for_the_end(folder, run, SECONDS[signal.SIGTERM])
    assert not table.exists()


def files_in(folder: Path) -> int:
    return sum(path.is_file() for path in (folder / "results").rglob("*"))


def finished(folder: Path, config: str = "smallest.yaml") -> str:
    done = runs.answer(make(config), folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("number", range(KILLS))
def test_a_run_that_is_ended_or_killed_at_any_moment_loses_nothing(smallest, tmp_path, number):
    """Moments are drawn as a number of files written: how busy the machine is does not count."""
    folder, chance = runs.checkout(tmp_path / "killed"), random.Random(number)
    signal_number, whom, times = STRIKES[number % len(STRIKES)]
    moment = chance.randrange(int(0.9 * files_in(smallest)))
    run = started(folder, make())
    time.sleep(chance.uniform(0.0, 5.0))  # of the start and the plan
    while files_in(folder) < moment or not strike(run, signal_number, whom):
        assert run.poll() is None, "the run ended before it was struck"
        time.sleep(chance.uniform(0.0, 0.1))
    for _ in range(times - 1):
        time.sleep(chance.choice([0.0, 0.01, 0.5, 2.0]))
        strike(run, signal_number, whom)
    if whom != "a job":
        wait_for_the_end(folder, run, SECONDS[signal_number])
    run.wait()
    assert run.returncode != 0
    printed = finished(folder)  # the same command, with nothing unlocked by anybody
    assert "unlock" not in printed
    assert processes_in(folder) == []
    runs.assert_same(folder / "results/smallest", smallest / "results/smallest")
    assert runs.planned(folder, config="smallest.yaml") == {}


@pytest.mark.slow
def test_an_interrupt_of_a_run_is_stated_in_lines_without_a_traceback(tmp_path):
    folder = runs.checkout(tmp_path / "interrupted")
    run = started(folder, make())
    while not list((folder / "results/smallest/logs/close_joints").rglob("*.log")):
        assert run.poll() is None
        time.sleep(0.05)
    strike(run, signal.SIGINT, "group")
    printed = wait_for_the_end(folder, run, SECONDS[signal.SIGINT])
    words = "interrupted. Finished jobs are kept, and the same command continues."
    assert words in printed.splitlines()
    assert "Traceback" not in printed
    assert "failed" not in printed
    assert "did not complete" not in printed


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    """A folder in which a study ran beside another one, a second run of it, and how both ended."""
    folder = runs.checkout(tmp_path_factory.mktemp("beside") / "two")
    text = (folder / "smallest.yaml").read_text()
    (folder / "other.yaml").write_text(text.replace("name: smallest", "name: other"))
    first, other = started(folder, make()), started(folder, make("other.yaml"))
    while not (folder / "results/smallest/logs").exists():
        assert first.poll() is None
        time.sleep(0.1)
    second = runs.answer(make(), folder)
    at_work = "close_joints" in runs.planned(folder, config="other.yaml") or other.poll() == 0
    return folder, second, at_work, (first.wait(), other.wait())


@pytest.mark.slow
def test_of_two_runs_of_a_study_one_is_refused(beside):
    _, refused, _, _ = beside
    assert refused.returncode != 0
    assert "another run of the study smallest is at work here" in refused.stdout + refused.stderr


@pytest.mark.slow
def test_another_study_runs_beside(beside, smallest):
    folder, _, at_work, ended = beside
    assert at_work
    assert ended == (0, 0), (folder / "output.txt").read_text()
    runs.assert_same(folder / "results/smallest", smallest / "results/smallest")


@pytest.mark.slow
@pytest.mark.parametrize("whom", ["make", "group"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_set_up_that_is_ended_leaves_nothing_that_counts(tmp_path, number, whom):
    if (number, whom) == (signal.SIGINT, "make"):
        pytest.skip("make hands an interrupt on to nobody: a terminal signals the group")
    for name in runs.NEEDED:
        shutil.copy(runs.ROOT / name, tmp_path / name)
    run = started(tmp_path, ["make", "setup"])
    time.sleep(random.Random(number).uniform(0.5, 10.0))
    strike(run, number, whom)
    wait_for_the_end(tmp_path, run, SECONDS[number])
    assert run.returncode != 0
    assert not (tmp_path / runs.STAMP).exists()


# Files that are damaged, changed or foreign


CASE, OTHER = "cases/slate-jrc-level_1.0-2.nc", "cases/slate-jrc-level_3.0-2.nc"


def truncated(results: Path, name: str) -> None:
    (results / name).write_bytes((results / name).read_bytes()[:-1000])


def flipped(results: Path, name: str) -> None:
    data = bytearray((results / name).read_bytes())
    data[len(data) // 2] ^= 4
    (results / name).write_bytes(data)


def foreign(results: Path, name: str) -> None:
    """Another whole file of the same kind."""
    shutil.copy(results / {CASE: OTHER, "study.nc": "pool.nc"}[name], results / name)


def emptied(results: Path, name: str) -> None:
    (results / name).write_bytes(b"")


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [truncated, flipped, foreign, emptied])
@pytest.mark.parametrize("name", [CASE, "study.nc"])
@pytest.mark.parametrize("kept", [True, False], ids=["times kept", "new times"])
def test_a_spoilt_dataset_is_an_error_before_any_table_is_made(copied, name, spoil, kept):
    """Snakemake does not see such files where their times are kept: their readers do."""
    results = copied / RESULTS
    before = (results / name).stat()
    spoil(results, name)
    if kept:
        os.utime(results / name, ns=(before.st_atime_ns, before.st_mtime_ns))
    if name == CASE:
        (results / "study.nc").unlink()
    tables = [results / "tables" / f"{table}.csv" for table in ("correlations", "claims")]
    for table in tables:
        table.unlink()
    spoilt = (results / name).read_bytes()
    refused = runs.run_snakemake(copied)
    assert refused.returncode != 0
    lines = (refused.stdout + refused.stderr).splitlines()
    named, remedy = f"{RESULTS}/{name}: ", "delete it"
    if (name, spoil) == (CASE, foreign):  # of two files with the same joints, either may be foreign
        named, remedy = (
            f"{RESULTS}/{OTHER}: has realisation 0 of ",
            f" as {RESULTS}/{CASE} has: delete both",
        )
    found = [line for line in lines if named in line and remedy in line]
    assert found, "\n".join(lines)
    assert not any(table.exists() for table in tables)
    assert (results / name).read_bytes() == spoilt  # no file is taken away


@pytest.mark.slow
def test_a_spoilt_dataset_that_is_deleted_is_made_again_to_the_same_bits(study, copied):
    results = copied / RESULTS
    truncated(results, CASE)
    for name in (CASE, "study.nc", "tables/max_closure.csv"):
        (results / name).unlink()
    finished(copied, "tiny.yaml")
    runs.assert_same(results, study / RESULTS)
    assert runs.planned(copied) == {}


@pytest.mark.slow
def test_a_report_of_a_spoilt_dataset_is_refused_in_a_line(copied):
    flipped(copied / RESULTS, "study.nc")
    page = copied / "page.html"
    refused = runs.studies_command("report", copied / RESULTS, "--output", page)
    assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    assert "study.nc: " in refused.stderr
    assert not page.exists()


@pytest.mark.slow
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
