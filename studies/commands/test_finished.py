"""Commands that read a finished study: none reads a file that is not as it was written."""

import json
from pathlib import Path

import pytest
import xarray as xr

from jointclosure.storage.files import write_text
from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main
from studies.frame.configuration import configured, merged_study
from studies.frame.yaml_files import configuration_text

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


@pytest.mark.parametrize(
    ("accuracy", "words", "count"),
    [
        (None, [], 4),
        (None, ["--pool"], 6),
        ({"within": 0.05}, [], 30),
        ({"within": 0.05}, ["--finest"], 8),
    ],
)
@pytest.mark.parametrize("place", [-1, 0])
def test_a_realisation_that_a_study_does_not_have_is_not_closed(
    accuracy, words, count, place, tmp_path, capsys
):
    stated = merged_study(Path("config/default.yaml"), Path("config/smoke.yaml"))
    stated["study"]["accuracy"] = accuracy
    stated["statistics"]["control_variates"] = None
    for folder in ("tables", "accuracy"):
        (tmp_path / folder).mkdir()
    keys = configuration_text(configured(stated).stated)
    write_text(keys, tmp_path / "tables/configuration.json")
    for number, (cases, finest) in enumerate([(20, 4), (30, 8)]):
        plan = {"round": number, "cases": cases, "finest": finest, "ended": number == 1}
        write_text(json.dumps(plan), tmp_path / f"accuracy/round_{number}.json")
    number = -1 if place < 0 else count
    case = "dolerite-base"
    assert main(["repeat", *words, "--", str(tmp_path), case, str(number)]) == 2
    printed = capsys.readouterr().err
    assert f"has no realisation {number} of '{case}'" in printed
    assert f"it has {count} of each case" in printed
