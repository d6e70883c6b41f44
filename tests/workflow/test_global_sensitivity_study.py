"""A study in which all inputs vary, of seconds, from its rules."""

import re
import shutil

import pandas as pd
import pytest

from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_global_sensitivity.yaml"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("global_sensitivity"))
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    answer = snakemake(folder, "global_sensitivity", config=CONFIG)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "448 simulations, about" in answer.stderr
    return folder / "results/tiny_global_sensitivity"


def test_every_input_has_its_indices_and_figures_are_drawn(results):
    table = pd.read_csv(results / "tables/global_indices.csv")
    inputs = {"poisson_ratio", "youngs_modulus", "compressive_strength", "jrc", "peaks", "surfaces"}
    assert set(table.input) == inputs
    assert set(table.rock) == {"dolerite", "slate"}
    for name in ("indices", "convergence", "conclusions"):
        for kind in ("png", "pdf"):
            assert (results / f"figures/global_{name}.{kind}").stat().st_size > 5000


def test_what_is_lost_alone_is_made_again(results):
    folder = results.parents[1]
    assert "Nothing to be done" in _dry_run(folder)
    for lost in ("global_sensitivity/slate.8.nc", "tables/global_indices.csv"):
        (results / lost).unlink()
    counts = dict(re.findall(r"^(close_together|weigh_together) +(\d+)$", _dry_run(folder), re.M))
    assert counts == {"close_together": "1", "weigh_together": "1"}


def _dry_run(folder) -> str:
    answer = snakemake(folder, "global_sensitivity", "--dry-run", config=CONFIG)
    return answer.stdout + answer.stderr
