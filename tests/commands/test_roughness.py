"""`jointclosure roughness`, as a user calls it."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.cli import main
from tests.conftest import SPACING


@pytest.fixture
def scan(tmp_path):
    wall = jc.wall_pair(9.0, (40, 48), SPACING, seed=1)[0]
    np.save(tmp_path / "scan.npy", 1e3 * wall)
    return tmp_path / "scan.npy"


def test_it_prints_each_measure_and_writes_table_and_picture(scan, tmp_path, capsys):
    table, picture = tmp_path / "measures.csv", tmp_path / "wall.png"
    words = ["--units", "mm", "--spacing", "0.25", "--table", table, "--picture", picture]
    assert main(["roughness", str(scan), *map(str, words)]) == 0
    said = capsys.readouterr().out
    assert "40 x 48 cells (y, x) of 0.25 mm; mean plane removed" in said
    frame = pd.read_csv(table).set_index("measure")
    for name in frame.index:
        assert name in said
    assert frame.value["JRC, yu_vayssade_linear_0.25mm"] == pytest.approx(9.0, abs=0.2)
    assert picture.stat().st_size > 20000


def test_another_grid_spacing_is_used_if_asked_for(scan, capsys):
    words = ["--units", "mm", "--spacing", "0.1", "--grid-spacing", "0.15"]
    assert main(["roughness", str(scan), *words]) == 0
    assert "27 x 32 cells (y, x) of 0.15 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "scan.npy: does not say the units of its heights: give them (units)"),
        (["--units", "mm"], "scan.npy: does not say the spacing"),
        (["--units", "mm", "--spacing", "-1"], "--spacing -1.0: must be a positive number"),
        (["--units", "mm", "--spacing", "1", "--picture", "a.gif"], "a.gif: its name must end in"),
        (
            ["--units", "mm", "--spacing", "1", "--table", "no/a.csv"],
            "no/a.csv: there is no folder no",
        ),
        (
            ["--units", "mm", "--spacing", "1", "--grid-spacing", "0.5"],
            "scan.npy: grid spacing 0.5 mm",
        ),
        (["--units", "mm", "--spacing", "1", "--grid-spacing", "4"], "measures need at least 24"),
    ],
)
def test_what_is_wrong_is_one_line(scan, words, said, capsys):
    assert main(["roughness", str(scan), *words]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error


def test_a_flat_wall_has_no_roughness(tmp_path, capsys):
    np.save(tmp_path / "flat.npy", np.ones((30, 30)))
    words = ["--units", "m", "--spacing", "1"]
    assert main(["roughness", str(tmp_path / "flat.npy"), *words]) == 2
    assert "there is no roughness" in capsys.readouterr().err
