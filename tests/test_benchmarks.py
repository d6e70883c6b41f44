"""Benchmarks run, small, and print the numbers that the documents take from them."""

import importlib
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


@pytest.mark.slow
def test_selected_effects_are_judged_at_conditions_of_any_seed(tmp_path):
    options = ["--scenes", "2", "--surfaces", "4", "--seed", "7", "--cells", "16", "20"]
    for _ in range(2):  # the second run has nothing left to close
        subprocess.run(
            [sys.executable, BENCHMARKS / "effects_auto.py", *options, "--output", tmp_path],
            check=True,
            capture_output=True,
        )
    summary = pd.read_csv(tmp_path / "summary.csv")
    assert summary.joints.tolist() == [20, 180] * 2
    assert (summary.scenes == 2).all()
    selections = pd.read_csv(tmp_path / "selections.csv")
    outside = selections.least > selections.tolerance
    assert (outside | (selections.saved <= selections.best_saved)).all()


def test_flows_are_timed_with_those_codes_that_are_installed(monkeypatch, capsys):
    monkeypatch.syspath_prepend(BENCHMARKS)
    importlib.import_module("flow").main([256], 1)
    printed = capsys.readouterr().out
    assert "jointclosure" in printed
    assert "is left out" in printed or "reynoldsflow, scipy-spsolve" in printed
