"""Every experiment as a study of seconds: its files are there, and nothing is done twice."""

import shutil

import pytest

from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.configuration import sections
from studies.frame.experiments import cached, experiment_named
from studies.frame.points import as_table, joints_of
from studies.frame.products import products_of
from tests.studied import ROOT, study_of, tiny
from tests.workflow.runs import checkout, planned, snakemake


@pytest.mark.slow
@pytest.mark.parametrize("name", sections())
def test_an_experiment_has_all_its_files_and_what_is_lost_alone_is_made_again(name, tmp_path):
    folder, config = checkout(tmp_path / name), f"tiny_{name}.yaml"
    shutil.copy(ROOT / "studies" / name / config, folder)
    study = study_of(tiny(name))
    design = experiment_named(name).design(study)
    joints = joints_of(design.points())
    assert f"{joints} joints will take about" in snakemake(folder, name, config=config)
    results = folder / f"results/tiny_{name}"
    dataset = read_netcdf(results / f"{name}.nc")
    assert "configuration" in dataset.attrs
    points = design.points()
    rows = sum(joints_of([point]) * point.settings.conditions.cycle_count for point in points)
    assert len(as_table(dataset)) == rows
    made = [results / f for one in products_of(name).values() for f in one.files(study)]
    for file in made:
        if file.suffix == ".md":
            assert file.read_text().count("|") > 10
        elif file.suffix == ".csv":
            assert len(read_csv(file)) > 0
        else:
            assert file.stat().st_size > 10000
    assert planned(folder, name, config=config) == {}
    for job in design.jobs():
        assert (results / f"{name}/{job}.nc").exists()
    made[0].unlink()
    assert f"close_{name}" not in planned(folder, name, config=config)
    (results / f"{name}.nc").unlink()
    assert planned(folder, name, config=config)[f"close_{name}"] == 1


def test_rows_that_are_added_close_no_others():
    section = "global_sensitivity"
    keys = tiny(section)
    few, many = (
        {name: entry.key for name, entry in cached(study_of(keys, more), section).items()}
        for more in ({}, {section: {"rows": 32}})
    )
    assert len(many) - len(few) == 4  # two new blocks of each rock
    assert few.items() <= many.items()
