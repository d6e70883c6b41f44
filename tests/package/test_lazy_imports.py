"""What is not used is not loaded: by modules, not by seconds."""

import json

import pytest

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


def test_help_loads_no_command():
    code = "from jointclosure.cli import main as cli; import contextlib\n"
    code += "with contextlib.suppress(SystemExit): cli.main(['--help'])"
    assert loaded(code) == {"numpy"}


def test_a_command_loads_no_other():
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
def test_a_job_loads_no_more_than_it_needs(script, needed):
    """Each of the study's jobs pays for the imports of its script."""
    folder = str(ROOT / "workflow/scripts")
    code = f"sys.path.insert(0, {folder!r}); import {script}"
    assert loaded(code) <= needed, loaded(code) - needed
