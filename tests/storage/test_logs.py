"""Logs: whoever reads one finds what failed, and where."""

import contextlib

import pytest

from jointclosure.storage.logs import failed_log, logging_to


def test_a_failure_leaves_where_it_was_and_ends_with_what_it_was(tmp_path):
    def job():
        with logging_to(tmp_path / "job.log") as log:
            log("begins")
            print("said on the way")
            broken()

    def broken():
        raise ZeroDivisionError("no such share")

    with pytest.raises(ZeroDivisionError):
        job()
    lines = (tmp_path / "job.log").read_text().splitlines()
    assert lines[0].endswith("begins")
    assert lines[1] == "said on the way"
    assert any("in broken" in line for line in lines)
    assert lines[-1] == "failed: ZeroDivisionError: no such share"


def test_the_log_of_a_failed_try_stays_when_the_job_is_repeated(tmp_path):
    path = tmp_path / "job.log"
    for number, fails in enumerate((False, True, False)):
        with contextlib.suppress(ValueError), logging_to(path) as log:
            log(f"try {number}")
            if fails:
                raise ValueError("first line\nsecond line")
        assert failed_log(path).exists() == (number >= 1)
    assert "try 2" in path.read_text()
    assert "try 1" in failed_log(path).read_text()
    assert "failed: ValueError: first line" in failed_log(path).read_text()
