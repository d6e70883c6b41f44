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
from collections.abc import Iterator
from pathlib import Path

import psutil

from jointclosure.compilation.kernels import cache_folder, stored_kernels
from jointclosure.execution.workers import number_of_workers
from jointclosure.inputs.extras import EXTRAS, installed, installing
from jointclosure.storage.provenance import versions_of

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_PACKAGES = ("numpy", "numba", "scipy", "xarray", "netCDF4", "pandas", "matplotlib", "snakemake")
_MEMORY_OF_A_JOB = 0.5e9
"""Memory [bytes] that a job should find; the largest job of the paper's study took 415 MB."""
_DISK_OF_A_STUDY = 1e9
"""Disk space [bytes] that a study should find; the paper's study took 0.2 GB."""


def declare(command: argparse.ArgumentParser) -> None:
    """Declare no arguments."""


def run(arguments: argparse.Namespace) -> int:
    """Print all findings on the environment; return 1 if there is advice on a problem."""
    unwell = 0
    for what, state, advice in findings(Path.cwd()):
        unwell += bool(advice)
        more = f"\n{'':20}-> {advice}" if advice else ""
        print(f"{'!' if advice else ' '} {what + ':':<18}{state}{more}", flush=True)
    print(f"\n{unwell} with advice" if unwell else "\nno problems")
    return int(unwell > 0)


def findings(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Generate findings on the environment of a study in a folder: item, state, and advice.

    The advice is "" if the item is in order.
    """
    fits = (3, 11) <= sys.version_info[:2] <= (3, 13)
    advice = "" if fits else "use Python 3.11 to 3.13: make clean setup PYTHON=python3.12"
    yield "python", f"{platform.python_version()} at {sys.executable}", advice
    versions = versions_of("jointclosure", *_PACKAGES).items()
    yield "packages", ", ".join(f"{name} {version}" for name, version in versions), ""
    missing = [extra for extra in EXTRAS if not installed(extra)]
    state = f"with {', '.join(extra for extra in EXTRAS if extra not in missing) or 'none'}"
    without = f"; without {', '.join(missing)} ({installing(missing[0])})" if missing else ""
    yield "extras", state + without, ""
    cores = number_of_workers(None)
    yield "cores", f"{cores} for this process, {os.cpu_count()} of the machine", ""
    settings = {name: os.environ.get(name) for name in THREADS}
    state = ", ".join(f"{name}={value or 'unset'}" for name, value in settings.items())
    # unset as in any shell, or all 1 as make sets them
    fits = cores == 1 or set(settings.values()) == {"1"} or not any(settings.values())
    slow = "jobs that run side by side slow each other down unless each has one thread: set all to "
    slow += "1 (make does this; .ci/environment has the line for a shell)"
    yield "threads", state, "" if fits else slow
    memory = psutil.virtual_memory()
    jobs = int(memory.available / _MEMORY_OF_A_JOB)
    takes = f"a job takes up to {_MEMORY_OF_A_JOB / 1e9:g} GB: make study CORES={max(jobs, 1)}"
    state = f"{memory.available / 1e9:.1f} of {memory.total / 1e9:.1f} GB free"
    yield "memory", state, takes if jobs < cores else ""
    cache = cache_folder()
    advice = "not writable: set JOINTCLOSURE_CACHE to a folder that is"
    state = f"{cache}: {_state_of_kernels(*stored_kernels())}"
    yield "compiled kernels", state, "" if _writable(cache) else advice
    results = folder / "results"
    free = shutil.disk_usage(folder).free
    advice = "a study may take a gigabyte: make room" if free < _DISK_OF_A_STUDY else ""
    advice = advice if _writable(results) else f"make {results} writable"
    yield "results", f"{results}, {free / 1e9:.1f} GB free", advice
    yield _snakemake(folder)


def _state_of_kernels(stored: int, expected: int | None) -> str:
    """Return words on how many kernels are compiled, of the expected number if that is known."""
    if expected is not None and stored >= expected:
        return f"all {expected} are compiled"
    compiled = "none is compiled"
    if stored:
        of = "" if expected is None else f" of {expected}"
        more = " (how many there are is not known)" if expected is None else ""
        compiled = f"{stored}{of} are compiled{more}"
    return f"{compiled}; a joint that needs others takes up to a minute more"


def _writable(folder: Path) -> bool:
    """Return whether a file can be made in a folder, or in the parent that will hold it."""
    place = next(path for path in (folder, *folder.parents) if path.exists())
    try:
        with tempfile.TemporaryFile(dir=place):
            return True
    except OSError:
        return False


def _snakemake(folder: Path) -> tuple[str, str, str]:
    """Return item, state and advice on Snakemake, see `findings`.

    Snakemake is started: it plans the smoke study if the folder has a Snakefile.
    """
    here = (folder / "Snakefile").is_file() and (folder / "config/smoke.yaml").is_file()
    if importlib.util.find_spec("snakemake") is None:
        advice = installing("workflow") if here else ""
        return "snakemake", "not installed; only studies need it", advice
    words = ["--version"]
    if here:
        words = ["--configfile", "config/smoke.yaml", "--dry-run", "--quiet", "all"]
    command = [sys.executable, "-m", "snakemake", *words]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    if answer.returncode == 0:
        state = "plans the smoke study" if here else f"{answer.stdout.strip()}; no study here"
        return "snakemake", state, ""
    output = (answer.stderr.strip() or answer.stdout.strip() or "no output").splitlines()
    return "snakemake", output[-1], "make clean setup sets up the environment again"
