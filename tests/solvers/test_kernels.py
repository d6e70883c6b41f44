"""Every kernel with the JIT on and off: the same tests give the same numbers.

The tests named in `BOTH` run in the suite with the JIT on. Here they run without, in a process of
their own, and together call every kernel. Small joints come out as by compiled kernels.
"""

import ast
from itertools import product

import numpy as np
import pytest

from jointclosure.compilation.cache_folder import PACKAGE
from jointclosure.parameters import well_posed_scenes
from tests.joints import closed, pair
from tests.processes import python

BOTH = (
    "tests/mechanics",
    "tests/solvers/test_breakage.py::test_cells_wait_at_the_moment_they_were_last_due_at",
    "tests/solvers/test_equilibrium.py::test_each_point_is_an_equilibrium_at_its_closure",
    "tests/solvers/test_equilibrium.py::test_a_sweep_never_raises_the_energy",
    "tests/solvers/test_equilibrium.py::test_sweeps_end_at_the_solution",
    "tests/solvers/test_equilibrium.py::test_the_interaction_follows_a_change_of_the_forces",
    "tests/solvers/test_honest_failure.py::test_any_start_leads_to_the_same_equilibrium",
    "tests/solvers/test_kernels.py::test_small_joints_close_in_every_scene",
    "tests/solvers/test_linear_algebra.py::test_products_are_those_of_linear_algebra",
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


def small_joints() -> dict:
    """Closures, stresses and walls of a tiny joint in every scene, by every method.

    Peaks of the current walls in the whole scene alone: others would compile seven kernels more.
    """
    walls, answers = pair(5, 6), {}
    names = ("closure", "normal_stress", "upper_final", "lower_final", "status")
    about = {"seating_stress": 0.0, "cycles": 1, "stress_tolerance": 0.05}
    methods = ("fast", "fixed_step"), ("fast", "resolved"), ("reference", "fixed_step")
    for case in product(well_posed_scenes(), ("pristine", "current"), methods):
        effects, peaks, (solver, breakage) = case
        if peaks == "current" and not all(effects):
            continue
        stated = {"effects": effects, "peaks": peaks, "solver": solver, "breakage": breakage}
        if not effects.breakage and solver == "fast":  # elsewhere it has no effect
            stated["curve_points"] = 2
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
def test_every_kernel_is_called_by_tests_that_pass_without_the_jit_too(tmp_path):
    calls = tmp_path / "calls.txt"
    words = ("-m", "pytest", "-q", "-p", "tests.kernel_calls", "-p", "no:cacheprovider", *BOTH)
    python(*words, NUMBA_DISABLE_JIT="1", KERNEL_CALLS=str(calls))
    kernels = all_kernels()
    assert len(kernels) > 50  # the search found them
    assert kernels - set(calls.read_text().split()) == set()
