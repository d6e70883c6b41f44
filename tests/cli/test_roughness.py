"""`jointclosure roughness`: measures of a scan, and its spikes."""

import numpy as np
import pandas as pd
import pytest


def test_it_prints_every_measure_and_writes_table_and_picture(inputs, tmp_path, command):
    table, picture = tmp_path / "measures.csv", tmp_path / "wall.png"
    words = ["--units", "mm", "--scan-spacing", "0.25", "--table", table, "--picture", picture]
    code, out, _ = command("roughness", inputs / "wall.npy", *words)
    assert code == 0
    assert "40 x 48 cells (y, x) of 0.25 mm; mean plane removed" in out
    frame = pd.read_csv(table).set_index("measure")
    assert all(name in out for name in frame.index)
    assert frame.value["JRC, yu_vayssade_linear_0.25mm"] == pytest.approx(9.0, abs=0.2)
    assert picture.stat().st_size > 20000


@pytest.mark.parametrize(("choice", "done"), [("keep", "were kept"), ("cut", "were cut")])
def test_spikes_are_reported_and_cut_on_request(choice, done, inputs, tmp_path, command):
    wall = np.load(inputs / "wall.npy")
    wall[20, 21] += 2.0
    np.save(tmp_path / "a.npy", wall)
    words = ["--units", "mm", "--scan-spacing", "0.25", "--spikes", choice]
    code, out, _ = command("roughness", tmp_path / "a.npy", *words)
    assert code == 0
    for text in ("1 of 1920 points are spikes", "at (x, y) = (5.25, 5) mm", done):
        assert text in out
    assert ("1 of them without a height" in out) == (choice == "cut")
