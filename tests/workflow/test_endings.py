"""A run that is asked to end: it ends soon, says how to go on, leaves no process, and goes on.

`JOINTCLOSURE_ENDINGS=40 pytest -m slow tests/workflow/test_endings.py` ends a run forty times.
"""

import contextlib
import itertools
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.engine.test_forks import processes_in
from tests.workflow.runs import ROOT, STAMP, checkout

pytestmark = pytest.mark.slow
ENDINGS = int(os.environ.get("JOINTCLOSURE_ENDINGS", "8"))
SECONDS = 30.0
"""Within which all must have ended."""
GOES_ON = "the same command goes on from there"
ONE_CASE = """study: {name: ended, rocks: [slate], realizations: 3, pool: null}
grid: {cells_x: 24, cells_y: 24}
rocks:
  slate:
    max_normal_stress_MPa: 1
    levels: {poisson_ratio: null, youngs_modulus_GPa: null, jrc: null}
statistics: {bootstrap_resamples: 10, repetitions: 100, control_variates: 100}
output: {stress_points: 5}
"""
STUDY = ("make", "-o", STAMP, "study", "CONFIG=one.yaml", "CORES=2")
HEEDED = "import os, signal, sys; signal.signal(2, signal.SIG_DFL); os.execvp('make', sys.argv[1:])"


@pytest.fixture
def folder(tmp_path):
    """A checkout with a study of one case."""
    made = checkout(tmp_path / "ended")
    (made / "one.yaml").write_text(ONE_CASE)
    return made


def started(folder: Path, command: tuple[str, ...] = STUDY) -> subprocess.Popen:
    """`make` in a session of its own, with interrupts heeded as from a terminal."""
    with open(folder / "output.txt", "w") as output:
        return subprocess.Popen(
            [sys.executable, "-c", HEEDED, *command],
            cwd=folder,
            stdout=output,
            stderr=output,
            start_new_session=True,
        )


def ask(run: subprocess.Popen, number: int, whom: str) -> None:
    """Signal make alone, or its whole group as a terminal and `timeout` do."""
    with contextlib.suppress(ProcessLookupError):
        (os.killpg if whom == "group" else os.kill)(run.pid, number)


def wait_for_the_end(folder: Path, run: subprocess.Popen) -> str:
    """Wait until nothing works in a folder; what was printed."""
    start = time.monotonic()
    while run.poll() is None or processes_in(folder):
        working = [process.cmdline() for process in processes_in(folder)]
        assert time.monotonic() - start < SECONDS, working
        time.sleep(0.1)
    return (folder / "output.txt").read_text()


@pytest.mark.parametrize("whom", ["process", "group"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_set_up_that_is_ended_leaves_no_process_and_no_environment_that_counts(
    tmp_path, number, whom
):
    needed = ("Makefile", "pyproject.toml", "requirements.lock", "requirements-uv.lock")
    for name in (*needed, "workflow/scripts/process_group.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    run = started(tmp_path, ("make", "setup"))
    time.sleep(random.Random(number).uniform(0.5, 10.0))
    ask(run, number, whom)
    wait_for_the_end(tmp_path, run)
    assert run.returncode != 0
    assert not (tmp_path / STAMP).exists()


def test_a_run_ends_at_every_moment_and_the_next_goes_on(folder):
    """Moments are drawn over the start, the plan and the jobs; each run goes on from the last."""
    chance = random.Random(1)
    kinds = itertools.product((signal.SIGTERM, signal.SIGINT), (1, 2), ("process", "group"))
    for number, times, whom in itertools.islice(itertools.cycle(kinds), ENDINGS):
        run = started(folder)
        time.sleep(chance.uniform(0.0, 25.0))
        finished = run.poll() is not None
        for _ in range(times):
            ask(run, number, whom)
            time.sleep(chance.choice([0.0, 0.01, 0.5, 2.0]))
        printed = wait_for_the_end(folder, run)
        assert "Traceback" not in printed
        finished = finished or "Results are in" in printed  # before the signal had an effect
        assert finished or run.returncode == 0 or GOES_ON in printed
    run = started(folder)
    assert run.wait() == 0, (folder / "output.txt").read_text()
    assert (folder / "results/ended/study.nc").is_file()
