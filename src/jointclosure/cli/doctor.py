"""Checks versions, cores, thread settings, compiled kernels, memory, results folder and Snakemake,
with advice on problems. Run it where `make study` is run; it changes nothing, and fails if there
is a problem.
"""

import argparse
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil

from jointclosure.compilation.kernels import cache_folder
from jointclosure.engine.progress import duration
from jointclosure.inputs.extras import EXTRAS, installed, installing
from jointclosure.storage.provenance import versions_of

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_PACKAGES = ("numpy", "numba", "scipy", "xarray", "netCDF4", "pandas", "matplotlib", "snakemake")
_MEMORY_OF_A_JOB, _DISK_OF_A_STUDY = 0.5e9, 1e9
"""Memory of a job and disk space of the paper's study in bytes: at most 415 MB, and 0.2 GB."""

Finding = tuple[str, str, str]
"""Item checked, its state, and advice if it is not in order."""


def declare(command: argparse.ArgumentParser) -> None:
    """There are no arguments."""


def run(arguments: argparse.Namespace) -> int:
    """Print all findings; return 1 if there is any advice."""
    unwell = 0
    for what, state, advice in findings(Path.cwd()):
        unwell += bool(advice)
        more = f"\n{'':20}-> {advice}" if advice else ""
        print(f"{'!' if advice else ' '} {what + ':':<18}{state}{more}", flush=True)
    print(f"\n{unwell} with advice" if unwell else "\nno problems")
    return int(unwell > 0)


def findings(folder: Path) -> Iterator[Finding]:
    """Generate all findings for a study that is run in a folder."""
    fits = (3, 11) <= sys.version_info[:2] <= (3, 13)
    advice = "" if fits else "use Python 3.11 to 3.13: make clean setup PYTHON=python3.12"
    yield "python", f"{platform.python_version()} at {sys.executable}", advice
    versions = versions_of("jointclosure", *_PACKAGES).items()
    yield "packages", ", ".join(f"{name} {version}" for name, version in versions), ""
    have = {extra: installed(extra) for extra in EXTRAS}
    missing = [extra for extra in EXTRAS if not have[extra]]
    state = f"with {', '.join(extra for extra in EXTRAS if have[extra]) or 'none'}"
    if missing:
        state += f"; without {', '.join(missing)} ({installing(missing[0])})"
    yield "extras", state, ""
    machine = os.cpu_count() or 1
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else machine
    yield "cores", f"{cores} for this process, {machine} of the machine", ""
    yield from (_threads(cores), _memory(cores), _kernels(), _results(folder))
    yield _snakemake(folder)


def _threads(cores: int) -> Finding:
    settings = {name: os.environ.get(name) for name in THREADS}
    state = ", ".join(f"{name}={value or 'unset'}" for name, value in settings.items())
    if cores == 1 or set(settings.values()) == {"1"}:
        return "threads", state, ""
    if not any(settings.values()):  # as in any shell
        return "threads", f"{state}; make sets all to 1, and scripts should do the same", ""
    slow = "jobs that run side by side slow each other down unless each has one thread: set all to "
    return "threads", state, f"{slow}1 (make does this; .ci/environment has the line for a shell)"


def _memory(cores: int) -> Finding:
    memory = psutil.virtual_memory()
    jobs = int(memory.available / _MEMORY_OF_A_JOB)
    takes = f"a job takes up to {_MEMORY_OF_A_JOB / 1e9:g} GB: make study CORES={max(jobs, 1)}"
    state = f"{memory.available / 1e9:.1f} of {memory.total / 1e9:.1f} GB free"
    return "memory", state, takes if jobs < cores else ""


def _kernels() -> Finding:
    folder = cache_folder()
    number = len(list(folder.rglob("*.nbi")))
    state = "cold; the first joint compiles them, which takes about a minute of processor time"
    if number:
        state = f"warm, {number} kernels, {_megabytes(folder):.0f} MB"
    if older := [path for path in folder.parent.glob("numba-*") if path != folder]:
        size = sum(map(_megabytes, older))
        state += f"; {len(older)} of other versions, {size:.0f} MB, can be deleted"
    place = next(path for path in (folder, *folder.parents) if path.exists())
    advice = "not writable: set JOINTCLOSURE_CACHE to a folder that is"
    return "compiled kernels", f"{folder}: {state}", "" if os.access(place, os.W_OK) else advice


def _megabytes(folder: Path) -> float:
    return 1e-6 * sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _results(folder: Path) -> Finding:
    results = folder / "results"
    place = results if results.exists() else folder
    free = shutil.disk_usage(place).free
    state = f"{results}, {free / 1e9:.1f} GB free"
    try:
        with tempfile.NamedTemporaryFile(dir=place):
            pass
    except OSError as error:
        return "results", f"{state}, {error.strerror}", f"make {place} writable"
    room = "a study may take a gigabyte: make room" if free < _DISK_OF_A_STUDY else ""
    return "results", state, room


def _snakemake(folder: Path) -> Finding:
    """Check whether Snakemake starts, and plans the smoke study if a Snakefile is here."""
    here = (folder / "Snakefile").is_file() and (folder / "config/smoke.yaml").is_file()
    if importlib.util.find_spec("snakemake") is None:
        advice = installing("workflow") if here else ""
        return "snakemake", "not installed; only studies need it", advice
    start = time.perf_counter()
    words = ["--version"]
    if here:
        words = ["--workflow-profile", "workflow/profiles/default"]
        words += ["--configfile", "config/smoke.yaml", "--dry-run", "--quiet", "all"]
    command = [sys.executable, "-m", "snakemake", *words]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    took = duration(time.perf_counter() - start)
    if answer.returncode == 0:
        did = "plans the smoke study" if here else f"{answer.stdout.strip()} starts; no study here"
        return "snakemake", f"{did}, in {took}", ""
    output = (answer.stderr.strip() or answer.stdout.strip() or "no output").splitlines()
    return "snakemake", output[-1], "make clean setup sets up the environment again"
