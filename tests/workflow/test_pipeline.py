"""The whole pipeline on a study of seconds, in folders of its own."""

import base64
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from jointclosure.engine.cache import is_kept
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.config.files import read_plain
from studies.frame.experiments import cached
from tests.studied import checked_study

ROOT = Path(__file__).parents[2]
TINY = ROOT / "tests/workflow/tiny.yaml"

pytestmark = pytest.mark.slow


def checkout(folder: Path) -> Path:
    """What a run needs of the project, copied to a folder."""
    shutil.copy(ROOT / "Snakefile", folder)
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(TINY, folder / "tiny.yaml")
    return folder


def snakemake(
    folder: Path,
    *arguments: str,
    cores: int = 2,
    config: str = "tiny.yaml",
    environment: dict | None = None,
    profile: str = "workflow/profiles/default",
    python: str = sys.executable,
):
    """Run the project's Snakefile in a folder; the completed process."""
    command = [
        python, "-m", "snakemake", "--workflow-profile", profile,
        "--configfile", config, "--cores", str(cores), *arguments,
    ]  # fmt: skip
    return subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"OMP_NUM_THREADS": "1"} | (environment or {}),
    )


def planned(folder: Path, *targets: str, **settings) -> dict[str, int]:
    """Jobs that a dry run would do, by rule."""
    answer = snakemake(folder, "--dry-run", "--quiet", "rules", *targets, **settings)
    assert answer.returncode == 0, answer.stderr
    listing = snakemake(folder, "--dry-run", *targets, **settings).stdout
    table = re.search(r"job\s+count\n[-\s]+\n(.*?)\n\n", listing, re.S)
    if table is None:
        return {}
    rows = (line.split() for line in table.group(1).splitlines())
    return {name: int(count) for name, count in rows if name not in ("total", "all")}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("two_cores"))
    answer = snakemake(folder)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return folder


def test_kernels_are_compiled_by_the_job_that_is_there_for_it_and_by_no_other(tmp_path):
    folder = checkout(tmp_path)
    answer = snakemake(folder, environment={"JOINTCLOSURE_CACHE": str(tmp_path / "cold")})
    assert answer.returncode == 0, answer.stdout + answer.stderr
    printed = answer.stdout + answer.stderr  # where its job announces it, for the user to see
    assert printed.count("compiling kernels") == 1
    logs = (folder / "results/tiny/logs").rglob("*.log")
    assert not [log.name for log in logs if "compiling kernels" in log.read_text()]


def test_the_run_writes_what_the_readme_promises(study):
    results = study / "results/tiny"
    tables = {path.name for path in (results / "tables").iterdir()}
    assert tables == {
        "table_1_rocks.csv", "table_2_cases.csv", "table_3_indifference.csv",
        "table_3_indifference.tex", "table_3_indifference.md", "correlations.csv",
        "max_closure.csv", "claims.csv", "claim_margins.csv", "checks.csv", "table_3_predictive.csv",
        "table_3_joint_tests.csv", "elasticities.csv", "configuration.json",
    }  # fmt: skip
    figures = {path.stem for path in (results / "figures").iterdir()}
    assert figures == {
        "fig_3_equivalent_stress", "fig_5_closure", "closure_since_seating", "wall_pair",
        "table_3_intervals", "trends_max_closure", "table_3_predictive",
    }  # fmt: skip
    for path in (results / "figures").iterdir():
        assert path.stat().st_size > 5000
    table = pd.read_csv(results / "tables/table_3_indifference.csv")
    assert {"rock", "parameter", "cycle", "length", "unit", "percent", "root", "extrapolated",
            "status", "paper_length", "paper_percent", "length_net"} <= set(table.columns)  # fmt: skip
    assert len(table) == 8
    checks = pd.read_csv(results / "tables/checks.csv")
    assert checks.passed.all()
    assert set(checks.ensemble) == {"cases", "pool"}


SMALLEST = """study: {name: smallest, rocks: [slate], realizations: 2, pool: %s, cycles: %d}
grid: {cells_x: 3, cells_y: 3}
surface: {roll_off_mm: null}
rocks:
  slate:
    max_normal_stress_MPa: 1
    levels: {poisson_ratio: null, youngs_modulus_GPa: null, jrc: [5, 8]}
statistics: {bootstrap_resamples: 10, repetitions: 100, control_variates: 100}
output: {stress_points: 2}
"""


@pytest.mark.parametrize(("pool", "cycles"), [("null", 1), ("2", 2)])
def test_the_smallest_legal_study_finishes(tmp_path, pool, cycles):
    folder = checkout(tmp_path)
    (folder / "smallest.yaml").write_text(SMALLEST % (pool, cycles))
    answer = snakemake(folder, config="smallest.yaml")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert (folder / "results/smallest/figures/table_3_intervals.png").is_file()


def test_the_dataset_has_coordinates_units_and_provenance(study):
    dataset = read_netcdf(study / "results/tiny/study.nc")
    assert dict(dataset.sizes) == {
        "case": 10, "realization": 3, "cycle": 2, "branch": 2, "stress": 5,
    }  # fmt: skip
    for variable in dataset.data_vars.values():
        assert variable.attrs["long_name"]
    for attribute in ("configuration", "root_seed", "source_digest", "provenance_commit",
                      "provenance_versions"):  # fmt: skip
        assert dataset.attrs[attribute]
    assert set(dataset.parameter.values) == {
        "base", "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc",
    }  # fmt: skip
    rises = np.diff(dataset.closure.sel(branch="loading").values, axis=-1)
    assert np.all(rises[np.isfinite(rises)] > 0.0)
    # only the last level may be missing, where the stress jumped over the target
    jumped = (dataset.status.values & 1).astype(bool)
    assert np.isfinite(rises[..., :-1]).all()
    assert np.isfinite(rises[~jumped]).all()


