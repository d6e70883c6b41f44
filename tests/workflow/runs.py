"""Runs of the workflow for tests, in folders of their own."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
HERE = ROOT / "tests/workflow"
TINY = HERE / "tiny.yaml"
STAMP = ".venv/jointclosure-is-set-up"
NEEDED = ("Makefile", "pyproject.toml", "requirements.lock", "requirements-uv.lock")
"""Files that `make setup` reads before there is an environment."""


def checkout(folder: Path) -> Path:
    """What a run needs of the project with the environment of these tests, in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("Snakefile", "Makefile"):
        shutil.copy(ROOT / name, folder)
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(TINY, folder)
    (folder / ".venv").symlink_to(sys.prefix)
    return folder


def answer(command, folder: Path, **settings) -> subprocess.CompletedProcess:
    """Run a command in a folder."""
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, **settings)


def snakemake(
    folder: Path,
    *words: str,
    cores: int = 2,
    config: str = "tiny.yaml",
    profile: str = "workflow/profiles/default",
    python: str = sys.executable,
    fails: bool = False,
    **environment: str,
) -> str:
    """Run the project's Snakefile in a folder; what it prints."""
    given = ["--workflow-profile", profile, "--configfile", config, "--cores", cores, *words]
    variables = os.environ | {"OMP_NUM_THREADS": "1"} | environment
    done = answer([python, "-m", "snakemake", *given], folder, env=variables)
    assert (done.returncode != 0) == fails, done.stdout + done.stderr
    return done.stdout + done.stderr


def planned(folder: Path, *targets: str, **settings) -> dict[str, int]:
    """Jobs that a dry run would do, by rule."""
    listing = snakemake(folder, "--dry-run", *targets, **settings)
    table = re.search(r"job\s+count\n[-\s]+\n(.*?)\n\n", listing, re.S)
    rows = [line.split() for line in table.group(1).splitlines()] if table else []
    return {name: int(count) for name, count in rows if name not in ("total", "all", *targets)}


def studies_command(*words) -> subprocess.CompletedProcess:
    return answer([sys.executable, "-m", "studies", *words], ROOT)


def assert_same(folder: Path, other: Path, *folders: str) -> None:
    """Two studies have the same datasets, and byte by byte the same files in folders."""
    found = studies_command("compare", "--exact", folder, other)
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout == "identical except for provenance and timing\n"
    for place in ("tables", *folders):
        files, others = (
            {f.name: f.read_bytes() for f in (p / place).iterdir()} for p in (folder, other)
        )
        assert files.keys() == others.keys()
        assert [name for name, content in files.items() if content != others[name]] == []
