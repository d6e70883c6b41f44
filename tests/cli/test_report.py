"""`jointclosure report`: the page of a joint holds the numbers of its folder."""

import json

import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.cli.page import number_text
from tests.joints import SPACING


def test_the_folder_of_a_single_joint_has_a_page(tmp_path, capsys):
    upper, lower = jc.wall_pair(9.0, (40, 44), SPACING, seed=4, correlation=0.95, roll_off=None)
    y, x = np.indices(upper.shape) * 1e3 * SPACING
    for name, heights in (("top", 1e-3 - upper), ("bottom", lower)):
        points = np.column_stack([x.ravel(), y.ravel(), 1e3 * heights.ravel()])
        np.savetxt(tmp_path / f"{name}.xyz", points, fmt="%.6f")
    stated = ["--units", "mm", "--rock", "granite", "--stress", "2", "--single"]
    stated += ["--output", tmp_path / "joint"]
    scans = [tmp_path / "top.xyz", tmp_path / "bottom.xyz"]
    assert cli.main(["close", *map(str, [*scans, *stated])]) == 0
    assert cli.main(["report", str(tmp_path / "joint")]) == 0
    page = (tmp_path / "joint/report.html").read_text(encoding="utf-8")
    cycles = pd.read_csv(tmp_path / "joint/cycles.csv")
    assert f"closes {number_text(cycles.max_closure_seated_net_mm[0], 3)} mm" in page
    assert f"{number_text(cycles.max_closure_seated_mm[0], 3)} mm (gross)" in page
    assert "compressive strength 173 MPa" in page
    record = json.loads((tmp_path / "joint/joint.json").read_text())
    assert all(digest in page for digest in record["sha256"].values())
    assert page.count("<figure ") == 3  # engineering, curves, walls
    assert "http" not in page.replace("http-equiv", "")
    assert "report.html: " in capsys.readouterr().out


def test_a_folder_of_something_else_is_refused(tmp_path, capsys):
    assert cli.main(["report", str(tmp_path)]) == 2
    assert "must be a folder that `jointclosure close` wrote" in capsys.readouterr().err
