"""What is not used is not loaded: by modules, not by seconds."""

import ast
import json
import sys
import tomllib
from pathlib import Path

import pytest

import jointclosure as jc
from tests.processes import ROOT, python

HEAVY = {
    "IPython", "SurfaceTopography", "docutils", "jinja2", "matplotlib", "mpmath", "netCDF4",
    "numba", "numpy", "pandas", "pydantic", "rasterio", "rich", "scipy.fft",
    "scipy.interpolate", "scipy.optimize", "scipy.spatial", "scipy.stats", "seaborn", "snakemake",
    "trimesh", "xarray",
}  # fmt: skip


def loaded(code: str) -> set[str]:
    """Which heavy modules a fresh process has loaded after some code."""
    done = python("-c", f"import json, sys\n{code}\nprint(json.dumps(list(sys.modules)))")
    return HEAVY & set(json.loads(done.stdout.splitlines()[-1]))


def test_the_package_itself_loads_nothing():
    assert loaded("import jointclosure") == set()


def test_help_loads_no_command_and_a_command_no_other():
    code = "from jointclosure.cli import main as cli; import contextlib\n"
    code += "with contextlib.suppress(SystemExit): cli.main(['--help'])"
    assert loaded(code) == {"numpy"}
    python(
        "-c",
        "import sys\n"
        "from jointclosure.cli import COMMANDS, main as cli\n"
        "for name in COMMANDS:\n"
        "    for other in COMMANDS:\n"
        "        sys.modules.pop(f'jointclosure.cli.{other}', None)\n"
        "    cli.parser([name])\n"
        "    loaded = {module.rpartition('.')[2] for module in sys.modules if '.cli.' in module}\n"
        "    assert loaded & set(COMMANDS) == {name}, (name, loaded & set(COMMANDS))\n",
    )


FILES = {"netCDF4", "numpy", "pandas", "xarray"}
"""What reading and writing datasets takes."""
CLOSES = FILES | {"numba", "scipy.fft"}
"""What the equations of the solver, and the names of its quantities, take beside."""
JOBS = [
    ("state_configuration", {"numpy", "pandas"}),
    ("make_surfaces", FILES),
    ("close_joints", CLOSES),
    ("close_points", CLOSES),
    ("aggregate", FILES),
    ("measure_covariates", FILES),
    ("fit_correlations", FILES),
    ("predict_table_3", FILES),
    ("judge_claims", FILES),
    ("check_results", FILES),
    ("write_tables", CLOSES | {"pydantic"}),
    ("require_checks", {"numpy", "pandas"}),
    ("tabulate_experiment", CLOSES | {"pydantic"}),
]


@pytest.mark.parametrize(("script", "needed"), JOBS)
def test_a_job_loads_what_it_needs_and_no_more(script, needed):
    """Each of the study's jobs pays for the imports of its script."""
    folder = str(ROOT / "workflow/scripts")
    code = f"sys.path.insert(0, {folder!r}); import {script}"
    assert loaded(code) <= needed, loaded(code) - needed


NOBODY = """
import os, pwd, sys
os.environ.pop("HOME", None)
def nobody(user):
    raise KeyError(user)
pwd.getpwuid = nobody
"""
"""A user without a name and a home, as in containers."""


@pytest.mark.skipif(sys.platform == "win32", reason="users have entries")
def test_a_user_without_a_name_and_a_home_has_a_cache_kernels_and_figures(tmp_path):
    code = f"""{NOBODY}
import tempfile
from pathlib import Path
tempfile.tempdir = {str(tmp_path)!r}
access = os.access  # the package is installed for all users
os.access = lambda path, mode: not Path(path).is_relative_to({str(ROOT)!r}) and access(path, mode)
from jointclosure.compilation import kernels, sources
root = sources.cache_root()
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
from jointclosure.compilation import sources
taken = Path({str(tmp_path)!r}) / f"jointclosure-{{os.getuid()}}"
for kind in ("link", "open"):
    if kind == "link":
        (Path({str(tmp_path)!r}) / "other").mkdir()
        taken.symlink_to(Path({str(tmp_path)!r}) / "other")
    else:
        taken.unlink()
        taken.mkdir()
        taken.chmod(0o777)
    sources.temporary_cache.cache_clear()
    assert sources.temporary_cache() != taken, kind
"""
    python("-c", code)


@pytest.mark.parametrize("words", [["simulate", "--help"], ["close", "--help"]])
def test_commands_start_without_docstrings(words):
    assert "--rock" in python("-OO", "-m", "jointclosure.cli.main", *words).stdout


def test_every_public_name_is_what_its_module_defines():
    stub = ast.parse(Path(jc.__file__).with_suffix(".pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    modules = {alias.name: node.module for node in imports for alias in node.names}
    assert jc.__all__ == sorted(modules)
    for name, module in modules.items():
        public = getattr(jc, name)
        if module is None:
            assert public.__name__ == f"jointclosure.{name}"
        else:
            assert public.__module__ == f"jointclosure.{module}"
    assert dir(jc) == sorted([*jc.__all__, "__version__"])
    with pytest.raises(AttributeError, match="simulte"):
        jc.simulte  # noqa: B018


def test_every_study_is_in_the_contracts_of_imports():
    held = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    studies = {f"studies.{file.parent.name}" for file in ROOT.glob("studies/*/page.md.j2")}
    (layers,) = (each["layers"][0] for each in held if each["name"].startswith("Studies build"))
    (alone,) = (each["modules"] for each in held if each["name"].startswith("No study imports"))
    assert set(layers.split(" | ")) == set(alone) == studies - {"studies.paper"}
