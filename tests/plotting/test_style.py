"""Importing the figures, or drawing one, leaves the process as it is."""

import subprocess
import sys

PROGRAM = """
import matplotlib
matplotlib.use("svg")
before = dict(matplotlib.rcParams)
from jointclosure.plotting import accuracy, effects, hard_cases, joint, measured, numerics, study
from jointclosure.plotting import walls
figure = study.equivalent_stress()
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
