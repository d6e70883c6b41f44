"""A study of readings of seconds: rounds follow each other."""

import itertools
import shutil

import pandas as pd
import pytest

from jointclosure.statistics.verdicts import VERDICTS
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow

CONFIG = "tiny_readings.yaml"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("readings"))
    shutil.copy(ROOT / "tests/workflow" / CONFIG, folder)
    answer = snakemake(folder, "readings", config=CONFIG)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return folder / "results/tiny_readings"


def test_every_reading_has_a_row_by_its_last_round(results):
    table = pd.read_csv(results / "tables/readings.csv")
    assert {"as_configured", "hurst_05", "walk", "seated"} <= set(table.reading)
    assert table.reading.is_unique
    assert table["round"].iloc[0] == "finalists"
    assert table.behind.iloc[0] == 0.0
    assert (table.realizations == table["round"].map({"finalists": 6}).fillna(3)).all()
    errors = table.filter(regex="_error$|standard_error")
    assert errors.notna().all(axis=None)
    claims = table.filter(like="claim ")
    assert set(claims.to_numpy().ravel()) <= set(VERDICTS)
    implied = pd.read_csv(results / "tables/readings_implied.csv")
    assert (implied.low <= implied.scatter).all()
    text = (results / "tables/readings.md").read_text()
    assert all(title in text for title in table.title)


def test_a_round_is_entered_by_the_configured_reading_and_those_kept_before(results):
    rounds = ["screen", "pairs", "finalists"]
    tables = [pd.read_csv(results / f"tables/readings_round_{name}.csv") for name in rounds]
    for before, after in itertools.pairwise(tables):
        assert "as_configured" in set(after.reading)
        kept = {"as_configured", *before.reading[before.kept]}
        singles = {name for name in after.reading if "-" not in name}
        assert singles <= kept
    closed = {path.name.split(".")[0] for path in (results / "readings").glob("*.nc")}
    entered = {name for table in tables for name in table.reading}
    # one of them reads the closures of the configured reading, or of the other of its pair
    assert closed == {name for name in entered if not name.endswith("seated")}
