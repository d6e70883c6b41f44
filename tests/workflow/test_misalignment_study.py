"""A study of misalignment of seconds: its files are there, and nothing is done twice."""

import shutil

import numpy as np
import pandas as pd
import pytest

from jointclosure.storage.netcdf import read_netcdf
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_misalignment.yaml"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("misalignment"))
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    answer = snakemake(folder, "misalignment", config=CONFIG)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "18 joints will take about" in answer.stderr
    again = snakemake(folder, "misalignment", config=CONFIG)
    assert "Nothing to be done" in again.stdout + again.stderr
    return folder / "results/tiny_misalignment"


def test_the_study_has_its_dataset_table_and_figure(results):
    study = read_netcdf(results / "misalignment.nc")
    assert study.wavelength.values.tolist() == [0.75e-3, np.inf]
    assert study.rock.values.tolist() == ["slate"]
    assert "configuration" in study.attrs
    table = pd.read_csv(results / "tables/misalignment.csv")
    assert len(table) == 2 * 3 * (4 + 3)
    assert (results / "figures/misalignment.png").stat().st_size > 20000
