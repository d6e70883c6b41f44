"""What is not used is not loaded: by modules, not by seconds."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import jointclosure as jc

PREFIX = "jointclosure.cli."
SCRIPTS = Path(__file__).parents[2] / "workflow/scripts"
HEAVY = {
    "IPython", "SurfaceTopography", "docutils", "jinja2", "matplotlib", "mpmath", "netCDF4",
    "numba", "numpy", "pandas", "rich", "scipy.interpolate", "scipy.optimize",
    "scipy.spatial", "scipy.stats", "seaborn", "snakemake", "tifffile", "trimesh", "xarray",
}  # fmt: skip
FILES = {"netCDF4", "numpy", "pandas", "xarray"}
"""What reading and writing datasets takes."""


def run(code: str) -> str:
    """Run code in a fresh process; what it prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def loaded(code: str) -> set[str]:
    """Which heavy modules a fresh process has loaded after some code."""
    printed = run(f"import json, sys\n{code}\nprint(json.dumps(list(sys.modules)))")
    return HEAVY & set(json.loads(printed.splitlines()[-1]))


def test_the_package_itself_loads_nothing():
    assert loaded("import jointclosure") == set()


def test_help_loads_no_command():
    code = "from jointclosure.cli import main as cli; import contextlib\n"
    code += "with contextlib.suppress(SystemExit): cli.main(['--help'])"
    assert loaded(code) == {"numpy"}


def test_a_command_loads_its_own_module_and_no_other_command():
    """One process: modules of the commands are forgotten before each."""
    run(
        "import sys\n"
        "from jointclosure.cli import COMMANDS, main as cli\n"
        f"prefix = {PREFIX!r}\n"
        "for name in COMMANDS:\n"
        "    for other in COMMANDS:\n"
        "        sys.modules.pop(prefix + other, None)\n"
        "    cli.parser([name])\n"
        "    loaded = {module.removeprefix(prefix) for module in sys.modules}\n"
        "    assert loaded & set(COMMANDS) == {name}, (name, loaded & set(COMMANDS))\n"
    )


@pytest.mark.parametrize(
    ("script", "needed"),
    [
        ("make_product", FILES | {"numba", "scipy.stats"}),
        ("compile_kernels", FILES),
    ],
)
def test_a_job_loads_what_it_needs_and_no_more(script, needed):
    """Each of the study's jobs pays for its imports."""
    assert loaded(f"sys.path.insert(0, {str(SCRIPTS)!r}); import {script}") <= needed


def test_flow_is_not_loaded_where_none_is_asked_for():
    """One process: without it, then with it."""
    run(
        "import sys, jointclosure as jc\n"
        "walls = jc.wall_pair(8.0, (8, 8), 0.25e-3, seed=1)\n"
        "about = dict(spacing=0.25e-3, rock=jc.Rock(78e9, 0.2, 165e6), max_normal_stress=1e6)\n"
        "parts = ['jointclosure.joint.flow']\n"
        "def loaded(**asked):\n"
        "    jc.simulate(*walls, effects=jc.Effects(*[False] * 5), **about, **asked)\n"
        "    return [part for part in parts if part in sys.modules]\n"
        "assert loaded() == [], loaded()\n"
        "assert loaded(flow=True) == parts\n"
    )


def test_closing_scanned_walls_reads_no_configuration_of_a_study():
    code = (
        "import jointclosure as jc\n"
        "from jointclosure.walls.measured import Scan\n"
        "upper, lower = jc.wall_pair(8.0, (24, 24), 0.25e-3, seed=3, correlation=0.9)\n"
        "scans = [Scan(wall, (0.25e-3, 0.25e-3), (0.0, 0.0)) for wall in (1e-3 - upper, lower)]\n"
        "elastic = jc.Effects(breakage=False, gouge=False)\n"
        "print(jc.close(*scans, rock='granite', max_normal_stress=1e6, effects=elastic))\n"
        "print([name for name in sys.modules if name.startswith('studies.frame.config')])"
    )
    assert run(f"import sys\n{code}").splitlines()[-1] == "[]"


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
