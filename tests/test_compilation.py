import itertools
import os
import subprocess
import sys

from jointclosure import compilation, sources
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel
from jointclosure.sources import PACKAGE


def test_the_cache_folder_is_named_by_the_code_of_the_kernels():
    code = sources.code_digest(*compilation.KERNEL_PARTS)
    assert compilation.cache_folder().name == f"numba-{code}"


def test_every_kernel_is_in_the_parts_that_name_the_cache_folder():
    parts = tuple(PACKAGE / part for part in compilation.KERNEL_PARTS)
    for file in PACKAGE.rglob("*.py"):
        if "import kernel" in file.read_text(encoding="utf-8"):
            assert any(file.is_relative_to(part) for part in parts), file


COLD_START = """
import jointclosure as jc
flat = [[0.0, 0.0, 0.0]] * 3
jc.equilibrium(flat, flat, spacing=1e-3, rock=jc.Rock(1e9, 0.2, 1e6), closure=1e-9,
               effects=jc.Effects(True, False, False, False, False))
"""


def test_a_cold_start_says_what_it_is_doing_and_a_warm_one_nothing(tmp_path):
    environment = os.environ | {"JOINTCLOSURE_CACHE": str(tmp_path)}
    said = [
        subprocess.run(
            [sys.executable, "-c", COLD_START],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stderr
        for _ in range(2)
    ]
    assert said[0].count("compiling kernels") == 1
    assert said[1] == ""


def test_every_closure_of_a_factory_has_a_name_of_its_own():
    """Equal names, compiled in two processes, would collide where a third loads both."""
    flags = list(itertools.product([False, True], repeat=3))
    kernels = [breakage_kernel(*three) for three in flags]
    kernels += [reference_kernel(*four) for four in itertools.product([False, True], repeat=4)]
    names = {getattr(each, "py_func", each).__qualname__ for each in kernels}
    assert len(names) == 8 + 16
