"""An effect that is off costs nothing: its code is not compiled, and its work is not done."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import snapshots  # imported before it is patched, or it would keep `refuse`
from jointclosure.solvers import elastic, fast, interaction_operator, joint
from tests import joints
from tests.joints import ELASTIC, pair
from tests.processes import python


def closed(effects, breakage="fixed_step", solver="fast"):
    about = {"effects": effects, "breakage": breakage, "seating_stress": 0.0, "solver": solver}
    return joints.closed(pair(10, 1), 1e5, **about)


CODE = """
import json, pathlib
from jointclosure.compilation import kernels
kernels.SHIPPED = pathlib.Path("no shipped code")
from tests.solvers.test_effects_cost_nothing import closed
from jointclosure import Effects
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel
found = []
for gouge, breakage in ((True, "fixed_step"), (False, "fixed_step"), (True, "resolved")):
    closed(Effects(gouge=gouge), breakage)
    kernel = breakage_kernel(gouge, False, breakage == "resolved", True)
    (signature,) = kernel.signatures
    text = kernel.inspect_llvm(signature)
    found.append([name for name in ("measure_drops", "returning_losses") if name in text])
for breakage, gouge in ((True, True), (True, False), (False, False)):
    closed(Effects(breakage=breakage, gouge=gouge), solver="reference")
    kernel = reference_kernel(True, breakage, gouge, False)
    (signature,) = kernel.signatures
    text = kernel.inspect_llvm(signature)
    names = ("is_overstressed", "passed_share", "lay_back")
    found.append([name for name in names if name in text])
print(json.dumps(found))
"""


@pytest.mark.slow
def test_code_of_an_effect_that_is_off_is_not_in_the_machine_code(tmp_path):
    # compiled anew: numba cannot show code that it took from its cache
    done = python("-c", CODE, JOINTCLOSURE_CACHE=str(tmp_path))
    full, without_gouge, resolved, *reference = json.loads(done.stdout.splitlines()[-1])
    assert full == ["measure_drops"]
    assert without_gouge == []
    assert resolved == ["measure_drops", "returning_losses"]
    all_of_breakage = ["is_overstressed", "passed_share", "lay_back"]
    assert reference == [all_of_breakage, ["is_overstressed"], []]


def refuse(*_):
    raise AssertionError("was not to be called")


@pytest.mark.parametrize("breakage", [False, True])
def test_without_interaction_there_is_neither_transform_nor_influence(monkeypatch, breakage):
    for module in (joint, elastic, interaction_operator, snapshots):
        for name in ("influence_table", "influence_of", "interaction_field", "influence_matrix"):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, refuse)
    found = closed(jc.Effects(interaction=False, breakage=breakage, gouge=breakage))
    assert int(found.status) < 16
    assert np.all(found.bulk_indentation == 0.0)


def test_a_scene_without_breakage_does_no_work_of_breakage(monkeypatch):
    monkeypatch.setattr(fast, "breakage_kernel", refuse)
    monkeypatch.setattr(fast.FastSolver, "settle", refuse)
    found = closed(ELASTIC)
    assert found.breakage_steps == 0
    np.testing.assert_array_equal(found.upper_final, pair(10, 1)[0])
