"""Bad input of every command is one line that names it, before anything is computed or written."""

import argparse

import pytest

import jointclosure as jc
from jointclosure.cli import COMMANDS
from jointclosure.cli.main import parser
from jointclosure.cli.options import numbers

SCANS = ["top.xyz", "bottom.xyz", "--units", "mm", "--stress", 2]
GRANITE = ["--rock", "granite"]
FIT = ["lab.csv", *GRANITE, "--jrc", 10]
WALL = ["wall.npy", "--units", "mm"]
ARRAYS = ["top.npy", "bottom.npy", "--units", "mm,mm", "--scan-spacing", 0.25]
STRENGTH = ["--range", "compressive_strength_MPa"]


@pytest.fixture(autouse=True)
def nothing_is_computed(monkeypatch, inputs):
    monkeypatch.chdir(inputs)
    monkeypatch.setattr("jointclosure.joint.simulation.Simulation.run", None)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["close", *SCANS[:2], *GRANITE], "does not state the units"),
        (["close", "bottom.xyz", "top.xyz", *SCANS[2:], *GRANITE], "lies below the lower one in"),
        (["close", *SCANS, "--rock", "granit"], "--rock: invalid choice: 'granit' (choose"),
        (["close", *SCANS, *GRANITE, "--output", "no/where"], "no/where: folder no not found"),
        (["close", *SCANS, *GRANITE, "--range", "strength", 1, 2], "--range strength: must be one"),
        (["close", *SCANS, *GRANITE, *(2 * [*STRENGTH, 1, 2])], "MPa: must be given once"),
        (["close", *SCANS, *GRANITE, *STRENGTH, 1, 2, "--single"], "must be left out with single"),
        (
            ["close", *SCANS, *GRANITE, "--largest-radius", 0.05],
            "must be at least the grid spacing",
        ),
        (["simulate"], "(such as --rock granite): --youngs-modulus, --poisson-ratio"),
        (
            ["simulate", *GRANITE, "--jrc", 8, "--stress", 0],
            "(--stress) = 0 MPa: must be positive and finite",
        ),
        (
            ["simulate", *GRANITE, "--jrc", 8, "--stress", "5,6"],
            "(--stress) = [5, 6] MPa: maxima and minima",
        ),
        (
            ["simulate", "--rock", "slate", "--tolerance", 0.01],
            "tolerance = 0.01: has no effect",
        ),
        (["simulate", "--rock", "slate", "--output", "joint.txt"], "joint.txt: must end in .nc"),
        (["simulate", "--rock", "slate", "--snapshots", 1], "--snapshots: needs --output FILE.nc"),
        (["simulate", "--rock", "slate", "--rule", "x"], "--rule: invalid choice: 'x' (choose"),
        (["simulate", "--without", "gravity"], "(see jointclosure simulate --help)"),
        (
            ["simulate", "--rock", "slate", "--stress", 2, "--zzz"],
            "unrecognized arguments: --zzz (see jointclosure simulate --help)",
        ),
        (["simulate", "--rock", "slate", "--strss", 2], "--strss 2; did you mean --stress? (see"),
        (
            ["simulate", *GRANITE, "--jrc", 8, "--stress", 1, "--youngs-modulus", 52000],
            "--youngs-modulus 52000: not usual of rock (0.1 to 300 GPa); is 52 GPa meant?",
        ),
        (
            ["simulate", "--rock", "slate", "--stress", "5,0,1e7"],
            "--stress 1e+07: not usual of rock (0.001 to 1000 MPa); is 10 MPa meant?",
        ),
        (
            ["simulate", *GRANITE, "--jrc", 8, "--stress", 1, "--spacing", 2.5e-7],
            "--spacing 2.5e-07: not usual of rock (0.001 to 100 mm); is the unit right?",
        ),
        (["simulate", "--rock", "slate", "--stress=-5"], "--stress -5: must be positive"),
        (["fit", *FIT], "size: must be given"),
        (["fit", "lab.csv", "--jrc", "x"], "argument --jrc: 'x': must be numbers with commas"),
        (["validate", "none.csv", *FIT[1:], "--cells", 12], "none.csv: file not found"),
        (["roughness", *WALL, "--picture", "a.gif"], "a.gif: must end in .png"),
        (
            ["validate", *FIT, "--cells", 12, "--shifts", "0.5"],
            "shifts = 0.5: must be whole numbers",
        ),
        (["simulate", "--rock", "granit"], "; did you mean granite? (see"),
        (
            ["simulate", "--rock", "slate", "--without", "interactions"],
            "; did you mean interaction?",
        ),
        (["simulate", "--rock", "slate", "--jrc-relation", "yanng"], "; did you mean yang? (see"),
        (
            ["close", *ARRAYS, *GRANITE, "--range", "base_radius_in_cell", 0.3, 0.4],
            "; did you mean base_radius_in_cells?",
        ),
        (["simulte"], "; did you mean simulate? (see jointclosure --help)"),
        (["report", "."], "must be a folder that `jointclosure close` wrote"),
    ],
)
def test_what_is_wrong_is_one_line_that_names_it(words, message, command):
    code, _, err = command(*words)
    assert (code, err.count("\n")) == (2, 1)
    assert message in err


