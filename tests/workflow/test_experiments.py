"""Every experiment as a study of seconds: its files are there, and nothing is done twice."""

import re
import shutil

import pytest

from jointclosure.engine.points import as_table, joints_of
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv
from studies.frame.config.files import read_plain
from studies.frame.config.model import sections
from studies.frame.experiments import experiments_in
from tests.studied import checked_study
from tests.workflow.test_pipeline import ROOT, checkout, snakemake

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=sections())
def experiment(request, tmp_path_factory):
    """Name, design and folder of an experiment that was run."""
    name, config = request.param, f"tiny_{request.param}.yaml"
    folder = checkout(tmp_path_factory.mktemp(name))
    shutil.copy(ROOT / "tests/workflow" / config, folder)
    configured = checked_study(read_plain(folder / config))
    design = experiments_in(configured.keys)[name].design(configured)
    estimated = snakemake(folder, f"estimate_{name}", config=config)
    assert estimated.returncode == 0, estimated.stdout + estimated.stderr
    joints = sum(sample.joints for samples in design.timed().values() for sample in samples)
    assert f"{joints} joints will take about" in estimated.stderr
    answer = snakemake(folder, name, config=config)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return name, design, folder


def closed_jobs(experiment) -> list[str]:
    """Jobs whose joints were closed: all."""
    name, design, folder = experiment
    closed = [
        job for job in design.jobs if (folder / f"results/tiny_{name}/{name}/{job}.nc").exists()
    ]
    assert closed == list(design.jobs)
    return closed


def test_every_joint_table_and_figure_is_there(experiment):
    name, design, folder = experiment
    results = folder / f"results/tiny_{name}"
    dataset = read_netcdf(results / f"{name}.nc")
    assert "configuration" in dataset.attrs
    joints = as_table(dataset)
    points = [point for job in closed_jobs(experiment) for point in design.jobs[job]]
    assert len(joints) == sum(joints_of([point]) * point.settings.cycles for point in points)
    for table in design.tables:
        if table.endswith(".md"):
            assert (results / f"tables/{table}").read_text().count("|") > 10
        else:
            assert len(read_csv(results / f"tables/{table}.csv")) > 0
    for figure in design.figures:
        assert (results / f"figures/{figure}.png").stat().st_size > 10000


def test_nothing_is_done_twice_and_what_is_lost_alone_is_made_again(experiment):
    name, design, folder = experiment
    assert "Nothing to be done" in dry_run(name, folder)
    results = folder / f"results/tiny_{name}"
    (results / f"{name}/{closed_jobs(experiment)[0]}.nc").unlink()
    (results / f"tables/{design.tables[0]}.csv").unlink()
    counts = dict(re.findall(r"^(close_\w+) +(\d+)$", dry_run(name, folder), re.M))
    assert counts == {f"close_{name}": "1"}


def dry_run(name: str, folder) -> str:
    """What Snakemake would do."""
    answer = snakemake(folder, name, "--dry-run", config=f"tiny_{name}.yaml")
    return answer.stdout + answer.stderr
