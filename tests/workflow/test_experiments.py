"""Every experiment as a study of seconds: what is planned of it, and what it has in the end."""

import re
import shutil

import pytest

from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.configuration import sections
from studies.frame.experiments import experiment_named
from studies.frame.joint_tables import as_table
from tests.studied import ROOT, study_of, tiny
from tests.workflow.runs import checkout, planned, pretend, run_snakemake, snakemake


def experiment(folder, name: str):
    """A checkout with the small configuration of an experiment; its file and its results."""
    shutil.copy(ROOT / f"studies/{name}/tiny_{name}.yaml", checkout(folder))
    return f"tiny_{name}.yaml", folder / "results" / tiny(name)["study"]["name"]


def files_of(results, name: str) -> list:
    """Files of the joints of an experiment, its tables, and its figures."""
    study, of = study_of(tiny(name)), experiment_named(name)
    return [
        *(results / name / f"{job}.nc" for job in of.jobs(study)),
        *(results / "tables" / table for table in of.tables),
        *(
            results / "figures" / f"{figure}.{form}"
            for figure in of.figures
            for form in ("png", "pdf")
        ),
    ]


@pytest.fixture(scope="module")
def pretended_mismatch(tmp_path_factory):
    """The small study of mismatch, as finished, with empty files."""
    folder = tmp_path_factory.mktemp("mismatch") / "planned"
    config, _ = experiment(folder, "mismatch")
    pretend(folder, "mismatch", config=config)
    return folder


@pytest.fixture
def mismatch(pretended_mismatch, tmp_path):
    """A copy of it, to be changed: its folder, its results, and function that plans it."""
    folder = shutil.copytree(pretended_mismatch, tmp_path / "copied", symlinks=True)
    results = folder / "results" / tiny("mismatch")["study"]["name"]
    return folder, results, lambda: planned(folder, "mismatch", config="tiny_mismatch.yaml")


def mismatch_files(results, *kinds):
    return [file for file in files_of(results, "mismatch") if file.suffix in kinds]


def test_an_experiment_is_planned_by_jobs_tables_and_figures(mismatch):
    _, results, _ = mismatch
    jobs = mismatch_files(results, ".nc")
    assert all(file.is_file() for file in (*jobs, *mismatch_files(results, ".csv", ".md", ".png")))
    assert len(re.findall(r"\w+um", " ".join(file.name for file in jobs))) == 2


def test_a_table_that_is_lost_is_planned_without_joints(mismatch):
    _, results, plan = mismatch
    mismatch_files(results, ".csv", ".md")[0].unlink()
    lost = plan()
    assert (lost["tabulate_experiment"], "close_points" in lost) == (1, False)


def test_a_job_that_is_lost_with_a_table_is_planned_alone(mismatch):
    """While all tables are there, nothing needs the file of the job."""
    _, results, plan = mismatch
    mismatch_files(results, ".csv", ".md")[0].unlink()
    mismatch_files(results, ".nc")[0].unlink()
    assert plan()["close_points"] == 1


def test_a_wavelength_more_is_one_job_more(mismatch):
    """Besides one that is lost."""
    folder, results, plan = mismatch
    mismatch_files(results, ".nc")[0].unlink()
    config = folder / "tiny_mismatch.yaml"
    config.write_text(config.read_text().replace("[3, 1]", "[3, 2, 1]"))
    assert plan()["close_points"] == 2


def test_a_section_that_the_configuration_lacks_is_refused_in_a_line(tmp_path):
    refused = run_snakemake(checkout(tmp_path / "lacks"), "mismatch")
    assert refused.returncode != 0
    printed = refused.stdout + refused.stderr
    assert "mismatch: the configuration has no section of this name" in printed
    assert "Traceback (most recent call last)" not in printed


@pytest.fixture(scope="module", params=sections())
def finished(request, tmp_path_factory):
    """Name of an experiment, its finished folder, its configuration and its results."""
    folder = tmp_path_factory.mktemp("finished") / request.param
    config, results = experiment(folder, request.param)
    snakemake(folder, request.param, config=config)
    return request.param, folder, config, results


@pytest.mark.slow
def test_an_experiment_has_all_its_files(finished):
    name, _, _, results = finished
    study = study_of(tiny(name))
    for file in files_of(results, name):
        if file.suffix == ".md":
            assert file.read_text().count("|") > 10
        elif file.suffix == ".csv":
            assert len(read_csv(file)) > 0
        elif file.suffix == ".nc":
            joints = read_netcdf(file)
            assert "configuration" in joints.attrs
            points = experiment_named(name).jobs(study)[file.stem]
            rows = (p.settings.realizations * p.settings.conditions.cycle_count for p in points)
            assert len(as_table([joints])) == sum(rows)
        else:
            assert file.stat().st_size > 10000


@pytest.mark.slow
def test_an_experiment_is_done_once(finished):
    name, folder, config, _ = finished
    assert planned(folder, name, config=config) == {}


@pytest.mark.slow
def test_an_estimate_states_the_time_of_all_joints(tmp_path):
    config, results = experiment(tmp_path / "estimate", "mismatch")
    printed = snakemake(tmp_path / "estimate", "estimate", config=config)
    assert re.search(r"joints will take about", printed)
    assert len(read_csv(results / "tables/mismatch_estimate.csv")) > 0
    assert not (results / "mismatch").exists()


@pytest.mark.slow
def test_an_estimate_of_a_study_without_experiments_is_of_its_own_joints(tmp_path):
    folder = checkout(tmp_path / "estimate")
    printed = snakemake(folder, "estimate")
    (line,) = [line for line in printed.splitlines() if "joints will take about" in line]
    # 6 cases of 3 joints, and the same of the 4 joints of the pool
    assert "42 joints will take about" in line
    assert "minutes of processor time on this machine (± standard error, from 3 joints)" in line
    assert "the assessment of make report takes about" in line
    assert [path.name for path in (folder / "results/tiny/tables").iterdir()] == [
        "study_estimate.csv"
    ]
    assert not (folder / "results/tiny/cases").exists()
    table = folder / "results/tiny/tables/study_estimate.csv"
    written = table.stat().st_mtime_ns
    assert line in snakemake(folder, "estimate").splitlines()  # shown again, not computed again
    assert table.stat().st_mtime_ns == written


def test_a_row_more_of_a_sample_closes_no_former_joint():
    name = "global_sensitivity"
    few, many = (
        {job: repr(points) for job, points in experiment_named(name).jobs(study).items()}
        for study in (study_of(tiny(name)), study_of(tiny(name), {name: {"rows": 32}}))
    )
    assert few.items() <= many.items()
    assert len(many) - len(few) == 4  # two new blocks of each rock
