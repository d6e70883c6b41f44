"""Every kernel with the JIT on and off: the same tests, and the same numbers.

The tests named in `BOTH` run in the suite with the JIT on. Here they run without, in a process of
their own, and together call every kernel. Small joints come out as by compiled kernels.
"""

import ast
import os
import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from jointclosure.compilation.sources import PACKAGE
from jointclosure.parameters import well_posed_scenes
from tests.joints import closed, pair

ROOT = Path(__file__).parents[2]
BOTH = (
    "tests/mechanics",
    "tests/solvers/test_elastic.py",
    "tests/solvers/test_kernels.py::test_small_joints_close_in_every_scene",
    "tests/solvers/test_equilibrium.py::test_a_sweep_never_raises_the_energy_and_ends_at_the_solution",
)


DECORATORS = ("kernel", "large_kernel")


def all_kernels() -> set[str]:
    """Module and name of every function that is decorated as a kernel."""
    found = set()
    for file in PACKAGE.rglob("*.py"):
        module = ".".join(("jointclosure", *file.relative_to(PACKAGE).with_suffix("").parts))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any(
                isinstance(mark, ast.Name) and mark.id in DECORATORS for mark in node.decorator_list
            ):
                found.add(f"{module}.{node.name}")
    return found


def interpreted(*arguments: str, **environment: str) -> None:
    """Run Python with the JIT off; fails with its output where it fails."""
    answer = subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stdout[-4000:] + answer.stderr[-4000:]


def small_joints() -> dict:
    """Closures, stresses and walls of a tiny joint in every scene, by every method.

    Peaks of the current walls in the whole scene alone: others would compile seven kernels more.
    """
    walls, answers = pair(5, 6), {}
    names = ("closure", "normal_stress", "upper_final", "lower_final", "status")
    about = {"seating_stress": 0.0, "cycles": 1, "curve_points": 2, "stress_tolerance": 0.05}
    methods = ("fast", "fixed_step"), ("fast", "resolved"), ("reference", "fixed_step")
    for case in product(well_posed_scenes(), ("pristine", "current"), methods):
        effects, peaks, (solver, breakage) = case
        if peaks == "current" and not all(effects):
            continue
        stated = {"effects": effects, "peaks": peaks, "solver": solver, "breakage": breakage}
        joint = closed(walls, 5e5, **about | stated)
        answers[case] = [joint[name].values for name in names]
    return answers


def test_small_joints_close_in_every_scene():
    for stated, (closure, stress, upper, lower, status) in small_joints().items():
        assert int(status) < 16, stated
        assert stress.max() == pytest.approx(5e5, rel=0.05) or int(status) & 1
        assert np.isfinite(closure).all()
        assert np.isfinite(upper + lower).all()
        assert closure.max() > 0.0
        if not stated[0].breakage:
            np.testing.assert_array_equal([upper, lower], pair(5, 6))


@pytest.mark.slow
def test_every_kernel_is_called_by_tests_that_pass_with_and_without_the_jit(tmp_path):
    calls = tmp_path / "calls.txt"
    interpreted(
        *("-m", "pytest", "-q", "-p", "tests.kernel_calls", "-p", "no:cacheprovider", *BOTH),
        KERNEL_CALLS=str(calls),
    )
    kernels = all_kernels()
    assert len(kernels) > 50  # the search found them
    assert kernels - set(calls.read_text().split()) == set()
