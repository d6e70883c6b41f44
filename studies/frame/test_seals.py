"""Seals: only the file that a job wrote, with these settings and from these files, is read."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.storage.netcdf import write_netcdf
from studies.frame import lock
from studies.frame.lock import LOCK, enter_folder
from studies.frame.seals import ForeignFileError, check_folder, job, settings_digest, unmet_seals


class Log(list):
    """As Snakemake gives logs, of which one has a name."""

    @property
    def benchmark(self) -> str:
        return self[0].replace(".log", ".tsv")


def run(folder, rule, inputs, outputs, work, **params):
    """Run a job as Snakemake would, in `folder`."""
    for name in ("logs", "tables"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    log, files = Log([str(folder / f"logs/{rule}.log")]), [str(folder / name) for name in outputs]
    about = {"input": [str(folder / name) for name in inputs], "output": files, "params": params}
    with job(SimpleNamespace(rule=rule, log=log, **about)):
        work(*(folder / name for name in outputs))


def make_study(folder, value, **settings):
    """A dataset, and a table of it."""
    dataset = xr.Dataset({"x": ("n", [value, value])})
    run(folder, "close", [], ["study.nc"], lambda path: write_netcdf(dataset, path), **settings)
    text = f"x\n{value}\n"
    run(folder, "fit", ["study.nc"], ["tables/a.csv"], lambda path: path.write_text(text))


def reasons_against(folder, **settings):
    """Reasons why seals of a study are not met, where its dataset has these settings."""
    expected = {str(folder / "study.nc"): settings_digest(settings)}
    unmet = unmet_seals(folder, lambda seal: expected.get(next(iter(seal.files)), ""))
    return [reason for _, _, reason in unmet]


def judge(folder):
    """A job that reads both; it must not run on files that it does not belong to."""
    inputs = ["study.nc", "tables/a.csv"]
    run(folder, "judge", inputs, ["tables/b.csv"], lambda path: path.write_text("read\n"))


@pytest.fixture
def mine(tmp_path):
    folder = tmp_path / "results/mine"
    make_study(folder, 1.0, jrc=8)
    return folder


@pytest.fixture
def other(tmp_path):
    folder = tmp_path / "results/other"
    make_study(folder, 2.0, jrc=9)
    return folder


def test_what_is_as_it_was_made_is_read_and_a_seal_states_what_a_file_was_made_of(mine):
    judge(mine)
    assert (mine / "tables/b.csv").read_text() == "read\n"
    assert reasons_against(mine, jrc=8) == []
    stated = json.loads((mine / "seals/judge.json").read_text())
    assert list(stated["files"]) == ["tables/b.csv"]
    assert list(stated["made_from"]) == ["study.nc", "tables/a.csv"]


NOT_AS_WRITTEN = "the file is not as jointclosure wrote it"
ATTACKS = {
    "dataset": (["study.nc"], f"study.nc: {NOT_AS_WRITTEN}"),
    "dataset with its seal": (["study.nc", "seals/close.json"], "made with other settings"),
    "whole study": (
        ["study.nc", "tables/a.csv", "seals/close.json", "seals/fit.json"],
        "study.nc: the file was made with other settings",
    ),
    "table": (["tables/a.csv"], f"a.csv: {NOT_AS_WRITTEN}"),
    "table with its seal": (["tables/a.csv", "seals/fit.json"], "a.csv: the file was made from"),
    "edited table": ("tables/a.csv", f"a.csv: {NOT_AS_WRITTEN}"),
    "edited seal": ("seals/fit.json", "fit.json: is not a seal"),
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_no_job_reads_a_file_of_another_study_or_a_changed_one(mine, other, attack):
    files, message = ATTACKS[attack]
    if isinstance(files, str):
        (mine / files).write_text("{")
    else:
        for file in files:
            shutil.copy2(other / file, mine / file)
    reasons = reasons_against(mine, jrc=8)
    assert any(message in reason for reason in reasons)
    assert all("\n" not in reason for reason in reasons)
    if attack != "whole study":  # only its settings differ
        with pytest.raises(ForeignFileError):
            judge(mine)
        assert not (mine / "tables/b.csv").exists()


def test_a_folder_is_whole_wherever_it_was_moved_or_an_error(mine, tmp_path):
    there = tmp_path / "elsewhere"
    shutil.move(mine, there)
    assert {path.name for path in check_folder(there)} == {"study.nc", "a.csv"}
    (there / "tables/a.csv").unlink()
    with pytest.raises(ForeignFileError, match=r"a.csv: is missing"):
        check_folder(there)


# One run at a time in a folder that allows one; the lock of a killed run is nobody's


HOLDS = """
import os, sys, time
from studies.frame.lock import enter_folder
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
        while lock._held:
            lock._held.pop().close()

    yield leave
    leave()


@contextlib.contextmanager
def holder(*words: str) -> Iterator[subprocess.Popen]:
    """A process and its fork that hold the lock, in a group of their own."""
    about = {"stdout": subprocess.PIPE, "text": True, "start_new_session": True}
    with subprocess.Popen([sys.executable, "-c", HOLDS, *words], **about) as run:
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
    here = lock._this_process()
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

    monkeypatch.setattr(lock.fcntl, "flock", flock)
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
