"""`jointclosure fit` prints and writes what the library finds."""

import functools
import json
from unittest.mock import Mock

import pytest

import jointclosure as jc
from tests.joints import COARSE

SMALL = ["--rock", "granite", "--jrc", "10", "--cells", "12", "--surfaces", "4"]


def test_the_command_finds_what_the_library_does(inputs, tmp_path, command):
    words = [inputs / "lab.csv", *SMALL, "--tolerance", 0.1, "--output", tmp_path / "fitted"]
    code, out, err = command("fit", *words)
    assert (code, err) == (0, "")
    about = {"rock": "granite", "jrc": 10.0, "shape": (12, 12), "surfaces": 4}
    found = jc.fit(inputs / "lab.csv", **about, numerics=COARSE)
    assert all(f"- {line}" in out for line in found.sentences())
    record = json.loads((tmp_path / "fitted/fit.json").read_text())
    for name in ("p_value", "interval_holds", "assumed"):
        assert record[name] == getattr(found, name)
    assert found.assumed in out.splitlines()[0]
    assert record["compressive_strength_MPa"] is None
    assert json.loads(record["provenance"]["settings"])["shape"] == [12, 12]
    assert (tmp_path / "fitted/fit.png").stat().st_size > 20000


@pytest.mark.parametrize(
    ("words", "roll_off", "breakage"),
    [
        (["--roll-off", "2"], 2e-3, "resolved"),
        (["--breakage", "fixed_step", "--hurst", "0.7", "--surfaces", "8"], None, "fixed_step"),
    ],
)
def test_stated_assumptions_replace_the_usual_ones(
    inputs, monkeypatch, command, words, roll_off, breakage
):
    stopped = functools.wraps(jc.fit)(Mock(side_effect=jc.InputError("enough")))
    monkeypatch.setattr("jointclosure.cli.fit.fit", stopped)
    command("fit", inputs / "lab.csv", *SMALL, *words)
    settings = stopped.call_args.kwargs
    assert settings.get("roll_off") == roll_off
    assert settings["numerics"].breakage == breakage
