"""Benchmarks run, small, and print the numbers that the documents take from them."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.mark.slow
def test_speed_of_the_solvers_is_measured_with_its_parts(tmp_path):
    options = ["--parts", "elastic", "study", "--repeats", "1", "--cells", "48"]
    subprocess.run(
        [sys.executable, BENCHMARKS / "solver_speed.py", *options, "--output", tmp_path],
        check=True,
        capture_output=True,
    )
    study = pd.read_csv(tmp_path / "study.csv")
    assert study.rock.nunique() == 4
    shares = study[["breaking %", "equilibrium %"]]
    assert (shares > 1.0).all(axis=None)
    assert (shares.sum(axis=1) < 100.0).all()
    assert (study[["pairs", "products", "breakage steps"]] > 100.0).all(axis=None)
    assert len(pd.read_csv(tmp_path / "elastic.csv")) == 3
    assert set(pd.read_csv(tmp_path / "targets.csv").verdict) <= {"met", "NOT met"}
