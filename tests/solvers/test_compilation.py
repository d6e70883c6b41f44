import itertools
import os
import re
import subprocess
import sys

from jointclosure.compilation import kernels as compilation
from jointclosure.compilation import sources
from jointclosure.compilation.sources import PACKAGE
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel


def test_the_cache_folder_is_named_by_the_code_of_the_kernels():
    code = sources.code_digest(*compilation.KERNEL_PARTS, titles=False)
    assert compilation.cache_folder().name == f"numba-{code}"


def test_every_kernel_is_in_the_parts_that_name_the_cache_folder():
    parts = tuple(PACKAGE / part for part in compilation.KERNEL_PARTS)
    for file in PACKAGE.rglob("*.py"):
        if re.search(r"import kernel\b", file.read_text(encoding="utf-8")):
            assert any(file.is_relative_to(part) for part in parts), file


def run(*arguments, folder=None, **environment):
    """Run Python with kernels in a folder; return what it prints, on both streams."""
    environment = os.environ | environment
    if folder:
        environment["JOINTCLOSURE_CACHE"] = str(folder)
    done = subprocess.run(
        [sys.executable, "-c", *arguments], env=environment, capture_output=True, text=True,
        cwd=PACKAGE.parents[1],
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


SMALL = "from jointclosure.mechanics.strength import von_mises_on_axis as f; print(f(0.5, 0.2))"


def test_a_cold_start_says_what_it_is_doing_and_a_warm_one_nothing(tmp_path):
    printed = [run(SMALL, folder=tmp_path)[1] for _ in range(2)]
    assert printed[0].count("compiling kernels") == 1
    assert printed[1] == ""


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
    assert "compiling kernels" not in run(PROCESS, folder=tmp_path)[1]


MOVED = """
from moved import double
from jointclosure.compilation.kernels import compiles
print(double(2.0), compiles())
"""


def test_machine_code_of_a_kernel_outside_of_the_package_follows_its_file(tmp_path):
    head = (
        "from jointclosure.compilation.kernels import kernel\n@kernel\ndef double(x):\n    return "
    )
    environment = {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    printed = []
    for text in ("2.0 * x\n", "2.0 * x\n", "3.0 * x\n"):
        (tmp_path / "moved.py").write_text(head + text)
        printed.append(run(MOVED, folder=tmp_path / "cache", **environment)[0].strip())
    assert printed == ["4.0 1", "4.0 0", "6.0 1"]


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert float(run(SMALL, folder=tmp_path / "file" / "below")[0]) > 0.0
