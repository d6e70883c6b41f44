"""Processor time of a whole study by this checkout, over that by another one, in turn.

    python benchmarks/workflow_cost.py ../other --config config/smoke.yaml --runs 3

Both checkouts need their environment (`make setup`) and compiled kernels (`make smoke`). Each run
makes a study from nothing, in a folder of its own, by one process after the other on all cores. The
processor time of all processes counts, and not the time on the clock, so that other work on the
machine matters little.
"""

import argparse
import os
import shutil
import statistics
import tempfile
from pathlib import Path

from timed_commands import timed

HERE = Path(__file__).parents[1]
LINKED = ("src", "studies", ".venv")
COPIED = ("Snakefile", "Makefile", "config", "workflow", "profiles")


def seconds_of_study(checkout: Path, config: str) -> float:
    """Return the processor time [s] of a study that is made from nothing."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in LINKED:
            (folder / part).symlink_to((checkout / part).resolve())
        for part in COPIED:
            source = checkout / part
            if source.is_dir():
                shutil.copytree(source, folder / part)
            elif source.is_file():
                shutil.copy(source, folder)
        command = ["make", "-o", ".venv/jointclosure-is-set-up", "study", f"CONFIG={config}"]
        answer, seconds, _ = timed(command, cwd=folder, env=os.environ, text=True, check=False)
    if answer.returncode:
        raise SystemExit(f"{checkout}: {answer.stdout[-2000:]}{answer.stderr[-2000:]}")
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", type=Path, help="folder of the other checkout")
    parser.add_argument("--config", default="config/smoke.yaml", help="study, by default smoke")
    parser.add_argument("--runs", type=int, default=3, help="runs of each checkout")
    options = parser.parse_args()
    ratios = []
    for number in range(options.runs):
        here, other = (seconds_of_study(path, options.config) for path in (HERE, options.other))
        ratios.append(here / other)
        print(f"run {number + 1}: {here:.1f} s here, {other:.1f} s there, ratio {ratios[-1]:.3f}")
    print(f"median ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")


if __name__ == "__main__":
    main()
