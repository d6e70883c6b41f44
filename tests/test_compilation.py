import itertools
import os
import shutil
import subprocess
import sys

import pytest

from jointclosure import compilation
from jointclosure.solvers.breakage import breakage_kernel
from jointclosure.solvers.reference import reference_kernel


def test_the_digest_follows_the_content_of_the_named_parts(tmp_path, monkeypatch):
    copy = tmp_path / "jointclosure"
    shutil.copytree(compilation.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compilation, "PACKAGE", copy)
    whole, physics, tables = (
        compilation.source_digest(*parts) for parts in ((), ("mechanics",), ("tables",))
    )
    (copy / "mechanics/contact.py").touch()
    assert compilation.source_digest() == whole
    with open(copy / "mechanics/contact.py", "a") as file:
        file.write("# a word\n")
    assert compilation.source_digest() != whole
    assert compilation.source_digest("mechanics") != physics
    assert compilation.source_digest("tables") == tables


def test_an_unknown_part_is_an_error():
    with pytest.raises(FileNotFoundError, match="mechanic"):
        compilation.source_digest("mechanic")


def test_the_cache_folder_is_named_by_the_sources():
    assert compilation.cache_folder().name.endswith(compilation.source_digest())


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