def finished_rules(folder: Path) -> list[str]:
    """Rules of the jobs of the last run, in the order in which they finished."""
    logs = (folder / ".snakemake/log").glob("*.log")
    last = max(logs, key=lambda log: log.stat().st_mtime)
    return re.findall(r"Finished jobid: \d+ \(Rule: (\w+)\)", last.read_text())


@pytest.mark.parametrize("cores", [1, 2])
def test_a_second_run_on_one_core_or_two_gives_the_same_bits(study, tmp_path, cores):
    folder = checkout(tmp_path)
    answer = snakemake(folder, cores=cores)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    if cores == 1:  # tables and figures of the study itself come before the closures of its pool
        rules = finished_rules(folder)
        complete = max(rules.index("write_tables"), rules.index("draw_figures"))
        assert rules.index("close_study") < complete < rules.index("close_pool")
    found = studies_command("compare", "--exact", study / "results/tiny", folder / "results/tiny")
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout == "identical except for provenance and timing\n"
    first, again = (where / "results/tiny" for where in (study, folder))
    tables = sorted(path.name for path in (first / "tables").iterdir())
    assert tables == sorted(path.name for path in (again / "tables").iterdir())
    for name in tables:
        assert (again / "tables" / name).read_bytes() == (first / "tables" / name).read_bytes(), (
            name
        )


def studies_command(*words):
    command = [sys.executable, "-m", "studies", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_study_with_flow_has_its_apertures_in_dataset_table_figure_and_report(tmp_path):
    folder = checkout(tmp_path)
    with (folder / "tiny.yaml").open("a") as file:
        file.write("flow: true\n")
    answer = snakemake(folder, "all", "report")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    results = folder / "results/tiny"
    dataset = read_netcdf(results / "study.nc")
    assert dataset.hydraulic_aperture.attrs["units"] == "m"
    table = pd.read_csv(results / "tables/hydraulic_aperture.csv")
    assert len(table) == 10 * 2 * 2 * 2 * 5
    assert (results / "figures/hydraulic_aperture.png").stat().st_size > 5000
    page = (results / "report.html").read_text()
    assert 'id="flow"' in page
    assert 'id="figure-hydraulic_aperture"' in page


def test_nothing_is_left_to_do_after_a_run(study):
    assert planned(study) == {}


def test_the_report_is_a_page_with_every_figure(study):
    answer = snakemake(study, "report")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    page = (study / "results/tiny/report.html").read_text(encoding="utf-8")
    for figure in (study / "results/tiny/figures").glob("*.png"):
        assert f'id="figure-{figure.stem}"' in page
        assert base64.b64encode(figure.read_bytes()).decode() in page
    assert planned(study) == {}
    # the study is not the paper's, and the page says in what
    assert "<code>study.realizations</code>" in page


def files_kept(folder: Path, config: str) -> tuple[set[str], set[str]]:
    """Files of the cache that a configuration keeps, and those that it makes, by name."""
    configured = checked_study(read_plain(folder / config))
    entries = cached(configured, "cases").items()
    kept = {name for name, entry in entries if is_kept(entry, folder / "results/tiny")}
    names = {name: name.partition("/")[2] for name, _ in entries}
    return {names[n] for n in kept}, {names[n] for n in names if n not in kept}


def test_editing_one_case_reruns_that_case_alone(study):
    text = TINY.read_text().replace("      jrc: [5, 8, 9]", "      jrc: [5, 8, 9.5]")
    (study / "edited.yaml").write_text(text)
    jobs = planned(study, config="edited.yaml")
    assert jobs["close_study"] == jobs["close_pool"] == 1
    kept, missing = files_kept(study, "edited.yaml")
    assert missing == {"slate-jrc-level_3.0"}
    assert len(kept) == 9


def test_editing_one_rock_leaves_the_others_alone(study):
    two = TINY.read_text().replace("rocks: [slate]", "rocks: [slate, dolerite]")
    two = two.replace(
        "  slate:\n", "  dolerite: {max_normal_stress_MPa: 1, levels: {jrc: [6, 10]}}\n  slate:\n"
    )
    (study / "two.yaml").write_text(two)
    kept, missing = files_kept(study, "two.yaml")
    assert {name.split("-")[0] for name in missing} == {"dolerite"}
    assert len(kept) == 10


def test_an_edit_of_the_statistics_reruns_what_reads_them_and_nothing_else(study):
    text = TINY.read_text().replace("bootstrap_resamples: 10", "bootstrap_resamples: 12")
    (study / "edited.yaml").write_text(text)
    jobs = planned(study, config="edited.yaml")
    intervals = {"find_indifference_intervals", "write_tables", "draw_figures"}
    assert set(jobs) == intervals | {"state_configuration"}


def test_a_bad_configuration_is_refused_before_any_job(study):
    (study / "bad.yaml").write_text("grid: {cells_x: 2, spcing_mm: 1}\n")
    answer = snakemake(study, config="bad.yaml")
    assert answer.returncode != 0
    printed = answer.stdout + answer.stderr
    assert "grid.cells_x = 2: must be at least 3" in printed
    assert "grid.spcing_mm = 1: unknown key; did you mean spacing_mm?" in printed
