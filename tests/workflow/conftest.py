"""Finished small studies, each made once for all workers of a run of the tests."""

import fcntl
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.workflow.runs import STAMP, answer, checkout, pretend


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Function that makes a folder, or waits until another worker has made it."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def made(name: str, make: Callable[[Path], None]) -> Path:
        folder, finished = shared / name, shared / f"{name}.finished"
        with open(shared / f"{name}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not finished.exists():
                shutil.rmtree(folder, ignore_errors=True)
                make(checkout(folder))
                finished.touch()
        return folder

    return made


def made_by_make(config: str) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        done = answer(["make", "-o", STAMP, "study", f"CONFIG={config}", "CORES=2"], folder)
        assert done.returncode == 0, done.stdout + done.stderr
        (folder / "printed.txt").write_text(done.stdout + done.stderr)

    return make


@pytest.fixture(scope="session")
def study(made_once):
    """The tiny study, finished by `make`, whose output is in printed.txt."""
    return made_once("tiny", made_by_make("tiny.yaml"))


@pytest.fixture(scope="session")
def smallest(made_once):
    """The smallest study, finished by `make`."""
    return made_once("smallest", made_by_make("smallest.yaml"))


@pytest.fixture(scope="session")
def pretended(made_once):
    """The tiny study with empty files, which Snakemake takes as finished."""
    return made_once("pretended", pretend)


@pytest.fixture
def copied(study, tmp_path):
    """A copy of the finished study, to be spoilt."""
    return shutil.copytree(study, tmp_path / "copied", symlinks=True)


@pytest.fixture
def planning(pretended, tmp_path):
    """A copy of the pretended study, whose files may be changed."""
    return shutil.copytree(pretended, tmp_path / "planning", symlinks=True)
