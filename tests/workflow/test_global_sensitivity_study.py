"""A study in which all inputs vary, of seconds, from its rules."""

import re
import shutil
from pathlib import Path

import pandas as pd
import pytest

from jointclosure.jobs.logbook import failed_log
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_global_sensitivity.yaml"
BLOCKS = "results/tiny_global_sensitivity/global_sensitivity"


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


def test_rows_that_are_added_leave_those_that_are_closed(results):
    folder = results.parents[1]
    for block in ("dolerite.0", "dolerite.8", "slate.0"):
        assert (results / f"global_sensitivity/{block}.nc").exists()
    text = (folder / CONFIG).read_text()
    (folder / "more.yaml").write_text(text.replace("rows: 16", "rows: 32"))
    answer = snakemake(folder, "global_sensitivity", "--dry-run", config="more.yaml")
    said = answer.stdout + answer.stderr
    counts = dict(re.findall(r"^(close_together) +(\d+)$", said, re.M))
    # two new blocks of each rock, and the one that the test before deleted
    assert counts == {"close_together": "5"}


def fails_once(folder: Path, output: str) -> None:
    """Have the job that writes a file fail at its first try."""
    script = folder / "workflow/scripts/close_together.py"
    text = script.read_text()
    begin = '    design, rows = from_plain(Design, settings["design"])'
    assert begin in text
    lost = f"""    from pathlib import Path

    if output.endswith({output!r}) and not Path("tried").exists():
        Path("tried").touch()
        raise RuntimeError("the node was lost")
"""
    script.write_text(text.replace(begin, lost + begin))


def test_a_job_that_fails_is_recorded_and_repeated_while_others_go_on(tmp_path):
    folder = checkout(tmp_path)
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    fails_once(folder, "slate.8.nc")
    stopped = snakemake(folder, "global_sensitivity", config=CONFIG)
    assert stopped.returncode != 0
    made = {each.name for each in (folder / BLOCKS).iterdir()}
    assert made == {"dolerite.0.nc", "dolerite.8.nc", "slate.0.nc"}
    log = folder / "results/tiny_global_sensitivity/logs/close_together/slate.8.log"
    assert "failed: RuntimeError: the node was lost" in log.read_text()
    (folder / "tried").unlink()
    answer = snakemake(folder, "global_sensitivity", "--retries", "1", config=CONFIG)
    said = answer.stdout + answer.stderr
    assert answer.returncode == 0, said
    assert said.count("Trying to restart job") == 1
    assert "the node was lost" in failed_log(log).read_text()
    assert "failed" not in log.read_text()


def _dry_run(folder) -> str:
    answer = snakemake(folder, "global_sensitivity", "--dry-run", config=CONFIG)
    return answer.stdout + answer.stderr
