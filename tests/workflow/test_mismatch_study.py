"""A study of mismatch of seconds: its files are there, and nothing is done twice."""

import shutil

import numpy as np
import pandas as pd
import pytest

from jointclosure.storage.netcdf import read_netcdf
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_mismatch.yaml"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("mismatch"))
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    for goal in ("estimate_mismatch", "mismatch"):
        answer = snakemake(folder, goal, config=CONFIG)
        assert answer.returncode == 0, answer.stdout + answer.stderr
        if goal == "estimate_mismatch":
            assert "5 conditions of 1 rock will take about" in answer.stderr
    again = snakemake(folder, "mismatch", config=CONFIG)
    assert "Nothing to be done" in again.stdout + again.stderr
    return folder / "results/tiny_mismatch"


def test_the_study_has_its_dataset_tables_and_figure(results):
    study = read_netcdf(results / "mismatch.nc")
    assert study.wavelength.values.tolist() == [0.0, 0.75e-3, np.inf]
    assert study.rock.values.tolist() == ["slate"]
    assert "configuration" in study.attrs
    table = pd.read_csv(results / "tables/mismatch.csv")
    assert len(table) == 2 * (2 * 2 + 1)
    shifts = pd.read_csv(results / "tables/mismatch_shifts.csv")
    assert shifts.wavelength_mm.tolist() == [0.0, 0.75]
    assert (results / "figures/mismatch.png").stat().st_size > 20000
