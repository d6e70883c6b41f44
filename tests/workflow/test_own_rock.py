"""A rock that the paper does not have, nothing varied, held against a measured curve."""

import pandas as pd
import pytest

from jointclosure.statistics.verdicts import VERDICTS
from tests.workflow.test_pipeline import checkout, planned, snakemake

pytestmark = pytest.mark.slow

OWN = """
study: {name: own, rocks: [granite], realizations: 3, pool: null}
rocks:
  granite:
    title: Granite
    youngs_modulus_GPa: 60
    poisson_ratio: 0.22
    compressive_strength_MPa: 180
    jrc: 10
    max_normal_stress_MPa: 1
    levels: {}
    measured: {file: measured.csv}
grid: {cells_x: 12, cells_y: 16}
output: {stress_points: 5}
"""
CURVE = "stress_MPa,closure_mm,cycle\n0,0,1\n0.5,0.05,1\n0.8,0.07,1\n0.4,0.065,1\n"


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("own"))
    (folder / "own.yaml").write_text(OWN)
    (folder / "measured.csv").write_text(CURVE)
    answer = snakemake(folder, config="own.yaml")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return folder


def test_a_study_of_ones_own_rock_has_its_misfit_and_nothing_of_the_paper(own):
    tables = own / "results/own/tables"
    fit = pd.read_csv(tables / "measured_fit.csv")
    assert fit.rock.tolist() == ["granite"]
    assert fit.best_realization.isin([0, 1, 2]).all()
    claims = pd.read_csv(tables / "claims.csv")
    assert "paper" not in claims
    assert set(claims.verdict) <= set(VERDICTS)
    assert "paper_length" not in pd.read_csv(tables / "table_3_indifference.csv")
    assert "No parameter is varied" in (tables / "table_3_indifference.md").read_text()
    assert pd.read_csv(tables / "table_1_rocks.csv").measured.tolist() == ["measured.csv"]
    figures = {path.stem for path in (own / "results/own/figures").iterdir()}
    assert figures == {
        "fig_3_equivalent_stress", "fig_5_closure", "closure_since_seating", "wall_pair"
    }  # fmt: skip


def test_a_changed_curve_is_compared_and_drawn_anew_and_nothing_else(own):
    assert planned(own, config="own.yaml") == {}
    (own / "measured.csv").write_text(CURVE.replace("0.07", "0.08"))
    assert planned(own, config="own.yaml") == {"fit_measured": 1, "draw_figures": 1}


def test_a_bad_curve_is_refused_before_any_job(own):
    (own / "bad.csv").write_text(CURVE.replace("0.07", "0,07"))
    (own / "bad.yaml").write_text(OWN.replace("measured.csv", "bad.csv"))
    answer = snakemake(own, config="bad.yaml")
    printed = answer.stdout + answer.stderr
    assert answer.returncode != 0
    assert "bad.csv, line 4: '0.8,0,07,1' has 4 values, the header has 3" in printed
    assert "Execute" not in printed
