"""Commands that read a finished study: none reads a file that is not the one its job wrote."""

import pytest
import xarray as xr

from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main
from studies.frame.seals import write_seal

COMMANDS = {"compare": ["the other study"], "engineering": [], "report": []}


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
