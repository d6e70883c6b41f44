"""The wheel works outside of a clone, with the dependencies of the library alone."""

import importlib.metadata
import itertools
import os
import re
import subprocess
import sys
import zipfile

import pytest
from packaging.requirements import Requirement

from jointclosure.cli.doctor import THREADS
from jointclosure.inputs.extras import EXTRAS
from tests.workflow.runs import ROOT, STAMP

pytestmark = pytest.mark.slow


def run(*words, cwd=None, status=0):
    """Run a command outside of this environment; fails with what it printed but for a status."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "COV"))}
    environment |= dict.fromkeys(THREADS, "1")
    about = {"capture_output": True, "text": True, "check": False}
    done = subprocess.run(words, cwd=cwd, env=environment, **about)
    assert done.returncode == status, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def wheel():
    """The wheel of the project, built by `make` without a network."""
    run("make", "-o", STAMP, "wheel", cwd=ROOT)
    (file,) = (ROOT / "build/wheel").glob("*.whl")
    return file


def required(name: str, extras: tuple[str, ...] = ()) -> set[str]:
    """Names of a distribution's dependencies, and of theirs, on this machine."""
    names = set()
    for wanted in map(Requirement, importlib.metadata.requires(name) or []):
        marker = wanted.marker
        if not marker or any(marker.evaluate({"extra": extra}) for extra in ("", *extras)):
            names |= {wanted.name} | required(wanted.name, tuple(wanted.extras))
    return names


@pytest.fixture(scope="module")
def program(wheel, tmp_path_factory):
    """`jointclosure` of an environment that has the wheel and what the library needs."""
    folder = tmp_path_factory.mktemp("environment")
    run(sys.executable, "-m", "venv", "--without-pip", folder)
    python = folder / "bin/python"
    site = next((folder / "lib").glob("python*/site-packages"))
    for name in required("jointclosure"):
        distribution = importlib.metadata.distribution(name)
        tops = {file.parts[0] for file in distribution.files or []}
        for top in tops - {"..", "__pycache__"}:
            if not (site / top).exists():
                (site / top).symlink_to(distribution.locate_file(top))
    pip = [sys.executable, "-m", "pip", f"--python={python}", "install", "--no-index", "--no-deps"]
    run(*pip, wheel)
    return folder / "bin/jointclosure"


def test_the_wheel_holds_the_package_alone(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert "jointclosure/py.typed" in names
    assert not [name for name in names if "__pycache__" in name or name.startswith("tests")]


def test_the_wheel_holds_nothing_of_this_machine(wheel):
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            assert str(ROOT).encode() not in archive.read(name), name


def test_the_library_does_without_the_extras(program):
    """None of their modules is there, and each module of the library can be imported."""
    python = program.with_name("python")
    for module in itertools.chain(*EXTRAS.values()):
        run(python, "-c", f"import {module}", status=1)
    names = "[name for name in jc.__all__ if name != 'plot']"
    run(python, "-c", f"import jointclosure as jc; [getattr(jc, n) for n in {names}]")
    plot = run(python, "-c", "import jointclosure as jc; jc.plot", status=1)
    assert re.search(r"InputError: .* not installed: pip install 'matplotlib", plot.stderr)


@pytest.mark.parametrize(
    "work",
    [
        "jc.close(*walls, rock='granite', max_normal_stress=2e6, single=True)",
        "jc.assess([walls], rock='granite', max_normal_stress=2e6)",
        "simulate(breakage='fixed_step', strength_bound='none')",
    ],
    ids=["close", "assess", "study"],
)
def test_after_the_compilation_nothing_is_left_to_compile(work, program, tmp_path):
    python = program.with_name("python")
    run(python, "-m", "jointclosure.joint.warmup", cwd=tmp_path)
    walls = [str(ROOT / f"config/walls/joint_{name}.npz") for name in ("upper", "lower")]
    code = f"""
import jointclosure as jc
from jointclosure.compilation.kernels import compiles

walls = {walls}

def simulate(breakage, strength_bound):
    pair = jc.wall_pair(8, (24, 24), 0.25e-3, seed=1)
    jc.simulate(
        *pair,
        spacing=0.25e-3,
        rock="granite",
        max_normal_stress=2e6,
        choices=jc.Choices(strength_bound=strength_bound),
        numerics=jc.Numerics(breakage=breakage),
    )

{work}
print("compiled:", compiles())
"""
    done = run(python, "-c", code, cwd=tmp_path)
    assert done.stdout.splitlines()[-1] == "compiled: 0"


WORDS = ["simulate", "--rock", "dolerite", "--cells", "12", "--stress", "1"]
WORDS += ["--without", "breakage", "gouge"]  # whose kernels take a minute to compile


def test_a_joint_is_closed_in_an_empty_folder(program, tmp_path):
    done = run(program, *WORDS, "--output", "joint.nc", cwd=tmp_path)
    assert "net closure since seating (mm)" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["joint.nc"]


def test_a_missing_extra_is_one_line(program, tmp_path):
    done = run(program, *WORDS, "--picture", "joint.png", cwd=tmp_path, status=2)
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
    assert "pip install 'matplotlib" in done.stderr
