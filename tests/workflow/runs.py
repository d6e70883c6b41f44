"""Runs of the workflow for tests, in folders of their own."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
HERE = ROOT / "tests/workflow"
CONFIGURATIONS = ("tiny.yaml", "smallest.yaml")
STAMP = ".venv/jointclosure-is-set-up"
NEEDED = ("Makefile", "pyproject.toml", "requirements.lock", "requirements-uv.lock")
"""Files that `make setup` reads before there is an environment."""


def checkout(folder: Path) -> Path:
    """Put into a folder what a run needs: files of the project, and the tests' environment."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("Snakefile", "Makefile"):
        shutil.copy(ROOT / name, folder)
    for name in ("workflow", "config", "profiles"):
        shutil.copytree(ROOT / name, folder / name)
    for name in CONFIGURATIONS:
        shutil.copy(HERE / name, folder)
    (folder / "studies").symlink_to(ROOT / "studies")
    (folder / ".venv").symlink_to(sys.prefix)
    return folder


def add_code(folder: Path) -> dict[str, str]:
    """Copy the code to a folder, so that it can be edited; return variables by which it is used."""
    (folder / "studies").unlink()
    without = shutil.ignore_patterns("__pycache__", "compiled")
    for name in ("studies", "src"):
        shutil.copytree(ROOT / name, folder / name, ignore=without)
    return {"PYTHONPATH": f"{folder}/src:{folder}"}


def answer(command, folder: Path, **settings) -> subprocess.CompletedProcess:
    """Run a command in a folder."""
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, **settings)


def run_snakemake(
    folder: Path,
    *words: str,
    cores: int = 2,
    config: str = "tiny.yaml",
    python: str = sys.executable,
    **environment: str,
) -> subprocess.CompletedProcess:
    """Run the project's Snakefile in a folder, with the profile that Snakemake finds there."""
    given = ["--configfile", config, "--cores", cores, *words]
    variables = os.environ | {"OMP_NUM_THREADS": "1"} | environment
    return answer([python, "-m", "snakemake", *given], folder, env=variables)


def snakemake(folder: Path, *words: str, **settings) -> str:
    """Run the project's Snakefile, which must succeed, and return what it prints."""
    done = run_snakemake(folder, *words, **settings)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def edit(folder, module: str, statement: str = "EDITED = True") -> None:
    """Append a statement to a module of a folder with code of its own."""
    assert (folder / module).is_file()
    with (folder / module).open("a") as file:
        file.write(f"\n{statement}\n")


def jobs_in(listing: str) -> dict[str, int]:
    """Return the number of jobs by rule in what a dry run prints, without `all`."""
    if "Nothing to be done" in listing:
        return {}
    table = re.search(r"job\s+count\n[-\s]+\n(.*?)\n\n", listing, re.S)
    assert table, listing
    rows = [line.split() for line in table.group(1).splitlines()]
    return {name: int(count) for name, count in rows if name not in ("total", "all")}


def planned(folder: Path, *words: str, **settings) -> dict[str, int]:
    """Return the number of jobs that a dry run plans, by rule."""
    return jobs_in(snakemake(folder, "--dry-run", *words, **settings))


def pretend(folder: Path, *words: str, **settings) -> None:
    """Make the files of a study empty, and have Snakemake take it as finished.

    Plans of Snakemake depend on names, times, inputs, scripts and params, but not on contents.
    """
    for line in snakemake(folder, "--summary", *words, **settings).splitlines():
        if line.startswith("results/"):
            file = folder / line.split("\t")[0]
            file.parent.mkdir(parents=True, exist_ok=True)
            # the end of a run shows the closures of this table
            file.write_text("rock,parameter\n" if file.name == "max_closure.csv" else "")
    snakemake(folder, "--touch", "--forceall", *words, **settings)


def changed(folder: Path, name: str, *places_and_values: tuple[str, object]) -> str:
    """Write tiny.yaml with other values at places (such as surface.hurst); return its name."""
    keys = yaml.safe_load((folder / "tiny.yaml").read_text())
    for place, value in places_and_values:
        *sections, key = place.split(".")
        part = keys
        for section in sections:
            part = part.setdefault(section, {})
        part[key] = value
    (folder / name).write_text(yaml.safe_dump(keys, sort_keys=False))
    return name


def state_of(folder: Path) -> dict[str, tuple[int, str]]:
    """Return times and digests of all files in the results of a folder."""
    return {
        path.relative_to(folder).as_posix(): (
            path.stat().st_mtime_ns,
            hashlib.sha256(path.read_bytes()).hexdigest(),
        )
        for path in sorted((folder / "results").rglob("*"))
        if path.is_file()
    }


def studies_command(*words) -> subprocess.CompletedProcess:
    return answer([sys.executable, "-m", "studies", *words], ROOT)


def assert_same(folder: Path, other: Path, *folders: str) -> None:
    """Assert that two studies have the same datasets, and the same bytes in files of folders."""
    found = studies_command("compare", "--exact", folder, other)
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout == "identical except for provenance and timing\n"
    for place in ("tables", *folders):
        files, others = (
            {f.name: f.read_bytes() for f in (p / place).iterdir()} for p in (folder, other)
        )
        assert files.keys() == others.keys()
        assert [name for name, content in files.items() if content != others[name]] == []
