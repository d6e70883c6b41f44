"""Seals: only the file that a job wrote, with these settings and from these files, is read."""

import json
import shutil
from types import SimpleNamespace

import pytest
import xarray as xr

from jointclosure.storage.netcdf import write_netcdf
from studies.frame.jobs import seals
from studies.frame.jobs.job import job
from studies.frame.jobs.seals import ForeignFileError, settings_digest


class Named(list):
    """As Snakemake gives inputs and outputs: a list whose parts may have names."""

    def __init__(self, parts: dict):
        flat = [p for part in parts.values() for p in ([part] if isinstance(part, str) else part)]
        super().__init__(flat)
        self.get = parts.get


class Log(list):
    """As Snakemake gives logs, of which one has a name."""

    @property
    def benchmark(self) -> str:
        return self[0].replace(".log", ".tsv")


def run(folder, rule, inputs, outputs, work, sealed_by=(), **params):
    """Run a job as Snakemake would, in `folder`."""
    (folder / "seals").mkdir(parents=True, exist_ok=True)
    (folder / "logs").mkdir(exist_ok=True)
    (folder / "tables").mkdir(exist_ok=True)
    wrapped = SimpleNamespace(
        input=Named(
            {"files": inputs, "seals": [str(folder / f"seals/{s}.json") for s in sealed_by]}
        ),
        output=Named({"files": outputs, "seal": str(folder / f"seals/{rule}.json")}),
        params=params,
        rule=rule,
        log=Log([str(folder / f"logs/{rule}.log")]),
    )
    with job(wrapped):
        work()


def make_study(folder, value: float, **settings):
    """A dataset, and a table of it."""
    study, table = folder / "study.nc", folder / "tables/a.csv"
    dataset = xr.Dataset({"x": ("n", [value, value])})
    run(folder, "aggregate", [], [str(study)], lambda: write_netcdf(dataset, study), **settings)
    make_table(folder, f"x\n{value}\n", **settings)
    return study, table


def make_table(folder, text, **settings):
    table = folder / "tables/a.csv"
    run(
        folder, "fit", [str(folder / "study.nc")], [str(table)], lambda: table.write_text(text),
        ["aggregate"],
    )  # fmt: skip


def unmet(folder, **settings):
    """Reasons why seals of a study are not met, where its dataset has these settings."""
    expected = {folder / "seals/aggregate.json": settings_digest(settings)}
    return [reason for _, reason in seals.unmet_seals(folder, lambda seal: expected.get(seal, ""))]


def judge(folder):
    """A job that reads both; it must not run on files that it does not belong to."""
    output = folder / "tables/b.csv"
    run(
        folder, "judge", [str(folder / "study.nc"), str(folder / "tables/a.csv")], [str(output)],
        lambda: output.write_text("read\n"), ["aggregate", "fit"],
    )  # fmt: skip


@pytest.fixture
def mine(tmp_path):
    folder = tmp_path / "results/mine"
    make_study(folder, 1.0, jrc=8)
    return folder


@pytest.fixture
def other(tmp_path):
    folder = tmp_path / "results/other"
    make_study(folder, 2.0, jrc=9)
    return folder


def test_what_is_as_it_was_made_is_read(mine):
    judge(mine)
    assert (mine / "tables/b.csv").read_text() == "read\n"
    assert unmet(mine, jrc=8) == []


def foreign_dataset(mine, other):
    shutil.copy2(other / "study.nc", mine / "study.nc")
    return "study.nc: the file is not as jointclosure wrote it"


def foreign_dataset_with_its_seal(mine, other):
    shutil.copy2(other / "study.nc", mine / "study.nc")
    shutil.copy2(other / "seals/aggregate.json", mine / "seals")
    return "study.nc: the file was made with other settings"


def foreign_study(mine, other):
    shutil.rmtree(mine)
    shutil.copytree(other, mine)
    return "study.nc: the file was made with other settings"


def edited_table(mine, other):
    (mine / "tables/a.csv").write_text("x\n1.5\n")
    return "a.csv: the file is not as jointclosure wrote it"


def emptied_table(mine, other):
    (mine / "tables/a.csv").write_text("")
    return "a.csv: the file is not as jointclosure wrote it"


def foreign_table(mine, other):
    shutil.copy2(other / "tables/a.csv", mine / "tables/a.csv")
    return "a.csv: the file is not as jointclosure wrote it"


def foreign_table_with_its_seal(mine, other):
    shutil.copy2(other / "tables/a.csv", mine / "tables/a.csv")
    shutil.copy2(other / "seals/fit.json", mine / "seals")
    return "a.csv: the file was made from another"


def edited_seal(mine, other):
    (mine / "seals/fit.json").write_text("{")
    return "fit.json: is not a seal"


ATTACKS = [
    foreign_dataset,
    foreign_dataset_with_its_seal,
    foreign_study,
    edited_table,
    emptied_table,
    foreign_table,
    foreign_table_with_its_seal,
    edited_seal,
]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_no_job_reads_a_file_of_another_study_or_a_changed_one(mine, other, attack):
    message = attack(mine, other)
    reasons = unmet(mine, jrc=8)
    assert any(message in reason for reason in reasons)
    assert all("\n" not in reason for reason in reasons)
    if attack is not foreign_study:  # which is whole: only its settings differ
        with pytest.raises(ForeignFileError):
            judge(mine)
        assert not (mine / "tables/b.csv").exists()


def test_a_table_without_a_seal_is_not_read(mine):
    (mine / "tables/c.csv").write_text("x\n3\n")
    with pytest.raises(ForeignFileError, match=r"c.csv: no seal lists"):
        run(mine, "read", [str(mine / "tables/c.csv")], [], lambda: None, ["aggregate", "fit"])


def test_inputs_from_outside_of_the_results_need_no_seal(mine, tmp_path):
    (tmp_path / "paper.csv").write_text("x\n3\n")
    run(mine, "read", [str(tmp_path / "paper.csv")], [], lambda: None)


def test_a_folder_is_whole_or_an_error(mine):
    assert {path.name for path in seals.check_folder(mine)} == {"study.nc", "a.csv"}
    (mine / "tables/a.csv").unlink()
    with pytest.raises(ForeignFileError, match=r"a.csv: is missing"):
        seals.check_folder(mine)


def test_a_folder_that_was_moved_is_the_same_study(mine, tmp_path):
    shutil.move(mine, tmp_path / "elsewhere")
    assert len(seals.check_folder(tmp_path / "elsewhere")) == 2


def test_a_seal_says_what_a_file_was_made_from(mine):
    printed = json.loads((mine / "seals/fit.json").read_text())
    assert list(printed["files"]) == ["tables/a.csv"]
    assert list(printed["made_from"]) == ["study.nc"]
