"""`jointclosure doctor` states what it finds, and what to do where something is not in order."""

import pytest

from jointclosure.cli import doctor


@pytest.fixture(autouse=True)
def sound(tmp_path, monkeypatch):
    """An empty folder, one thread, and no start of Snakemake, which takes seconds."""
    monkeypatch.chdir(tmp_path)
    for name in doctor.THREADS:
        monkeypatch.setenv(name, "1")
    monkeypatch.setattr(doctor, "_snakemake", lambda folder: ("snakemake", "starts", ""))
    monkeypatch.setattr(doctor.os, "sched_getaffinity", lambda process: {0, 1}, raising=False)


def test_a_sound_environment_has_no_advice(tmp_path, command):
    code, out, _ = command("doctor")
    assert (code, "no problems" in out, "->" in out) == (0, True, False)
    for what in ("python", "packages", "cores", "threads", "memory", "compiled kernels", "results"):
        assert f"{what}:" in out
    assert list(tmp_path.iterdir()) == []


def test_threads_set_otherwise_get_an_advice(monkeypatch, command):
    for name in doctor.THREADS:  # as in any shell: make sets them
        monkeypatch.delenv(name)
    assert command("doctor")[0] == 0
    monkeypatch.setenv("MKL_NUM_THREADS", "2")
    code, out, _ = command("doctor")
    assert code == 1
    assert "OMP_NUM_THREADS=unset" in out
    assert "set all to 1" in out


def test_a_snakemake_that_does_not_start_gets_an_advice(tmp_path, monkeypatch):
    monkeypatch.undo()
    (tmp_path / "config").mkdir()
    (tmp_path / "config/smoke.yaml").write_text("")
    (tmp_path / "Snakefile").write_text("this is no rule\n")
    assert doctor._snakemake(tmp_path)[-1]


def test_little_memory_means_fewer_jobs(monkeypatch):
    class Memory:
        available, total = 1.2e9, 4e9

    monkeypatch.setattr(doctor.psutil, "virtual_memory", Memory)
    assert doctor._memory(2)[-1] == ""
    assert "CORES=2" in doctor._memory(8)[-1]
