"""What is not used is not loaded: by modules, not by seconds."""

import json
import tomllib

import pytest

import jointclosure as jc
from tests.processes import ROOT, python

HEAVY = {
    "IPython", "SurfaceTopography", "docutils", "jinja2", "matplotlib", "mpmath", "netCDF4",
    "numba", "numpy", "pandas", "rasterio", "rich", "scipy.interpolate", "scipy.optimize",
    "scipy.spatial", "scipy.stats", "seaborn", "snakemake", "trimesh", "xarray",
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
JOBS = [
    ("paper.products", FILES | {"numba", "scipy.stats"}),
    ("frame.seals", FILES),
    ("frame.closing, studies.frame.experiments", HEAVY - {"matplotlib", "seaborn"}),
]


@pytest.mark.parametrize(("module", "needed"), JOBS)
def test_a_job_loads_what_it_needs_and_no_more(module, needed):
    """Each of the study's jobs pays for its imports: the script, and the module of its function."""
    script = f"sys.path.insert(0, {str(ROOT / 'workflow/scripts')!r}); import make"
    assert loaded(f"{script}, studies.{module}") <= needed


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


def test_every_study_is_in_the_contracts_of_imports():
    held = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    studies = {f"studies.{file.parent.name}" for file in ROOT.glob("studies/*/page.md.j2")}
    (layers,) = (each["layers"][0] for each in held if each["name"].startswith("Studies build"))
    (alone,) = (each["modules"] for each in held if each["name"].startswith("No study imports"))
    assert set(layers.split(" | ")) == set(alone) == studies - {"studies.paper"}
