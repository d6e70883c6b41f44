"""What is not used is not loaded: by modules, not by seconds."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import jointclosure as jc
from jointclosure.commands import COMMANDS

PREFIX = "jointclosure.commands."
SCRIPTS = Path(__file__).parents[2] / "workflow/scripts"
HEAVY = {
    "IPython", "SurfaceTopography", "docutils", "jinja2", "matplotlib", "mpmath", "netCDF4",
    "numba", "numpy", "pandas", "plotly", "rich", "scipy.interpolate", "scipy.optimize",
    "scipy.spatial", "scipy.stats", "seaborn", "snakemake", "tifffile", "trimesh", "xarray",
}  # fmt: skip
FILES = {"netCDF4", "numpy", "pandas", "xarray"}
"""What reading and writing datasets takes."""


def loaded(code: str) -> set[str]:
    """Which heavy modules a fresh process has loaded after some code."""
    report = f"import json, sys\n{code}\nprint(json.dumps(list(sys.modules)))"
    command = [sys.executable, "-c", report]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return HEAVY & set(json.loads(done.stdout.splitlines()[-1]))


def test_the_package_itself_loads_nothing():
    assert loaded("import jointclosure") == set()


def test_help_loads_no_command():
    code = "from jointclosure.commands import cli; import contextlib\n"
    code += "with contextlib.suppress(SystemExit): cli.main(['--help'])"
    assert loaded(code) == {"numpy"}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_loads_its_own_module_and_takes_its_arguments(name):
    code = f"from jointclosure.commands import cli; cli.parser(['{name}'])"
    report = f"import sys; {code}; print(*(m for m in sys.modules if m.startswith('{PREFIX}')))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True)
    modules = {module.removeprefix(PREFIX) for module in done.stdout.split()}
    assert modules & set(COMMANDS) == {name}, done.stderr  # beside what commands share


@pytest.mark.parametrize(
    ("script", "needed"),
    [
        ("make_surfaces", FILES),
        ("close_surfaces", FILES | {"numba"}),
        ("compile_kernels", FILES | {"numba"}),
    ],
)
def test_a_job_loads_what_it_needs_and_no_more(script, needed):
    """Each of the study's hundreds of jobs pays for its imports."""
    assert loaded(f"sys.path.insert(0, {str(SCRIPTS)!r}); import {script}") <= needed


def test_every_public_name_is_what_its_module_defines():
    assert sorted(jc.__all__) == jc.__all__ == sorted(jc._MODULES)
    for name, module in jc._MODULES.items():
        public = getattr(jc, name)
        place = f"jointclosure.{module}"
        if hasattr(public, "__module__"):
            assert public.__module__ == place
        else:
            assert public.__name__ == f"{place}.{name}"
    assert dir(jc) == sorted([*jc.__all__, "__version__"])
    with pytest.raises(AttributeError, match="no attribute 'simulte'"):
        jc.simulte  # noqa: B018
