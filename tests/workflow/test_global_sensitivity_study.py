"""A study in which all inputs vary, of seconds: a job that fails, and rows that are added."""

import re
import shutil
from pathlib import Path

import pytest

from jointclosure.storage.logs import failed_log
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_global_sensitivity.yaml"
BLOCKS = "results/tiny_global_sensitivity/global_sensitivity"


def fails_once(folder: Path, output: str) -> None:
    """Have the job that writes a file fail at its first try."""
    script = folder / "workflow/scripts/close_points.py"
    text = script.read_text()
    begin = "    write_netcdf(as_dataset(close_points("
    assert begin in text
    lost = f"""    from pathlib import Path

    if output.endswith({output!r}) and not Path("tried").exists():
        Path("tried").touch()
        raise RuntimeError("the node was lost")
"""
    script.write_text(text.replace(begin, lost + begin))


def test_a_job_that_fails_is_repeated_and_rows_that_are_added_close_no_others(tmp_path):
    folder = checkout(tmp_path)
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    fails_once(folder, "slate.8.nc")
    stopped = snakemake(folder, "global_sensitivity", config=CONFIG)
    assert stopped.returncode != 0
    made = {each.name for each in (folder / BLOCKS).iterdir()}
    assert made == {"dolerite.0.nc", "dolerite.8.nc", "slate.0.nc"}
    logs = folder / "results/tiny_global_sensitivity/logs/close_points"
    log = logs / "global_sensitivity/slate.8.log"
    assert "failed: RuntimeError: the node was lost" in log.read_text()
    (folder / "tried").unlink()
    answer = snakemake(folder, "global_sensitivity", "--retries", "1", config=CONFIG)
    printed = answer.stdout + answer.stderr
    assert answer.returncode == 0, printed
    assert printed.count("Trying to restart job") == 1
    assert "the node was lost" in failed_log(log).read_text()
    assert "failed" not in log.read_text()

    text = (folder / CONFIG).read_text()
    (folder / "more.yaml").write_text(text.replace("rows: 16", "rows: 32"))
    more = snakemake(folder, "global_sensitivity", "--dry-run", config="more.yaml")
    counts = dict(re.findall(r"^(close_points) +(\d+)$", more.stdout + more.stderr, re.M))
    assert counts == {"close_points": "4"}  # two new blocks of each rock
