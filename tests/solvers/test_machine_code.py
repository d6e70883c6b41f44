"""Machine code of kernels is used again for as long as what it depends on is the same."""

import itertools
import re
import shutil

import pytest

import jointclosure as jc
from jointclosure.compilation import code_digests
from jointclosure.compilation import kernels as compilation
from jointclosure.compilation.cache_folder import PACKAGE
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel
from tests.processes import python
from tests.solvers.test_effects_cost_nothing import closed


def test_the_cache_folder_is_named_by_the_code_of_the_kernels():
    code = code_digests.code_digest(*compilation.KERNEL_PARTS, titles=False)
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


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A kernel from a cold start, as it was kept, and after an edit of its file."""
    folder = tmp_path_factory.mktemp("moved")
    return [moved(folder, factor) for factor in (2.0, 2.0, 3.0)]


def test_machine_code_is_kept_until_its_file_changes(runs):
    assert [run.stdout for run in runs] == ["4.0 1\n", "4.0 0\n", "6.0 1\n"]


def test_the_screen_says_that_kernels_are_compiled(runs):
    assert [run.stderr.count("compiling kernels") for run in runs] == [1, 0, 1]


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    (tmp_path / "file").write_text("in the way")
    run = moved(tmp_path, 2.0, JOINTCLOSURE_CACHE=str(tmp_path / "file" / "below"))
    assert run.stdout == "4.0 1\n"
    assert "in every process" in run.stderr


def test_the_screen_says_that_compiled_kernels_are_kept(runs):
    assert [run.stderr.count("later runs load them") for run in runs] == [1, 0, 1]


def test_the_number_of_kernels_is_known_once_all_are_compiled(tmp_path, monkeypatch):
    cache, shipped = tmp_path / "numba-1", tmp_path / "shipped"
    for folder, names in ((cache, "bc"), (shipped / cache.name, "ab")):
        (folder / "solvers").mkdir(parents=True)
        for name in names:
            (folder / "solvers" / f"{name}.nbi").touch()
    monkeypatch.setattr(compilation, "cache_folder", lambda: cache)
    monkeypatch.setattr(compilation, "SHIPPED", shipped)
    monkeypatch.setattr(compilation, "FEATURES", set())
    assert compilation.stored_kernels() == (3, None)
    compilation.store_number_of_kernels()
    assert compilation.stored_kernels() == (3, 3)
    assert not compilation.all_are_shipped()
    (shipped / cache.name / "number_of_kernels").write_text("3\n")
    assert not compilation.all_are_shipped()
    (shipped / cache.name / "solvers" / "c.nbi").touch()
    assert compilation.all_are_shipped()
    (shipped / cache.name / "solvers" / "c.nbi").unlink()
    (cache / "solvers" / "c.nbi").unlink()
    assert compilation.stored_kernels() == (2, 3)
    monkeypatch.setattr(compilation, "FEATURES", {"+none"})  # shipped code cannot be run
    assert compilation.stored_kernels() == (1, 3)
    assert not compilation.all_are_shipped()


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


def shipped(folder, name, **environment):
    """A value in bits and the number of compiled kernels, with code that is shipped in a folder."""
    text = SHIP.format(shipped=str(folder / "shipped"))
    environment |= {"JOINTCLOSURE_CACHE": str(folder / name)}
    return python("-c", text, **environment).stdout.split()


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The folder of code that was made to be shipped, and what the process that made it printed."""
    folder = tmp_path_factory.mktemp("shipping")
    target = {"NUMBA_CPU_NAME": compilation.PROCESSOR, "NUMBA_CPU_FEATURES": ""}
    bits, number = shipped(folder, "shipped", **target)
    assert int(number) > 0
    return folder, bits, number


ABLE = {"NUMBA_CPU_NAME": "znver4", "NUMBA_CPU_FEATURES": ",".join(compilation.FEATURES)}
"""Another processor that can run shipped code."""


@pytest.mark.skipif(not compilation.X86, reason="shipped code needs nothing there")
def test_shipped_code_gives_the_bits_of_compiled_code(compiled):
    folder, bits, _ = compiled
    assert shipped(folder, "user", **ABLE) == [bits, "0"]


@pytest.mark.skipif(not compilation.X86, reason="shipped code needs nothing there")
def test_shipped_code_of_other_sources_or_versions_is_not_used(compiled, tmp_path):
    folder, bits, number = compiled
    (made,) = (folder / "shipped").glob("numba-*")
    shutil.copytree(made, tmp_path / "shipped" / f"{made.name[:-1]}x")
    assert shipped(tmp_path, "other", **ABLE) == [bits, number]
