"""A study of readings of seconds: rounds follow each other, and nothing is done twice."""

import itertools
import re
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
    assert "simulations at most, about" in answer.stderr
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
    closed = {path.parent.name for path in (results / "readings").rglob("*.nc")}
    entered = {name for table in tables for name in table.reading}
    # one of them reads the closures of the configured reading, or of the other of its pair
    assert closed == {name for name in entered if not name.endswith("seated")}


def test_figures_are_drawn(results):
    for name in ("readings_likelihood", "readings_sensitivity"):
        for kind in ("png", "pdf"):
            assert (results / f"figures/{name}.{kind}").stat().st_size > 5000


def test_a_finished_study_of_readings_has_nothing_left_and_what_is_lost_alone_is_made_again(
    results,
):
    folder = results.parents[1]
    done = snakemake(folder, "readings", "--dry-run", config=CONFIG)
    assert "Nothing to be done" in done.stdout + done.stderr
    lost = next((results / "readings/walk").glob("slate.0.nc"))
    for path in (lost, results / "tables/readings.csv"):
        path.unlink()
    again = snakemake(folder, "readings", "--dry-run", config=CONFIG)
    counts = dict(re.findall(r"^(close_reading|weigh_readings) +(\d+)$", again.stdout, re.M))
    assert counts == {"close_reading": "1", "weigh_readings": "1"}
