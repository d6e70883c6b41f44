"""The pipeline on a real Slurm, where there is one (to get one: docs/reference.md)."""

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.workflow.runs import ROOT, assert_same, changed, checkout, snakemake

PROFILE = ROOT / "profiles/slurm/config.yaml"

pytestmark = pytest.mark.slow


def slurm_is_here() -> bool:
    if not shutil.which("sinfo") or not importlib.util.find_spec("snakemake_executor_plugin_slurm"):
        return False
    command = ["sinfo", "--noheader", "--format=%T"]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    return answer.returncode == 0 and bool({"idle", "mixed"} & set(answer.stdout.split()))


def on_slurm(folder: Path) -> str:
    """Run a study by the project's profile, with waits for a test, and without accounting."""
    profile = yaml.safe_load(PROFILE.read_text())
    profile |= {"slurm-init-seconds-before-status-checks": 2, "seconds-between-status-checks": 2}
    profile |= {"cores": 2, "latency-wait": 30}
    if subprocess.run(["sacct"], capture_output=True, check=False).returncode != 0:
        profile |= {"slurm-no-account": True, "slurm-status-command": "squeue"}
    (folder / "profile").mkdir()
    (folder / "profile/config.yaml").write_text(yaml.safe_dump(profile))
    return snakemake(folder, "--workflow-profile", "profile")


@pytest.mark.skipif(not slurm_is_here(), reason="no Slurm with an idle node, or no plugin for it")
def test_slurm_gives_the_same_bits_in_a_few_jobs(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        checkout(folder)
        changed(folder, "tiny.yaml", ("study.realizations_per_job", 2))
    snakemake(here)
    printed = on_slurm(there)
    assert_same(here / "results/tiny", there / "results/tiny")
    # surfaces and blocks in components of 4, the kernels, and what follows
    submitted = printed.count("SLURM jobid")
    assert 0 < submitted <= 30, printed
