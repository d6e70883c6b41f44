"""Commands that read a finished study: none reads a file that is not the one its job wrote."""

import json

import pytest
import xarray as xr

from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main
from studies.frame.cases import pool_of
from studies.frame.jobs import write_seal
from tests.studied import study_of
from tests.world import world

COMMANDS = {"plan": ["--standard-error", "0.01"], "compare": ["the other study"]}
COMMANDS |= {"engineering": [], "report": []}


@pytest.mark.parametrize("command", COMMANDS)
def test_an_edited_study_is_refused(command, tmp_path, capsys):
    study = tmp_path / "study.nc"
    write_netcdf(xr.Dataset({"closure": 1.0}), study)
    (tmp_path / "seals").mkdir()
    write_seal(tmp_path / "seals/aggregate.json", [str(study)], {}, [])
    write_netcdf(xr.Dataset({"closure": 2.0}), study)  # whole, and another one
    assert main([command, str(tmp_path), *COMMANDS[command]]) == 2
    printed = capsys.readouterr().err
    assert str(study) in printed
    assert "not as jointclosure wrote it" in printed


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_without_a_study_is_named(command, tmp_path, capsys):
    assert main([command, str(tmp_path), *COMMANDS[command]]) == 2
    printed = capsys.readouterr().err
    assert str(tmp_path) in printed
    assert "is the study finished?" in printed


# `python -m studies plan`: from the surfaces that belong to the study


SMALL = {"study": {"name": "small", "rocks": ["slate"], "realizations": 4, "pool": 6}}


@pytest.mark.parametrize(("pool", "planned"), [(6, "pool.nc"), (None, "study.nc")])
def test_a_study_is_planned_from_its_pool_and_not_from_one_left_by_another_configuration(
    pool, planned, tmp_path, capsys
):
    configuration = study_of(SMALL)
    for name, ensemble in (("study", configuration), ("pool", pool_of(configuration))):
        dataset = world(ensemble)
        dataset["bulk_indentation"] = 0.1 * dataset.closure
        dataset.attrs["configuration"] = json.dumps({"study": {"pool": pool}})
        write_netcdf(dataset, tmp_path / f"{name}.nc")
    assert main(["plan", str(tmp_path), "--standard-error", "0.01"]) == 0
    assert f"from {tmp_path / planned}\n" in capsys.readouterr().out
