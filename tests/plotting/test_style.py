"""Importing the figures, or drawing one, leaves the process as it is; labels, words, sizes."""

import subprocess
import sys

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.plotting.snapshots import snapshot_figure
from jointclosure.plotting.style import StyledFigure
from studies.accuracy.labels import Label, label_marks
from tests.joints import DOLERITE, SPACING

PROGRAM = """
import matplotlib
matplotlib.use("svg")
before = dict(matplotlib.rcParams)
from studies.accuracy import figures as accuracy
from studies.effects import figures as effects
from studies.verification import figures as verification
from jointclosure.plotting import joint
from studies.paper import closure_figures
from jointclosure.plotting import walls
figure = closure_figures.equivalent_stress()
figure.savefig("figure.png")
changed = [key for key, value in matplotlib.rcParams.items() if value != before[key]]
assert changed == [], changed
import sys
assert "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()
"""


def test_figures_leave_the_backend_and_the_style_of_the_process_alone(tmp_path):
    answer = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0, answer.stderr
    assert (tmp_path / "figure.png").stat().st_size > 1000


def test_labels_of_marks_do_not_meet():
    figure = StyledFigure(figsize=(3.0, 3.0))
    axes = figure.add_subplot()
    axes.plot([1.0], [1.0], "*", ms=13)
    axes.plot([1.02, 0.98], [1.0, 1.0], "o", ms=5)
    axes.set(xlim=(0.5, 1.5), ylim=(0.5, 1.5))
    label_marks(axes, [Label("0.5", 1.02, 1.0, "C0"), Label("1", 0.98, 1.0, "C1")])
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 2
    assert not boxes[0].padded(2.0).overlaps(boxes[1])


@pytest.mark.parametrize("number", [1, 3, 12, 24])
def test_snapshots_fill_at_most_two_screens(number):
    upper, lower = jc.wall_pair(8.0, (12, 12), SPACING, 1)
    loads = {"max_normal_stress": 2e6, "snapshots": [1e6]}
    closed = jc.simulate(upper, lower, spacing=SPACING, rock=DOLERITE, **loads)
    kept = np.arange(number) % closed.sizes["snapshot"]
    figure = snapshot_figure(closed.isel(snapshot=kept), "joint")
    width, height = figure.get_size_inches()
    assert 1280.0 * height / width <= 2.0 * 800.0
