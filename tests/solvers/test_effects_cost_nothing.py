"""An effect that is off costs nothing: its code is not compiled, and its work is not done."""

import itertools
import json
import re

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.compilation import kernels as compilation
from jointclosure.compilation import sources
from jointclosure.compilation.sources import PACKAGE
from jointclosure.joint import states  # imported before it is patched, or it would keep `refuse`
from jointclosure.solvers import elastic, fast, interaction_operator, joint
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel
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
    for module in (joint, elastic, interaction_operator, states):
        for name in ("influence_table", "influence_of", "interaction_field", "influence_matrix"):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, refuse)
    found = closed(jc.Effects(interaction=False, breakage=breakage, gouge=breakage))
    assert int(found.status) < 16
    assert np.all(found.bulk_indentation == 0.0)


def test_a_scene_without_breakage_calls_no_breakage_and_takes_no_steps(monkeypatch):
    monkeypatch.setattr(fast, "breakage_kernel", refuse)
    monkeypatch.setattr(fast.FastSolver, "settle", refuse)
    found = closed(ELASTIC)
    assert found.breakage_steps == 0
    np.testing.assert_array_equal(found.upper_final, pair(10, 1)[0])


def test_the_cache_folder_is_named_by_the_code_of_the_kernels():
    code = sources.code_digest(*compilation.KERNEL_PARTS, titles=False)
    assert compilation.cache_folder().name.startswith(f"numba-{code}-")


def test_every_kernel_is_in_the_parts_that_name_the_cache_folder():
    parts = tuple(PACKAGE / part for part in compilation.KERNEL_PARTS)
    for file in PACKAGE.rglob("*.py"):
        if re.search(r"import kernel\b", file.read_text(encoding="utf-8")):
            assert any(file.is_relative_to(part) for part in parts), file


def test_every_closure_of_a_factory_has_a_name_of_its_own():
    """Equal names, compiled in two processes, would collide where a third loads both."""
    flags = list(itertools.product([False, True], repeat=4))
    kernels = [breakage_kernel(*four) for four in flags]
    kernels += [reference_kernel(*four) for four in flags]
    names = {getattr(each, "py_func", each).__qualname__ for each in kernels}
    assert len(names) == 16 + 16


PROCESS = """
import numba, numba.core.event

def state():
    listeners = numba.core.event._registered.values()
    return numba.config.CACHE_DIR, sum(map(len, listeners))

before = state()
import jointclosure, jointclosure.joint.warmup
assert state() == before, (before, state())

@numba.njit
def theirs(x):
    return x + 1

theirs(1)
"""


def test_importing_changes_nothing_for_other_users_of_numba_in_the_process(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert "compiling kernels" not in python("-c", PROCESS, JOINTCLOSURE_CACHE=str(tmp_path)).stderr


MOVED = """
from moved import double
from jointclosure.compilation.kernels import compiles
print(double(2.0), compiles())
"""


def moved(tmp_path, factor, **environment):
    """Run a kernel outside of the package, which is never shipped; what is printed."""
    head = (
        "from jointclosure.compilation.kernels import kernel\n@kernel\ndef double(x):\n    return "
    )
    (tmp_path / "moved.py").write_text(f"{head}{factor} * x\n")
    environment = {"JOINTCLOSURE_CACHE": str(tmp_path / "cache")} | environment
    environment |= {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    return python("-c", MOVED, **environment)


def test_machine_code_is_kept_with_a_word_at_a_cold_start_and_follows_its_file(tmp_path):
    runs = [moved(tmp_path, factor) for factor in (2.0, 2.0, 3.0)]
    assert [run.stdout for run in runs] == ["4.0 1\n", "4.0 0\n", "6.0 1\n"]
    assert [run.stderr.count("compiling kernels") for run in runs] == [1, 0, 1]


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    (tmp_path / "file").write_text("in the way")
    run = moved(tmp_path, 2.0, JOINTCLOSURE_CACHE=str(tmp_path / "file" / "below"))
    assert run.stdout == "4.0 1\n"


LOADED = """
from numba.core.cpu import CPUContext
loads, load = [], CPUContext.load_additional_registries
def counted(context):
    loads.append(context)
    load(context)
CPUContext.load_additional_registries = counted
from tests.solvers.test_effects_cost_nothing import closed
from jointclosure import Effects
from jointclosure.compilation.kernels import compiles
closed(Effects())
print(compiles(), len(loads))
"""


def test_machine_code_is_loaded_without_the_registries_of_the_compiler():
    closed(jc.Effects())  # compiles what is not in the cache
    assert python("-c", LOADED).stdout == "0 0\n"


SHIP = """
import pathlib
from jointclosure.compilation import kernels
kernels.SHIPPED = pathlib.Path({shipped!r})
from jointclosure.mechanics import strength
print(strength.von_mises_on_axis(0.5, 0.2).hex(), kernels.compiles())
"""


@pytest.mark.skipif(not compilation.X86, reason="shipped code needs nothing there")
def test_shipped_code_gives_the_bits_of_compiled_code_and_only_its_sources_and_processor_use_it(
    tmp_path,
):
    def value(name, **environment):
        text = SHIP.format(shipped=str(tmp_path / "shipped"))
        environment |= {"JOINTCLOSURE_CACHE": str(tmp_path / name)}
        return python("-c", text, **environment).stdout.split()

    target = {"NUMBA_CPU_NAME": compilation.PROCESSOR, "NUMBA_CPU_FEATURES": ""}
    bits, compiled = value("shipped", **target)
    assert int(compiled) > 0
    able = {"NUMBA_CPU_NAME": "znver4", "NUMBA_CPU_FEATURES": ",".join(compilation.FEATURES)}
    assert value("user", **able) == [bits, "0"]
    (folder,) = (tmp_path / "shipped").glob("numba-*")
    folder.rename(folder.with_name(folder.name[:-1] + "x"))  # as of other sources or versions
    assert value("other", **able) == [bits, compiled]
