"""A finished study of seconds, by `make`."""

import shutil

import pytest

from tests.workflow.runs import STAMP, answer, checkout


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("study") / "finished")
    done = answer(["make", "-o", STAMP, "study", "CONFIG=tiny.yaml", "CORES=2"], folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture
def copied(study, tmp_path):
    """A copy of the finished study, to be spoilt."""
    return shutil.copytree(study, tmp_path / "copied", symlinks=True)