def test_all_wrong_options_of_a_command_are_listed_together(command):
    words = ["simulate", "--jrc", 8, "--youngs-modulus", 52000, "--strength", 1e5]
    code, _, err = command(*words)
    assert (code, err.count("\n")) == (2, 1)
    for text in ("--youngs-modulus 52000: not usual", "--strength 100000: not usual",
                 "without --rock (such as --rock granite): --poisson-ratio, --stress"):  # fmt: skip
        assert text in err
    both = ["--range", "strength", 1, 2, "--range", "spacing_mm", 1, "x"]
    _, _, err = command("close", *SCANS, *GRANITE, *both)
    assert "--range strength: must be one" in err
    assert "--range spacing_mm 1 x: must end in two numbers" in err


def test_a_wrong_spacing_or_unit_of_one_wall_is_named(command):
    files = ["top.npy", "bottom.npy", "--stress", 2, *GRANITE]
    _, _, err = command("close", *files, "--units", "um", "--scan-spacing", 0.25)
    assert "--scan-spacing, in mm), it may be wrong instead" in err
    for units in ("mm,inch", "mm,m"):
        code, _, err = command("close", *files, "--units", units, "--scan-spacing", 0.25)
        assert (code, err.count("\n")) == (2, 1)
        lower = units.partition(",")[2]
        assert f"stated as mm for the upper wall and {lower} for the lower one" in err


@pytest.mark.parametrize("name", ["fit", "validate"])
def test_a_load_in_kilonewtons_is_no_stress_without_its_area(tmp_path, command, name):
    """25 kN on 2500 mm2 are 10 MPa."""
    file = tmp_path / "load.csv"
    file.write_text("Time (s),Normal load (kN),Closure (mm)\n0,0,0\n1,12,.1\n2,25,.12\n")
    words = [name, file, *FIT[1:], "--cells", 12, "--columns", "2,3", "--stress-unit", "MPa"]
    code, _, err = command(*words)
    assert (code, err.count("\n")) == (2, 1)
    assert "'Normal load (kN)': kN is a unit of force; state the loaded area, --area" in err
    code, _, err = command(*words, "--area", 2500, "--seating", 10.5)
    assert (code, err.count("\n")) == (2, 1)
    assert "no stress of cycle 1 is above seating_stress_MPa = 10.5" in err
    code, _, err = command(*words, "--area", 2500, "--seating", 9.5, "--cells", 4)
    assert "shape = (4, 4): must be" in err


def test_what_close_is_not_given_is_refused_by_the_library_too(small_joint):
    with pytest.raises(jc.InputError, match=r"of type ndarray: must be a file.*simulate"):
        jc.close(*small_joint, rock="granite", max_normal_stress=1e6)
    about = {"units": "mm", "rock": "granite", "max_normal_stress": 2e6}
    with pytest.raises(jc.InputError, match=r"ranges: '?strength'?"):
        jc.close("top.xyz", "bottom.xyz", ranges={"strength": (1e8, 2e8)}, **about)


LOAD = [*GRANITE, "--stress", 1]
WORDS = {
    "close": [*ARRAYS, *LOAD],
    "assess": [*ARRAYS, *LOAD],
    "simulate": ["--jrc", 8, "--cells", 8, *LOAD],
    "fit": [*FIT, "--cells", 16],
    "validate": [*FIT, "--cells", 16],
    "roughness": [*WALL, "--scan-spacing", 0.25],
}
"""Words of each command that has numeric options, with which it would work."""
MODEL = (*jc.Rock._fields, *jc.Choices._fields, *jc.Numerics._fields)


def numeric_options() -> list[tuple[str, argparse.Action]]:
    """Options of all commands that take numbers; those of rock and model of one command."""
    found = []
    for name in COMMANDS:
        actions = parser([name])._subparsers._group_actions[0].choices[name]._actions
        found += [
            (name, action)
            for action in actions
            if not action.dest.startswith("most_")  # any positive number is allowed
            and (name == "simulate" or action.dest not in MODEL)  # one declaration for all
            and (action.type in (int, float) or numbers in getattr(action.type, "args", ()))
        ]
    return found


OPTIONS = numeric_options()


@pytest.mark.parametrize("value", ["nan", "-1", "1e300"])
@pytest.mark.parametrize(
    ("name", "option"), OPTIONS, ids=[f"{name} {a.option_strings[0]}" for name, a in OPTIONS]
)
def test_a_number_beyond_its_range_is_refused_in_one_line(inputs, command, name, option, value):
    word = option.option_strings[0]
    if (name, word, value) == ("simulate", "--seed", "1e300"):
        value = "x"
    before = sorted(inputs.iterdir())
    code, out, err = command(name, *WORDS[name], f"{word}={value}")
    assert (code, err.count("\n")) == (2, 1), out
    assert any(text in err for text in (word, word.strip("-"), option.dest))
    assert sorted(inputs.iterdir()) == before, "something was written"


@pytest.mark.parametrize("cycle", [0, 3])
def test_a_cycle_that_the_load_does_not_have_is_refused(cycle, command, tmp_path):
    words = ["simulate", "--rock", "dolerite", "--cells", "24x20", "--stress", 5]
    words += ["--tables", tmp_path / "t", "--export-cycle", cycle]
    code, out, err = command(*words)
    assert (code, out) == (2, "")
    assert f"--export-cycle {cycle}: must be a cycle of the load, 1 to 2" in err
