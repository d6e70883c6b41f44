"""Logs of the workflow's scripts: whoever reads one finds what failed, and where."""

import pytest

from jointclosure.logbook import logging_to


def test_a_failure_leaves_where_it_was_and_ends_with_what_it_was(tmp_path, capfd):
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
    # and a line to who waits for it
    assert "job.log: no such share" in capfd.readouterr().err
