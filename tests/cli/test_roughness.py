"""`jointclosure roughness`, as a user calls it."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.cli.main import main
from tests.joints import SPACING


@pytest.fixture
def scan(tmp_path):
    wall = jc.wall_pair(9.0, (40, 48), SPACING, seed=1)[0]
    np.save(tmp_path / "scan.npy", 1e3 * wall)
    return tmp_path / "scan.npy"


def test_it_prints_each_measure_and_writes_table_and_picture(scan, tmp_path, capsys):
    table, picture = tmp_path / "measures.csv", tmp_path / "wall.png"
    words = ["--units", "mm", "--spacing", "0.25", "--table", table, "--picture", picture]
    assert main(["roughness", str(scan), *map(str, words)]) == 0
    printed = capsys.readouterr().out
    assert "40 x 48 cells (y, x) of 0.25 mm; mean plane removed" in printed
    frame = pd.read_csv(table).set_index("measure")
    for name in frame.index:
        assert name in printed
    assert frame.value["JRC, yu_vayssade_linear_0.25mm"] == pytest.approx(9.0, abs=0.2)
    assert picture.stat().st_size > 20000


@pytest.mark.parametrize(
    ("words", "printed"),
    [
        (["--units", "mm"], "scan.npy: does not state the spacing"),
        (["--units", "mm", "--spacing", "1", "--picture", "a.gif"], "a.gif: must end in"),
        (["--units", "mm", "--spacing", "1", "--grid-spacing", "4"], "measures need at least 24"),
    ],
)
def test_what_is_wrong_is_one_line(scan, words, printed, capsys):
    assert main(["roughness", str(scan), *words]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert printed in error


@pytest.mark.parametrize(("choice", "done"), [("keep", "were kept"), ("cut", "were cut")])
def test_spikes_are_told_and_cut_if_asked_for(choice, done, tmp_path, capsys):
    wall = 1e3 * jc.wall_pair(9.0, (40, 48), SPACING, seed=1)[0]
    wall[20, 21] += 2.0
    np.save(tmp_path / "a.npy", wall)
    words = ["--units", "mm", "--spacing", "0.25", "--spikes", choice]
    assert main(["roughness", str(tmp_path / "a.npy"), *words]) == 0
    printed = capsys.readouterr().out
    assert "1 of 1920 points are spikes" in printed
    assert "at (x, y) = (5.25, 5) mm" in printed
    assert done in printed
    assert ("1 of them without a height" in printed) == (choice == "cut")
