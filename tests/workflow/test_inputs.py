"""A study of files of one's own, which are scanned walls of another rock with a measured curve."""

import hashlib
import json
import os
import shutil

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import SPACING
from tests.workflow.runs import checkout, planned, pretend, run_snakemake, snakemake

CURVE = "stress_MPa,closure_mm,cycle\n0,0,1\n0.5,0.05,1\n0.8,0.07,1\n0.4,0.065,1\n"


STUDY = """study: {name: mine, rocks: [granite], realizations: 3, pool: null}
rocks:
  granite:
    {title: Granite, youngs_modulus_GPa: 60, poisson_ratio: 0.22, compressive_strength_MPa: 180,
     max_normal_stress_MPa: 1, levels: {}, measured: {file: measured.csv},
     walls: {lower: scans/lower.npz, upper: mirrored, missing: avoid}}
grid: {cells_x: 12, cells_y: 16}
output: {stress_points: 5}
"""
"""A rock that the paper does not have, with scanned walls, and nothing varied."""


def scanned(folder, seed):
    (folder / "scans").mkdir(exist_ok=True)
    wall = 1e3 * jc.wall_pair(9.0, (40, 36), SPACING, seed)[0] + 0.01 * np.arange(36)
    wall[:3, :3] = np.nan
    np.savez(folder / "scans/lower.npz", Z_mm=wall, spacing_mm=1e3 * SPACING)


def own_study(folder):
    """A checkout with a scan, a curve, and a configuration of them."""
    scanned(checkout(folder), 1)
    (folder / "measured.csv").write_text(CURVE)
    (folder / "mine.yaml").write_text(STUDY)
    return folder


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    folder = own_study(tmp_path_factory.mktemp("mine") / "checkout")
    snakemake(folder, config="mine.yaml")
    return folder


@pytest.mark.slow
def test_walls_of_a_file_are_in_the_results(mine):
    dataset = read_netcdf(mine / "results/mine/study.nc")
    assert np.isnan(dataset.jrc.values).all()
    assert (dataset.max_closure.values > 0.0).all()
    stated = json.loads(dataset.attrs["walls"])["granite"]
    digest = hashlib.sha256((mine / "scans/lower.npz").read_bytes()).hexdigest()
    assert (stated["lower"]["sha256"], stated["partner"]) == (digest, "mirrored")
    rocks = pd.read_csv(mine / "results/mine/tables/table_1_rocks.csv")
    assert rocks.lower_wall[0] == "scans/lower.npz"


@pytest.mark.slow
def test_a_measured_curve_is_in_the_results(mine):
    tables = mine / "results/mine/tables"
    assert pd.read_csv(tables / "table_1_rocks.csv").measured[0] == "measured.csv"
    fit = pd.read_csv(tables / "measured_fit.csv")
    assert fit.best_realization.isin([0, 1, 2]).all()


@pytest.mark.slow
def test_nothing_of_the_paper_is_in_the_results(mine):
    tables = mine / "results/mine/tables"
    assert "paper" not in pd.read_csv(tables / "claims.csv")
    assert "paper_length" not in pd.read_csv(tables / "table_3_indifference.csv")
    figures = {path.stem for path in (mine / "results/mine/figures").iterdir()}
    assert figures == {
        "fig_3_equivalent_stress", "fig_5_closure", "closure_since_seating", "wall_pair"
    }  # fmt: skip


@pytest.fixture(scope="module")
def pretended_study(tmp_path_factory):
    folder = own_study(tmp_path_factory.mktemp("pretended") / "mine")
    pretend(folder, config="mine.yaml")
    return folder


@pytest.fixture
def pretended_mine(pretended_study, tmp_path):
    """A copy of the study as finished, with empty files, whose inputs may be changed."""
    return shutil.copytree(pretended_study, tmp_path / "mine", symlinks=True)


def test_a_touch_of_an_input_reruns_nothing(pretended_mine):
    os.utime(pretended_mine / "scans/lower.npz")
    os.utime(pretended_mine / "measured.csv")
    assert planned(pretended_mine, config="mine.yaml") == {}


def test_another_curve_reruns_what_reads_it(pretended_mine):
    (pretended_mine / "measured.csv").write_text(CURVE.replace("0.07", "0.08"))
    jobs = planned(pretended_mine, config="mine.yaml")
    assert {"fit_measured", "draw_figures"} <= set(jobs)
    assert not {"prepare_walls", "cut_windows", "close_joints", "aggregate"} & set(jobs)


def test_another_scan_reruns_what_reads_it(pretended_mine):
    scanned(pretended_mine, 2)
    # older than the results: its contents count all the same
    os.utime(pretended_mine / "scans/lower.npz", (1e9, 1e9))
    jobs = planned(pretended_mine, config="mine.yaml")
    # walls, windows and joints of the only case
    assert [jobs[name] for name in ("prepare_walls", "cut_windows", "close_joints")] == [1, 1, 1]


@pytest.mark.parametrize("gone", ["scans/lower.npz", "measured.csv"])
def test_a_file_that_is_not_there_is_named_before_any_job(tmp_path, gone):
    folder = own_study(tmp_path / "mine")
    (folder / gone).unlink()
    refused = run_snakemake(folder, config="mine.yaml")
    assert refused.returncode != 0
    printed = refused.stdout + refused.stderr
    (line,) = [line for line in printed.splitlines() if gone in line]
    assert "must be the path of a file (from there, or absolute)" in line
    assert "Traceback" not in printed
    assert not (folder / "results").exists()
