"""`jointclosure doctor`: says what it found, and what to do where something is not well."""

import pytest

from jointclosure.cli import doctor
from jointclosure.cli import main as cli


@pytest.fixture
def quick(monkeypatch):
    """Without the start of Snakemake, which takes seconds and is tested by itself."""
    monkeypatch.setattr(doctor, "_snakemake", lambda folder: doctor.Finding("snakemake", "starts"))


@pytest.fixture
def one_thread(monkeypatch):
    for name in doctor.THREADS:
        monkeypatch.setenv(name, "1")


def test_a_sound_environment_has_no_advice(quick, one_thread, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "no problems" in out
    assert "->" not in out
    for what in ("python", "packages", "cores", "threads", "memory", "compiled kernels", "results"):
        assert f"{what}:" in out
    assert list(tmp_path.iterdir()) == []


def test_threads_set_otherwise_get_an_advice(quick, one_thread, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(doctor.os, "sched_getaffinity", lambda process: {0, 1}, raising=False)
    for name in doctor.THREADS:  # as in any shell: make sets them
        monkeypatch.delenv(name)
    assert cli.main(["doctor"]) == 0
    assert "make sets all to 1" in capsys.readouterr().out
    monkeypatch.setenv("MKL_NUM_THREADS", "2")
    assert cli.main(["doctor"]) == 1
    out = capsys.readouterr().out
    assert "OMP_NUM_THREADS=unset" in out
    assert "set all to 1" in out
    assert "1 with advice" in out


def test_little_memory_means_fewer_jobs(monkeypatch):
    class Memory:
        available, total = 1.2e9, 4e9

    monkeypatch.setattr(doctor.psutil, "virtual_memory", Memory)
    assert doctor._memory(2).advice == ""
    assert "CORES=2" in doctor._memory(8).advice


def test_the_last_line_of_a_snakemake_that_does_not_start_is_said(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/smoke.yaml").write_text("")
    (tmp_path / "Snakefile").write_text("this is no rule\n")
    finding = doctor._snakemake(tmp_path)
    assert finding.advice
