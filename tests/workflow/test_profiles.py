"""The cluster's profile fits the rules, which a machine without a cluster can tell."""

import pytest
import yaml

from tests.workflow.test_pipeline import ROOT, checkout, snakemake


@pytest.mark.parametrize(
    ("goal", "config"),
    [("all", "tiny.yaml"), ("global_sensitivity", "config/global_sensitivity_full.yaml")],
)
def test_groups_of_the_slurm_profile_can_be_submitted(tmp_path, goal, config):
    """A rule between two of a group must be in it: Snakemake refuses the whole study."""
    folder = checkout(tmp_path)
    profile = yaml.safe_load((ROOT / "workflow/profiles/slurm/config.yaml").read_text())
    del profile["executor"]  # its plugin is an extra
    (folder / "profile").mkdir()
    (folder / "profile/config.yaml").write_text(yaml.safe_dump(profile))
    answer = snakemake(folder, goal, "--dry-run", config=config, profile="profile")
    assert answer.returncode == 0, answer.stdout + answer.stderr
