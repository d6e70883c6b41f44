"""Commands that read a finished study: none reads a file that is not as it was written."""

import pytest
import xarray as xr

from jointclosure.storage.files import write_text
from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main

COMMANDS = {"compare": ["the other study"], "engineering": [], "report": []}
OF_A_REPORT = ("configuration.json", "max_closure.csv", "checks.csv")


@pytest.mark.parametrize("command", COMMANDS)
def test_an_edited_study_is_refused(command, tmp_path, capsys):
    study = tmp_path / "study.nc"
    write_netcdf(xr.Dataset({"closure": 1.0}), study)
    (tmp_path / "tables").mkdir()
    for name in OF_A_REPORT:
        write_text("", tmp_path / "tables" / name)
    content = bytearray(study.read_bytes())
    content[len(content) // 2] ^= 1
    study.write_bytes(content)
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
