"""The pipeline on a real Slurm, where there is one (to get one: docs/reference.md)."""

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from jointclosure.storage.logs import failed_log
from tests.workflow.runs import ROOT, checkout, snakemake, studies_command

PROFILE = ROOT / "workflow/profiles/slurm/config.yaml"

pytestmark = pytest.mark.slow


def slurm_is_here() -> bool:
    if not shutil.which("sinfo") or not importlib.util.find_spec("snakemake_executor_plugin_slurm"):
        return False
    command = ["sinfo", "--noheader", "--format=%T"]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    return answer.returncode == 0 and bool({"idle", "mixed"} & set(answer.stdout.split()))


def on_slurm(folder: Path, *goals: str, config: str = "tiny.yaml") -> str:
    """Run a study by the project's profile, with waits for a test, and without accounting."""
    accounting = subprocess.run(["sacct"], capture_output=True, check=False).returncode == 0
    profile = yaml.safe_load(PROFILE.read_text())
    profile |= {"slurm-init-seconds-before-status-checks": 2, "seconds-between-status-checks": 2}
    profile |= {"cores": 2, "latency-wait": 30}
    if not accounting:
        profile |= {"slurm-no-account": True, "slurm-status-command": "squeue"}
    (folder / "profile").mkdir()
    (folder / "profile/config.yaml").write_text(yaml.safe_dump(profile))
    return snakemake(folder, *goals, config=config, profile="profile")


needs_slurm = pytest.mark.skipif(
    not slurm_is_here(), reason="no Slurm with an idle node, or no plugin for it"
)


def fails_once(folder: Path, block: str) -> None:
    """Have the job that closes a block fail at its first try."""
    script = folder / "workflow/scripts/close_block.py"
    begin = "        make_missing("
    text = script.read_text()
    assert begin in text
    lost = f"""        if snakemake.wildcards.block == {block!r} and not Path("tried").exists():
            Path("tried").touch()
            raise RuntimeError("the node was lost")
"""
    script.write_text(text.replace(begin, lost + begin))


@needs_slurm
def test_a_lost_slurm_job_is_recorded_and_repeated_while_others_go_on(tmp_path):
    folder = checkout(tmp_path / "study")
    shutil.copy(ROOT / "tests/workflow/tiny_global_sensitivity.yaml", folder)
    fails_once(folder, "slate.8")
    on_slurm(folder, "global_sensitivity", config="tiny_global_sensitivity.yaml")
    results = folder / "results/tiny_global_sensitivity"
    lost = failed_log(results / "logs/close_block/global_sensitivity/slate.8.log")
    assert "the node was lost" in lost.read_text()
    assert (results / "tables/global_sensitivity_indices.csv").exists()


@needs_slurm
def test_slurm_gives_the_same_bits_in_a_few_jobs(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        checkout(folder)
    text = (there / "tiny.yaml").read_text()
    (there / "tiny.yaml").write_text(
        text.replace("  realizations: 3\n", "  realizations: 3\n  realizations_per_job: 2\n")
    )
    snakemake(here)
    printed = on_slurm(there)
    found = studies_command("compare", "--exact", here / "results/tiny", there / "results/tiny")
    assert found.returncode == 0, found.stdout + found.stderr
    # blocks in components of 4, the kernels, and what follows
    submitted = printed.count("SLURM jobid")
    assert 0 < submitted <= 12, printed
