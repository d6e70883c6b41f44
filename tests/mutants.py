"""Changes of one line that the fast tests must notice: `python -m tests.mutants [words of a file]`.

Each entry of ``mutants.yaml`` names a file, texts that occur once in it, the wrong text in place of
each, and the tests that should fail. Tests run in copies of the clone, so that its files never
change, and in processes that are forked after the import of libraries, which takes long.
"""

import importlib
import os
import shlex
import shutil
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import yaml

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_suffix(".yaml")
COPIES = ROOT / "build/mutants"
KERNELS = "src/jointclosure/compiled"
KINDS = ("law", "limit")
"""Kinds of mutants: of a law, a statistic or a file; of a correction, a limit or a guard."""
LEAST, LEAST_LIMITS = 100, 40
"""Least number of mutants in the list, and of those of the kind ``limit``."""
MOST_MISSED = 5
"""Largest number of mutants of the whole list that may go unnoticed."""
LIBRARIES = ("numba", "scipy.optimize", "scipy.stats", "scipy.interpolate", "scipy.ndimage",
             "scipy.sparse.linalg", "pandas", "xarray", "netCDF4", "hypothesis.strategies",
             "mpmath", "matplotlib.pyplot", "seaborn")  # fmt: skip


class Mutant(NamedTuple):
    """Wrong line: its file, the right and the wrong text, the tests that are run, and its kind."""

    file: str
    old: str
    new: str
    tests: str
    kind: str


def mutants() -> list[Mutant]:
    """Return all mutants of the list; raise `ValueError` for one that does not fit its file."""
    listed = [
        Mutant(entry["file"], old, new, entry["tests"], entry.get("kind", "law"))
        for entry in yaml.safe_load(LIST.read_text(encoding="utf-8"))
        for old, new in entry["lines"].items()
    ]
    for mutant in listed:
        count = (ROOT / mutant.file).read_text(encoding="utf-8").count(mutant.old)
        if count != 1 or mutant.old == mutant.new or mutant.kind not in KINDS:
            raise ValueError(f"{mutant.file}: {mutant.old!r} occurs {count} times, must be once")
    return listed


def copied(number: int) -> Path:
    """Copy the files that Git tracks, and compiled kernels, to a folder; return it."""
    copy = COPIES / f"clone_{number}"
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    shutil.rmtree(copy, ignore_errors=True)  # it may have files that Git no longer tracks
    copy.mkdir(parents=True)
    command = ["tar", "-c", "--null", "-T", "-", "-f", "-"]
    packed = subprocess.run(command, cwd=ROOT, input=files.stdout, capture_output=True, check=True)
    subprocess.run(["tar", "-x"], cwd=copy, input=packed.stdout, check=True)
    if (ROOT / KERNELS).is_dir():
        shutil.copytree(ROOT / KERNELS, copy / KERNELS, dirs_exist_ok=True)
    return copy


def started(copy: Path, tests: str) -> int:
    """Start tests in a copy, with its package, in a forked process; return the process's number."""
    if number := os.fork():
        return number
    code = 3
    try:
        with open(copy.with_suffix(".txt"), "wb") as printed:
            os.dup2(printed.fileno(), 1)
            os.dup2(printed.fileno(), 2)
        os.chdir(copy)
        own = [str(copy / "src"), str(copy)]
        sys.path[:] = own + [path for path in sys.path if Path(path).resolve() not in _PLACES]
        os.environ["PYTHONPATH"] = os.pathsep.join(own)
        os.environ["JOINTCLOSURE_CACHE"] = str(copy.with_name("cache"))
        for name in [name for name in sys.modules if name.partition(".")[0] in _PACKAGES]:
            del sys.modules[name]
        import pytest

        words = ["-x", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
        words += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
        code = int(pytest.main([*words, *shlex.split(tests)]))
    except BaseException:  # the process must end here; its file has the error
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


_PACKAGES = ("tests", "studies", "jointclosure")
_PLACES = (ROOT, ROOT / "src")


def noticed(chosen: Sequence[Mutant], copies: Sequence[Path]) -> Iterator[tuple[int, bool, float]]:
    """Generate (place, whether a test notices the mutant, seconds) in the order of completion."""
    waiting, free = list(enumerate(chosen)), list(copies)
    running: dict[int, tuple[int, Path, str, float]] = {}
    while waiting or running:
        while waiting and free:
            place, mutant = waiting.pop(0)
            copy = free.pop()
            text = (copy / mutant.file).read_text(encoding="utf-8")
            (copy / mutant.file).write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
            begun = time.perf_counter()
            running[started(copy, mutant.tests)] = place, copy, text, begun
        number, status = os.wait()
        place, copy, text, begun = running.pop(number)
        (copy / chosen[place].file).write_text(text, encoding="utf-8")
        code = os.waitstatus_to_exitcode(status)
        if code not in (0, 1, 2):  # 2: stopped at a failure
            raise RuntimeError(copy.with_suffix(".txt").read_text(encoding="utf-8")[-2000:])
        yield place, code != 0, time.perf_counter() - begun
        free.append(copy)


def main(words: list[str]) -> int:
    """Run the mutants of files whose path has one of the words; return 1 if too many are missed."""
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", NUMBA_NUM_THREADS="1")
    chosen = [m for m in mutants() if not words or any(word in m.file for word in words)]
    copies = [copied(number) for number in range(os.cpu_count() or 1)]
    for library in LIBRARIES:
        importlib.import_module(library)
    # tests must pass without any mutant: each set of them is run on unchanged copies first
    unchanged = [
        Mutant("README.md", "\0", "\0", tests, "law") for tests in {m.tests for m in chosen}
    ]
    for place, failed, _ in noticed(unchanged, copies):
        if failed:
            raise SystemExit(f"{unchanged[place].tests}: fails without any mutant")
    missed = 0
    for done, (place, caught, seconds) in enumerate(noticed(chosen, copies), 1):
        mutant, state = chosen[place], "noticed" if caught else "MISSED"
        print(f"{done}/{len(chosen)} {state} {seconds:.0f} s {mutant.file}: {mutant.new}")
        sys.stdout.flush()
        missed += not caught
    print(f"{len(chosen) - missed} of {len(chosen)} mutants are noticed")
    return int(missed > MOST_MISSED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
