"""A study of scanned walls, from the scan to the tables."""

import hashlib
import json
import os

import numpy as np
import pandas as pd
import pytest
import yaml

import jointclosure as jc
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import SPACING
from tests.workflow.test_pipeline import TINY, checkout, planned, snakemake

pytestmark = pytest.mark.slow

WALLS = {"lower": "scans/lower.npz", "upper": "mirrored", "missing": "avoid"}


def configured(folder, name="walls.yaml", **changes):
    """A tiny study whose slate has scanned walls."""
    study = yaml.safe_load(TINY.read_text())
    rock = {"jrc": None, "walls": WALLS | changes, "max_normal_stress_MPa": 1}
    rock["levels"] = {"jrc": None}
    study["rocks"] = {"slate": rock}
    study["study"] |= {"draws": "common", "pool": None}
    (folder / name).write_text(yaml.safe_dump(study))
    return name


def scanned(folder, seed):
    (folder / "scans").mkdir(exist_ok=True)
    wall = 1e3 * jc.wall_pair(9.0, (40, 36), SPACING, seed)[0] + 0.01 * np.arange(36)
    wall[:3, :3] = np.nan
    np.savez(folder / "scans/lower.npz", Z_mm=wall, spacing_mm=1e3 * SPACING)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("walls"))
    scanned(folder, 1)
    answer = snakemake(folder, config=configured(folder))
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return folder


def test_a_study_of_measured_walls_runs_to_its_end(study):
    results = study / "results/tiny"
    dataset = read_netcdf(results / "study.nc")
    assert dataset.sizes["case"] == 7
    assert np.isnan(dataset.jrc.values).all()
    assert (dataset.max_closure.values > 0.0).all()
    digest = hashlib.sha256((study / "scans/lower.npz").read_bytes()).hexdigest()
    stated = json.loads(dataset.attrs["walls"])["slate"]
    assert stated["lower"]["sha256"] == digest
    assert stated["partner"] == "mirrored"
    table = pd.read_csv(results / "tables/table_3_indifference.csv")
    assert set(table.parameter) == {"poisson_ratio", "youngs_modulus", "compressive_strength"}
    assert pd.read_csv(results / "tables/table_1_rocks.csv").lower_wall[0] == "scans/lower.npz"
    checks = pd.read_csv(results / "tables/checks.csv").query("ensemble == 'cases'")
    checks = checks.set_index("check").found
    assert checks["realisations of slate that share no part of a scan"] == "at most 3 of 3"


def test_a_scan_whose_contents_change_reruns_its_cases_and_a_touch_does_not(study):
    assert planned(study, config="walls.yaml") == {}
    file = study / "scans/lower.npz"
    whole = file.read_bytes()
    os.utime(file)
    assert planned(study, config="walls.yaml") == {}
    scanned(study, 2)
    # older than the results: its contents count all the same
    os.utime(file, (1e9, 1e9))
    jobs = planned(study, config="walls.yaml")
    assert (jobs["prepare_walls"], jobs["close_study"]) == (1, 1)
    file.write_bytes(whole)
    assert planned(study, config="walls.yaml") == {}


def test_a_file_that_is_not_there_is_refused_before_any_job(study):
    answer = snakemake(study, config=configured(study, "bad.yaml", lower="scans/lowr.npz"))
    assert answer.returncode != 0
    printed = answer.stdout + answer.stderr
    assert "rocks.slate.walls.lower = 'scans/lowr.npz': not found in" in printed


@pytest.mark.parametrize(
    ("change", "printed"),
    [
        ({"units": "um"}, "scans/lower.npz: units = 'um': the heights of the file are in"),
        ({"missing": "refuse"}, "scans/lower.npz: 9 of 1440 cells have no height"),
        ({"spacing_mm": 0.5}, "scans/lower.npz: spacing = 0.5 mm: the file states 0.25 mm"),
    ],
)
def test_a_scan_that_cannot_be_used_stops_its_cases_before_they_are_closed(study, change, printed):
    answer = snakemake(study, config=configured(study, "bad.yaml", **change))
    assert answer.returncode != 0
    assert printed in answer.stdout + answer.stderr
    assert "joints closed" not in answer.stdout + answer.stderr
