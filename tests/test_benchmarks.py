"""Benchmarks run, small, and print the numbers that the documents take from them."""

import pandas as pd
import pytest

from tests.processes import python


@pytest.mark.slow
def test_selected_effects_are_judged_at_conditions_of_any_seed(tmp_path):
    options = ["--scenes", "2", "--surfaces", "4", "--seed", "7", "--cells", "16", "20"]
    for _ in range(2):  # the second run has nothing left to close
        python("benchmarks/effects_auto.py", *options, "--output", tmp_path)
    summary = pd.read_csv(tmp_path / "summary.csv")
    assert summary.joints.tolist() == [20, 180, 540] * 2
    assert (summary.scenes == 2).all()
    selections = pd.read_csv(tmp_path / "selections.csv")
    outside = selections.least > selections.tolerance
    assert (outside | (selections.saved <= selections.best_saved)).all()


@pytest.mark.slow
def test_requests_of_accuracy_are_judged_by_surfaces_that_they_did_not_see(tmp_path):
    options = ["--scenes", "1", "--surfaces", "4", "--seed", "7", "--cells", "16", "16"]
    python("benchmarks/accuracy_requests.py", *options, "--output", tmp_path)
    summary = pd.read_csv(tmp_path / "summary.csv")
    assert summary.within_percent.tolist() == [2.0, 5.0, 10.0, 20.0]
    assert (summary.answered + summary.none_exists + summary.refused_wrongly >= 1).all()
    requests = pd.read_csv(tmp_path / "requests.csv")
    met = requests[requests.answered]
    assert (met.half_width_percent <= met.within_percent).all()
    assert (requests.truth != requests.value).all()
