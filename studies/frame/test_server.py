"""Jobs run as forks of the server: as Python would run them, and none is left behind."""

import contextlib
import inspect
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from snakemake.scheduling.job_scheduler import JobScheduler

from studies.frame.jobs.server import ADDRESS, CLIENT, JobServer

ROOT = Path(__file__).parents[2]

REPORTS = """import os, sys
print(os.getppid(), os.environ["COLOUR"], sys.argv[0], __name__, "numpy" in sys.modules, flush=True)
sys.exit(int(os.environ.get("STATUS", 0)))
"""
SLEEPS = """import os, pathlib, time
pathlib.Path("job.pid").write_text(str(os.getpid()))
time.sleep(600)
"""


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A server in an empty folder, whose scripts need numpy."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "report.py").write_text("import numpy\n")
    started = JobServer(tmp_path, "*_notes.txt")
    yield started
    started.end()


def job(server: JobServer, program: str, **environment: str) -> subprocess.Popen:
    """A job as Snakemake starts it."""
    script = Path("tmp1.report.py")
    script.write_text(program)
    return subprocess.Popen(
        ["bash", "-c", f"{server.prefix()} {sys.executable} {script}"],
        env=os.environ | {"OMP_NUM_THREADS": "1", "COLOUR": "blue"} | environment,
        stdout=subprocess.PIPE,
        text=True,
    )


def status_of(run: subprocess.Popen) -> int:
    run.communicate(timeout=60)
    return run.returncode


def pid_of_sleeping(path: Path) -> int:
    while not path.is_file() or not path.read_text():
        time.sleep(0.02)
    return int(path.read_text())


def ends(pid: int) -> bool:
    """Whether a process ends within seconds."""
    with contextlib.suppress(psutil.NoSuchProcess):
        process = psutil.Process(pid)
        for _ in range(500):
            if process.status() == psutil.STATUS_ZOMBIE:
                return True
            time.sleep(0.02)
        return False
    return True


@pytest.mark.parametrize("status", [0, 3])
def test_a_job_is_a_fork_with_its_environment_modules_and_status(server, status):
    run = job(server, REPORTS, STATUS=str(status))
    written, _ = run.communicate()
    parent, *rest = written.split()
    assert int(parent) == server._process.pid
    assert rest == ["blue", "tmp1.report.py", "__main__", "True"]
    assert run.returncode == status


@pytest.mark.parametrize("reason", ["no server", "more threads"])
def test_without_a_server_for_it_a_job_is_run_by_python(server, reason):
    threads = "2" if reason == "more threads" else "1"
    if reason == "no server":
        server.end()
    run = job(server, REPORTS, STATUS="3", OMP_NUM_THREADS=threads)
    written, _ = run.communicate()
    assert written.split()[1:] == ["blue", "tmp1.report.py", "__main__", "False"]
    assert int(written.split()[0]) != server._process.pid
    assert run.returncode == 3


@pytest.mark.parametrize("ended", ["client", "server", "killed server", "holder of the server"])
def test_no_job_is_left_behind(server, tmp_path, ended):
    run = job(server, SLEEPS)
    pid = pid_of_sleeping(tmp_path / "job.pid")
    if ended == "client":
        run.kill()
    elif ended == "server":
        server.end()
    elif ended == "killed server":
        time.sleep(0.5)  # until the client knows that the job has started, and does not repeat it
        server._process.kill()
    else:
        server._process.stdin.close()  # as by its death
    assert ends(pid)
    assert status_of(run) != 0


def test_a_killed_job_fails_and_the_server_goes_on(server, tmp_path):
    run = job(server, SLEEPS)
    os.kill(pid_of_sleeping(tmp_path / "job.pid"), 9)
    assert status_of(run) == 137
    assert status_of(job(server, REPORTS)) == 0


def test_clients_that_are_silent_or_not_ours_stop_no_other(server):
    with contextlib.ExitStack() as strangers:
        for sent in (b"", b'{"scr', b"{}\n", b"[]\n", b"\xff\n"):
            stranger = strangers.enter_context(socket.socket(socket.AF_UNIX))
            stranger.connect(str(ADDRESS))
            stranger.sendall(sent)
        assert status_of(job(server, REPORTS)) == 0
        assert server._process.poll() is None


def test_kernels_of_a_note_are_loaded_once_by_the_server(server, tmp_path):
    (tmp_path / "compile_kernels.py").write_text(
        "import os\ndef load(note):\n    open('loaded', 'a').write(f'{os.getpid()} {note}\\n')\n"
    )
    (tmp_path / "some_notes.txt").write_text("")
    for _ in range(2):
        assert status_of(job(server, REPORTS)) == 0
    assert (tmp_path / "loaded").read_text() == f"{server._process.pid} some_notes.txt\n"


def test_the_client_needs_the_standard_library_only():
    code = f"import runpy, sys; runpy.run_path({str(CLIENT)!r}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_snakemake_has_the_limit_of_starts_that_the_snakefile_removes():
    """Setting another attribute would change nothing, and jobs that ended would wake Snakemake."""
    source = inspect.getsource(JobScheduler)
    assert "self.job_rate_limiter = (" in source
    assert "if self.job_rate_limiter is None:" in source
    assert "workflow.scheduler.job_rate_limiter = None" in (ROOT / "Snakefile").read_text()
