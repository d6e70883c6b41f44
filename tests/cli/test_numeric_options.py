"""Every numeric option of every command has its range: beyond it one line names the option."""

import argparse

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.cli import COMMANDS
from jointclosure.cli import main as cli
from jointclosure.cli.options import numbers
from tests.joints import SPACING
from tests.measured.test_calibration import GOOD

SCANS = ["--units", "mm", "--spacing", "0.25"]
LOAD = ["--rock", "granite", "--stress", "1"]
WORDS = {
    "close": ["upper.npy", "lower.npy", *SCANS, *LOAD],
    "simulate": ["--jrc", "8", "--cells", "8", *LOAD],
    "fit": ["lab.csv", "--rock", "granite", "--jrc", "8", "--cells", "16"],
    "roughness": ["upper.npy", *SCANS],
}
"""Words of each command that has numeric options, with which it would work."""
MODEL = (*jc.Rock._fields, *jc.Choices._fields, *jc.Numerics._fields)


def numeric_options() -> list[tuple[str, argparse.Action]]:
    """Options of all commands that take numbers."""
    found = []
    for name in COMMANDS:
        actions = cli.parser([name])._subparsers._group_actions[0].choices[name]._actions
        found += [
            (name, action)
            for action in actions
            if not action.dest.startswith("most_")  # any positive number is allowed
            and (name == "simulate" or action.dest not in MODEL)  # one declaration for all
            and (action.type in (int, float) or getattr(action.type, "func", None) is numbers)
        ]
    return found


OPTIONS = numeric_options()


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder with scans and a measured curve."""
    folder = tmp_path_factory.mktemp("inputs")
    upper, lower = jc.wall_pair(9.0, (64, 64), SPACING, seed=4, correlation=0.9)
    np.save(folder / "upper.npy", 0.6 - 1e3 * upper)
    np.save(folder / "lower.npy", 1e3 * lower)
    (folder / "lab.csv").write_text(GOOD)
    return folder


def test_every_command_with_numeric_options_is_tried():
    assert {name for name, _ in OPTIONS} == set(WORDS)


@pytest.mark.parametrize("value", ["nan", "-1", "1e300"])
@pytest.mark.parametrize(
    ("command", "option"), OPTIONS, ids=[f"{name} {a.option_strings[0]}" for name, a in OPTIONS]
)
def test_a_number_beyond_its_range_is_refused_in_one_line(
    inputs, monkeypatch, capsys, command, option, value
):
    monkeypatch.chdir(inputs)
    name = option.option_strings[0]
    if (command, name, value) == ("simulate", "--seed", "1e300"):
        value = "x"
    before = sorted(inputs.iterdir())
    try:
        code = cli.main([command, *WORDS[command], f"{name}={value}"])
    except SystemExit as ended:
        code = ended.code
    printed = capsys.readouterr()
    assert code == 2, printed.out
    assert printed.err.count("\n") == 1
    assert any(word in printed.err for word in (name, name.strip("-"), option.dest))
    assert sorted(inputs.iterdir()) == before, "something was written"
