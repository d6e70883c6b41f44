"""The CI file for public forges agrees with the project that it is for."""

import re
import tomllib
from pathlib import Path

import yaml
from packaging.specifiers import SpecifierSet

from jointclosure.commands import doctor

ROOT = Path(__file__).parents[2]
CI = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def test_every_python_that_is_supported_is_tried():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    allowed = SpecifierSet(project["requires-python"])
    supported = [f"3.{minor}" for minor in range(30) if f"3.{minor}" in allowed]
    assert CI["jobs"]["test"]["strategy"]["matrix"]["python"] == supported
    assert [f"{a}.{b}" for a, b in doctor._PYTHONS] == [supported[0], supported[-1]]
    for version in supported:
        assert version in MAKEFILE


def test_what_it_runs_is_there():
    targets = re.findall(r"^([a-z-]+):", MAKEFILE, re.M)
    steps = [step["run"] for job in CI["jobs"].values() for step in job["steps"] if "run" in step]
    assert any("make test" in step for step in steps)
    assert any(".ci/run" in step for step in steps)
    for step in steps:
        for target in re.findall(r"make ([a-z-]+)", step):
            assert target in targets
        for path in re.findall(r"(?:bash|pytest) (\S+)", step):
            assert (ROOT / path).exists(), path


def test_what_is_taken_from_elsewhere_is_pinned_to_what_cannot_be_moved_as_tags_can():
    steps = [step["uses"] for job in CI["jobs"].values() for step in job["steps"] if "uses" in step]
    assert steps
    for action in steps:
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action
    container = (ROOT / "workflow/profiles/kubernetes/Dockerfile").read_text(encoding="utf-8")
    bases = re.findall(r"^FROM (\S+)", container, re.M)
    assert bases
    for base in bases:
        assert re.fullmatch(r"[\w.:/-]+@sha256:[0-9a-f]{64}", base), base
