"""The example of a scanned wall, compared with the file that the project has."""

import re
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]


def test_the_samples_run_and_make_the_example_wall(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "config/walls/README.md").read_text(encoding="utf-8")
    samples = [c for c in re.findall(r"```python\n(.*?)```", text, re.S) if "example_wall" in c]
    assert len(samples) == 2
    for sample in samples:
        exec(compile(sample, "config/walls/README.md", "exec"), {})
    assert "Z2 along x" in capsys.readouterr().out
    made, kept = (
        np.load(folder / "example_wall.npz", allow_pickle=False)
        for folder in (tmp_path, ROOT / "config/walls")
    )
    with made, kept:
        assert sorted(made.files) == sorted(kept.files)
        # heights are rounded to micrometres; on another machine the last one may differ
        np.testing.assert_allclose(made["Z_mm"], kept["Z_mm"], atol=1.1e-3)
