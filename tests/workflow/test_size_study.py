"""A study of the scale effect of seconds: its files are there, and nothing is done twice."""

import re
import shutil

import pandas as pd
import pytest

from jointclosure.storage.netcdf import read_netcdf
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_size.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("size"))
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    for goal in ("estimate_size", "size"):
        answer = snakemake(folder, goal, config=CONFIG)
        assert answer.returncode == 0, answer.stdout + answer.stderr
        if goal == "estimate_size":
            assert "132 joints will take about" in answer.stderr
    return folder


def test_the_study_has_its_dataset_tables_and_figure(folder):
    results = folder / "results/tiny_size"
    study = read_netcdf(results / "size.nc")
    assert study.spectrum.values.tolist() == ["flat", "free"]
    assert study.rock.values.tolist() == ["slate"]
    assert "configuration" in study.attrs
    assert len(pd.read_csv(results / "tables/size.csv")) == 2 * 4 * 2
    assert set(pd.read_csv(results / "tables/size_exponents.csv").of) == {"patch", "spacing"}
    for table in ("size_collapse", "size_barton_bandis"):
        assert len(pd.read_csv(results / f"tables/{table}.csv")) > 0
    assert (results / "figures/size.png").stat().st_size > 20000


def test_what_is_lost_alone_is_made_again(folder):
    assert "Nothing to be done" in _dry_run(folder)
    for lost in ("size/slate.free.nc", "tables/size.csv"):
        (folder / "results/tiny_size" / lost).unlink()
    counts = dict(re.findall(r"^(close_size|weigh_size) +(\d+)$", _dry_run(folder), re.M))
    assert counts == {"close_size": "1", "weigh_size": "1"}


def _dry_run(folder) -> str:
    answer = snakemake(folder, "size", "--dry-run", config=CONFIG)
    return answer.stdout + answer.stderr
