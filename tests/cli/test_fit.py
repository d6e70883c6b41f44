"""`jointclosure fit`: what it says and writes is what the library finds."""

import json

import pytest

import jointclosure as jc
from jointclosure.cli import main as cli
from tests.measured.test_calibration import GOOD

SIZED = ["--rock", "granite", "--jrc", "10"]
SMALL = ["--rock", "granite", "--jrc", "10", "--cells", "12", "--surfaces", "4"]


def printed(capsys, *words):
    try:
        code = cli.main(["fit", *map(str, words)])
    except SystemExit as ended:
        code = ended.code
    return code, *capsys.readouterr()


@pytest.fixture
def curve(tmp_path):
    path = tmp_path / "lab.csv"
    path.write_text(GOOD)
    return path


def test_the_command_finds_what_the_library_does(curve, tmp_path, capsys):
    code, out, err = printed(capsys, curve, *SMALL, "--output", tmp_path / "fitted")
    assert (code, err) == (0, "")
    found = jc.fit(curve, rock="granite", jrc=10.0, shape=(12, 12), surfaces=4)
    assert all(f"- {line}" in out for line in found.sentences())
    record = json.loads((tmp_path / "fitted/fit.json").read_text())
    assert record["found"] == found.sentences()
    assert record["p_value"] == found.p_value
    assert record["interval_holds"] == found.interval_holds
    assert out.startswith("assumed (")
    assert found.assumed in out.splitlines()[0]
    assert record["compressive_strength_MPa"] is None
    assert json.loads(record["provenance"]["settings"])["shape"] == [12, 12]
    assert (tmp_path / "fitted/fit.png").stat().st_size > 20000


@pytest.mark.parametrize(
    ("words", "roll_off", "breakage"),
    [
        ([], None, "resolved"),
        (["--roll-off", "2"], 2e-3, "resolved"),
        (["--breakage", "fixed_step", "--hurst", "0.7", "--surfaces", "8"], None, "fixed_step"),
    ],
)
def test_stated_assumptions_replace_those_of_scanned_joints(
    curve, tmp_path, capsys, words, roll_off, breakage
):
    printed(capsys, curve, *SMALL, *words, "--output", tmp_path / "fitted")
    record = json.loads((tmp_path / "fitted/fit.json").read_text())
    settings = json.loads(record["provenance"]["settings"])
    assert settings.get("roll_off") == roll_off
    assert settings["numerics"]["breakage"] == breakage


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["{}", "--rock", "granite"], "--jrc must be given"),
        (["{}", *SMALL, "--surfaces", "1"], "surfaces = 1: must be at least 4"),
        (["{}", "--rock", "granite", "--jrc", "10"], "--size: must be given"),
        (["{}", *SIZED, "--size", "nan"], "--size = nan mm: must be positive and finite"),
        (["{}", *SIZED, "--size", "25", "--spacing", "0"], "--spacing = 0.0 m: must be positive"),
        (["{}", "--jrc", "x"], "argument --jrc: 'x': must be numbers with commas"),
        (["{}", *SMALL, "--jrc", "1,2,3"], "jrc = (1.0, 2.0, 3.0): must be a number or"),
    ],
)
def test_what_is_missing_or_wrong_is_one_line(curve, capsys, words, message):
    code, _, err = printed(capsys, *(word.format(curve) for word in words))
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
