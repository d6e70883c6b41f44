"""A file in the results that is not the one of this configuration is made again, never read."""

import json
import shutil
from pathlib import Path

import pytest

from jointclosure.storage.netcdf import read_netcdf
from tests.workflow.test_pipeline import TINY, checkout, planned, snakemake, studies_command

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """Two finished studies in one folder; the other's JRC has other levels."""
    folder = checkout(tmp_path_factory.mktemp("foreign"))
    text = (
        TINY.read_text()
        .replace("name: tiny", "name: other")
        .replace("jrc: [5, 8, 9]", "jrc: [6, 9]")
    )
    (folder / "other.yaml").write_text(text)
    for config in ("other.yaml", "tiny.yaml"):
        answer = snakemake(folder, config=config)
        assert answer.returncode == 0, answer.stdout + answer.stderr
    return folder


@pytest.fixture
def copied(studies, tmp_path):
    folder = tmp_path / "copied"
    shutil.copytree(studies, folder, symlinks=True)
    return folder


def foreign_dataset(mine: Path, other: Path):
    shutil.copy(other / "study.nc", mine / "study.nc")


def foreign_dataset_of_the_same_age(mine: Path, other: Path):
    times = (mine / "study.nc").stat()
    shutil.copy(other / "study.nc", mine / "study.nc")
    import os

    os.utime(mine / "study.nc", ns=(times.st_atime_ns, times.st_mtime_ns))


def whole_foreign_study(mine: Path, other: Path):
    for name in ("study.nc", "pool.nc", "predictive.nc", "tables", "figures", "seals"):
        there, here = other / name, mine / name
        if there.is_dir():
            shutil.copytree(there, here, dirs_exist_ok=True)
        else:
            shutil.copy2(there, here)


def edited_claims(mine: Path, other: Path):
    text = (mine / "tables/claims.csv").read_text()
    (mine / "tables/claims.csv").write_text(text.replace("undecided", "stands"))


def emptied_table_3(mine: Path, other: Path):
    (mine / "tables/table_3_indifference.csv").write_text("")


def swapped_tables(mine: Path, other: Path):
    one, two = mine / "tables/max_closure.csv", mine / "tables/correlations.csv"
    text = one.read_bytes()
    one.write_bytes(two.read_bytes())
    two.write_bytes(text)


def foreign_figure(mine: Path, other: Path):
    shutil.copy2(other / "figures/fig_5_closure.png", mine / "figures/fig_5_closure.png")


ATTACKS = [
    foreign_dataset,
    foreign_dataset_of_the_same_age,
    whole_foreign_study,
    edited_claims,
    emptied_table_3,
    swapped_tables,
    foreign_figure,
]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_what_is_not_of_this_configuration_is_made_again(studies, copied, attack):
    mine, other, intact = (
        copied / "results/tiny",
        copied / "results/other",
        studies / "results/tiny",
    )
    attack(mine, other)
    refused = studies_command("report", mine, "--output", copied / "page.html")
    if attack is not whole_foreign_study:  # which is whole, and of another study
        assert refused.returncode == 2
        assert "Traceback" not in refused.stderr
        assert len(refused.stderr.splitlines()) == 1
        assert not (copied / "page.html").exists()
    answer = snakemake(copied)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "jointclosure: results/tiny/" in answer.stderr
    found = studies_command("compare", "--exact", mine, intact)
    assert found.returncode == 0, found.stdout + found.stderr
    for folder in ("tables", "figures"):
        for file in sorted((intact / folder).iterdir()):
            assert (mine / folder / file.name).read_bytes() == file.read_bytes(), file.name
    assert planned(copied) == {}


def test_a_job_that_is_called_alone_does_not_read_a_foreign_dataset(copied):
    mine, other = copied / "results/tiny", copied / "results/other"
    shutil.copy(other / "study.nc", mine / "study.nc")
    shutil.copy(other / "seals/close_study.json", mine / "seals")
    (mine / "tables/max_closure.csv").unlink()
    answer = snakemake(copied, "--", "results/tiny/tables/max_closure.csv")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    printed = json.loads(read_netcdf(mine / "study.nc").attrs["configuration"])
    assert printed["study"]["name"] == "tiny"


def test_a_finished_study_of_another_machine_is_reported_without_running_anything(
    studies, tmp_path
):
    there = tmp_path / "anywhere"
    shutil.copytree(studies / "results/tiny", there)
    shutil.rmtree(there / "cases")
    shutil.rmtree(there / "pool")
    answer = studies_command("report", there)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    page = (there / "report.html").read_text(encoding="utf-8")
    assert snakemake(studies, "report").returncode == 0
    made = (studies / "results/tiny/report.html").read_text(encoding="utf-8")

    def without_times(text: str) -> str:
        """The page without the table of the jobs' times, which the report's own job enters."""
        return text.split('id="jobs"')[0].split("job_time")[0][:200_000]

    assert len(page) > 0.9 * len(made)
    for figure in (there / "figures").glob("*.png"):
        assert f'id="figure-{figure.stem}"' in page
    assert without_times(page) == without_times(made)
