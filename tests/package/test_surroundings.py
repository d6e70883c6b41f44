"""The package works where names of users, homes or docstrings are missing."""

import sys

import pytest

from tests.processes import ROOT, python

NOBODY = """
import os, pwd, sys
os.environ.pop("HOME", None)
def nobody(user):
    raise KeyError(user)
pwd.getpwuid = nobody
"""
"""A user without a name and a home, as in containers."""


@pytest.mark.skipif(sys.platform == "win32", reason="users have entries")
def test_a_user_without_a_name_or_a_home_has_a_cache(tmp_path):
    code = f"""{NOBODY}
import tempfile
from pathlib import Path
tempfile.tempdir = {str(tmp_path)!r}
access = os.access  # the package is installed for all users
os.access = lambda path, mode: not Path(path).is_relative_to({str(ROOT)!r}) and access(path, mode)
from jointclosure.compilation import cache_folder, kernels
root = cache_folder.cache_root()
assert root == Path({str(tmp_path)!r}) / f"jointclosure-{{os.getuid()}}", root
assert root.stat().st_mode & 0o777 == 0o700
assert kernels.cache_folder().is_relative_to(root)
from jointclosure.cli import doctor
assert any(what == "compiled kernels" for what, *_ in doctor.findings(Path({str(tmp_path)!r})))
import jointclosure.plotting.joint
import matplotlib
assert Path(matplotlib.get_cachedir()).is_relative_to(root)
"""
    environment = {"JOINTCLOSURE_CACHE": "", "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": ""}
    python("-c", code, **environment)


@pytest.mark.skipif(sys.platform == "win32", reason="users have entries")
def test_machine_code_is_not_loaded_from_a_folder_of_someone_else(tmp_path):
    """Anybody may make a folder for temporary files: a link, or one that all may write."""
    code = f"""{NOBODY}
import tempfile
from pathlib import Path
tempfile.tempdir = {str(tmp_path)!r}
from jointclosure.compilation import cache_folder
taken = Path({str(tmp_path)!r}) / f"jointclosure-{{os.getuid()}}"
for kind in ("link", "open"):
    if kind == "link":
        (Path({str(tmp_path)!r}) / "other").mkdir()
        taken.symlink_to(Path({str(tmp_path)!r}) / "other")
    else:
        taken.unlink()
        taken.mkdir()
        taken.chmod(0o777)
    cache_folder.temporary_cache.cache_clear()
    assert cache_folder.temporary_cache() != taken, kind
"""
    python("-c", code)


@pytest.mark.parametrize("words", [["simulate", "--help"], ["close", "--help"]])
def test_commands_start_without_docstrings(words):
    assert "--rock" in python("-OO", "-m", "jointclosure.cli.main", *words).stdout
