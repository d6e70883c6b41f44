"""`jointclosure validate` prints and writes what the library finds."""

import json

import pandas as pd

import jointclosure as jc

SMALL = ["--rock", "granite", "--jrc", "10", "--cells", "12", "--surfaces", "4"]


def test_the_command_finds_what_the_library_does_and_keeps_its_joints(inputs, tmp_path, command):
    folder = tmp_path / "region"
    words = [inputs / "lab.csv", *SMALL, "--output", folder]
    code, out, err = command("validate", *words)
    assert (code, err) == (0, "")
    assert "96 joints are closed, as far as they are not kept" in out
    stated = {"rock": "granite", "jrc": 10.0, "shape": (12, 12), "surfaces": 4}
    lines = []
    stated |= {"cache": folder / "joints", "report": lines.append}
    found = jc.validate(inputs / "lab.csv", **stated)
    assert not any(line.startswith("closed") for line in lines)  # by the command
    assert all(f"- {line}" in out for line in found.sentences())
    pd.testing.assert_frame_equal(pd.read_csv(folder / "region.csv"), found.table(), rtol=1e-9)
    record = json.loads((folder / "region.json").read_text())
    assert record["found"] == found.sentences()
    assert json.loads(record["provenance"]["settings"])["shape"] == [12, 12]
    assert (folder / "region.png").stat().st_size > 20000
