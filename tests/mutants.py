"""Changes of one line that the fast tests must notice: `python -m tests.mutants [words of a file]`.

Each entry of ``mutants.yaml`` names a file, texts that occur in it once with the wrong text in
their place, and the tests that should fail. The clone is copied, so its files never change.
"""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import yaml

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_suffix(".yaml")
COPY = ROOT / "build/mutants/clone"
KERNELS = "src/jointclosure/compiled"
LEAST = 55
"""Number of mutants of the whole list that must be noticed."""


class Mutant(NamedTuple):
    """A wrong line: file, its text, the wrong text, and the tests that are run."""

    file: str
    old: str
    new: str
    tests: str


def mutants() -> list[Mutant]:
    """Return all mutants of the list; raise ValueError for one that does not fit its file."""
    listed = [
        Mutant(entry["file"], old, new, entry["tests"])
        for entry in yaml.safe_load(LIST.read_text(encoding="utf-8"))
        for old, new in entry["lines"].items()
    ]
    for mutant in listed:
        count = (ROOT / mutant.file).read_text(encoding="utf-8").count(mutant.old)
        if count != 1 or mutant.old == mutant.new:
            raise ValueError(f"{mutant.file}: {mutant.old!r} occurs {count} times, must be once")
    return listed


def copied() -> None:
    """Copy all files that Git knows, and compiled kernels, which most mutants leave valid."""
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    shutil.rmtree(COPY, ignore_errors=True)  # may have files that Git knows no longer
    COPY.mkdir(parents=True)
    command = ["tar", "-c", "--null", "-T", "-", "-f", "-"]
    packed = subprocess.run(command, cwd=ROOT, input=files.stdout, capture_output=True, check=True)
    subprocess.run(["tar", "-x"], cwd=COPY, input=packed.stdout, check=True)
    if (ROOT / KERNELS).is_dir():
        shutil.copytree(ROOT / KERNELS, COPY / KERNELS, dirs_exist_ok=True)


def failure(tests: str) -> str:
    """Run tests of the copy with its own package; return the end of what a failure printed."""
    environment = os.environ | {
        "PYTHONPATH": f"{COPY / 'src'}{os.pathsep}{COPY}",
        "JOINTCLOSURE_CACHE": str(COPY.with_name("cache")),
    }
    words = ["-x", "-q", "-n", "auto", "-m", "not slow", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *words, *tests.split()]
    done = subprocess.run(command, cwd=COPY, env=environment, capture_output=True, text=True)
    if done.returncode not in (0, 1, 2):  # 2: stopped at a failure
        raise RuntimeError(done.stdout[-2000:] + done.stderr[-2000:])
    return done.stdout[-2000:] if done.returncode else ""


def noticed(mutant: Mutant) -> bool:
    """Return whether a test of the copy fails while it has the mutant."""
    file = COPY / mutant.file
    text = file.read_text(encoding="utf-8")
    try:
        file.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        return bool(failure(mutant.tests))
    finally:
        file.write_text(text, encoding="utf-8")


def main(words: list[str]) -> int:
    """Run the mutants of all files whose path has one of the words; 1 if too few are noticed."""
    whole = mutants()
    chosen = [m for m in whole if not words or any(word in m.file for word in words)]
    copied()
    if printed := failure(" ".join(sorted({part for m in chosen for part in m.tests.split()}))):
        raise SystemExit(f"{printed}\nthe tests fail without any mutant")
    missed = []
    for number, mutant in enumerate(chosen, 1):
        start = time.perf_counter()
        caught = noticed(mutant)
        seconds = time.perf_counter() - start
        state = "noticed" if caught else "MISSED"
        print(f"{number}/{len(chosen)} {state} {seconds:.0f} s {mutant.file}: {mutant.new}")
        sys.stdout.flush()
        missed += [] if caught else [mutant]
    print(f"{len(chosen) - len(missed)} of {len(chosen)} mutants are noticed")
    return int(len(missed) > len(whole) - LEAST)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
