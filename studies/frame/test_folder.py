"""One run at a time in a folder that allows one; the lock of a killed run is nobody's."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from jointclosure.inputs import InputError
from studies.frame import jobs
from studies.frame.jobs import LOCK, enter_folder

HOLDS = """
import os, sys, time
from studies.frame.jobs import enter_folder
enter_folder()
if not os.fork():  # as Snakemake under make
    enter_folder()
    print("entered", flush=True)
    time.sleep(0 if sys.argv[1:] else 600)
    os._exit(0)
if sys.argv[1:]:
    os.wait()
else:
    time.sleep(600)
"""


@pytest.fixture
def entered(tmp_path, monkeypatch):
    """A folder that no process has entered, and the way to leave it as by a kill."""
    monkeypatch.chdir(tmp_path)

    def leave():
        while jobs._held:
            jobs._held.pop().close()

    yield leave
    leave()


@contextlib.contextmanager
def holder(*words: str) -> Iterator[subprocess.Popen]:
    """A process and its fork that hold the lock, in a group of their own."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS, *words],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as run:
        assert run.stdout.readline() == "entered\n"
        yield run


def test_a_second_run_is_refused_until_the_first_was_killed(entered):
    with holder() as run:
        with pytest.raises(InputError, match=rf"another run is at work .* \(process {run.pid} on "):
            enter_folder()
        Path(".snakemake/locks").mkdir()
        os.killpg(run.pid, signal.SIGKILL)
    enter_folder()
    assert not Path(".snakemake/locks").exists()


def test_a_run_that_ends_leaves_no_name(entered):
    with holder("ends") as run:
        assert run.wait() == 0
    assert LOCK.read_text() == ""


@pytest.mark.parametrize("host", ["", "other"])
@pytest.mark.parametrize("boot", ["", "other"])
def test_what_a_run_left_behind_locks_only_if_it_may_be_at_work_elsewhere(entered, host, boot):
    here = jobs._this_process()
    left = here | {"host": here["host"] + host, "boot": here["boot"] + boot}
    LOCK.parent.mkdir()
    LOCK.write_text(json.dumps(left))
    if host and boot:
        with pytest.raises(InputError, match=rf"on {left['host']}, since .* delete {LOCK}"):
            enter_folder()
        LOCK.unlink()
    enter_folder()


def test_without_locks_of_the_file_system_the_text_decides(entered, monkeypatch):
    def flock(*_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(jobs.fcntl, "flock", flock)
    enter_folder()
    entered()
    with pytest.raises(InputError, match="another run may be at work"):
        enter_folder()


@pytest.mark.parametrize("name", ["a{b", "a}b", "a\\b"])
def test_a_folder_that_snakemake_cannot_work_in_is_refused(entered, monkeypatch, name):
    Path(name).mkdir()
    monkeypatch.chdir(name)
    with pytest.raises(InputError, match="in its name"):
        enter_folder()
