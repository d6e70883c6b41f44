"""The whole pipeline on a study of seconds: its files, its bits, and what an edit makes again."""

import re

import numpy as np
import pandas as pd
import pytest

from jointclosure.storage.netcdf import read_netcdf
from tests.workflow.runs import assert_same, checkout, planned, snakemake, studies_command

pytestmark = pytest.mark.slow
RESULTS = "results/tiny"


def test_kernels_are_compiled_by_the_job_that_is_there_for_it_and_by_no_other(tmp_path):
    folder = checkout(tmp_path / "cold")
    with (folder / "tiny.yaml").open("a") as file:  # few kernels
        file.write("effects: {breakage: false, gouge: false, interaction: false}\n")
    target = f"{RESULTS}/study.nc"
    # a processor for which no machine code is shipped, and an empty cache
    old = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    cold = {"JOINTCLOSURE_CACHE": str(tmp_path / "kernels")}
    printed = snakemake(folder, "--", target, **old, **cold)
    assert printed.count("compiling kernels") == 1  # for the user to see
    logs = (folder / f"{RESULTS}/logs").rglob("*.log")
    assert not [log.name for log in logs if "compiling kernels" in log.read_text()]


def test_the_run_writes_what_the_readme_promises(study, tmp_path):
    results = study / RESULTS
    figures = list((results / "figures").iterdir())
    assert len({path.stem for path in figures}) == 8
    assert all(path.stat().st_size > 5000 for path in figures)
    assert len(pd.read_csv(results / "tables/table_3_indifference.csv")) == 8
    assert len(pd.read_csv(results / "tables/hydraulic_aperture.csv")) == 10 * 2 * 2 * 2 * 5
    checks = pd.read_csv(results / "tables/checks.csv")
    assert checks.passed.all()
    assert set(checks.ensemble) == {"cases", "pool"}
    assert planned(study) == {}
    page = tmp_path / "page.html"
    made = studies_command("report", results, "--output", page)
    assert (made.returncode, page.read_text().count("<img") >= 8) == (0, True), made.stderr


def test_the_dataset_has_coordinates_units_and_provenance(study):
    dataset = read_netcdf(study / RESULTS / "study.nc")
    sizes = {"case": 10, "realization": 3, "cycle": 2, "branch": 2, "direction": 2, "stress": 5}
    assert dict(dataset.sizes) == sizes
    stated = ("configuration", "root_seed", "source_digest", "provenance_commit")
    assert all(dataset.attrs[attribute] for attribute in stated)
    rises = np.diff(dataset.closure.sel(branch="loading").values, axis=-1)
    assert np.all(rises[np.isfinite(rises)] > 0.0)
    # only the last level may be missing, where the stress jumped over the target
    assert np.isfinite(rises[..., :-1]).all()


SMALLEST = """study: {name: smallest, rocks: [slate], realizations: 2, pool: null, cycles: 1}
grid: {cells_x: 3, cells_y: 3}
surface: {roll_off_mm: null}
rocks:
  slate:
    max_normal_stress_MPa: 1
    levels: {poisson_ratio: null, youngs_modulus_GPa: null, jrc: [5, 8]}
statistics: {bootstrap_resamples: 10, repetitions: 100, control_variates: 100}
output: {stress_points: 2}
"""


def test_the_smallest_legal_study_finishes(tmp_path):
    folder = checkout(tmp_path / "smallest")
    (folder / "smallest.yaml").write_text(SMALLEST)
    snakemake(folder, config="smallest.yaml")
    assert (folder / "results/smallest/figures/table_3_intervals.png").is_file()


def test_another_run_on_one_core_has_the_same_bits_and_the_study_before_its_pool(study, tmp_path):
    folder = checkout(tmp_path / "again")
    snakemake(folder, cores=1)
    (log,) = (folder / ".snakemake/log").glob("*.log")
    rules = re.findall(r"Finished jobid: \d+ \(Rule: (\w+)\)", log.read_text())
    complete = max(rules.index("write_tables"), rules.index("draw_figures"))
    assert rules.index("close_study") < complete < rules.index("close_pool")
    assert_same(folder / RESULTS, study / RESULTS)
