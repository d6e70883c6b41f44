"""Results and time of README's first command: `jointclosure close` on the walls of config/walls.

The command is run --runs times, each in a process of its own. ranges.csv has the results of the
joint with their ranges; times.csv has the processor time and the time on the clock of each run,
with the program's start, its figures and files. Kernels are compiled before (`make setup`).

`python benchmarks/readme_joint.py` writes to --output, a folder.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import pandas as pd
from timed_commands import timed

from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.ranges import NUMBERS

WALLS = ("config/walls/joint_upper.npz", "config/walls/joint_lower.npz")
OPTIONS = ("--rock", "granite", "--stress", "10")
ROOT = Path(__file__).parents[1]


def closed(folder: Path) -> tuple[dict[str, float], list[dict]]:
    """Run the command once; return its times [s], and the ranges of its joint.json."""
    command = [Path(sys.executable).with_name("jointclosure"), "close", *WALLS, *OPTIONS]
    command += ["--output", folder]
    _, processor, clock = timed(command, cwd=ROOT, check=True)
    ranges = json.loads((folder / "joint.json").read_text(encoding="utf-8"))["range"]
    return {"processor_s": processor, "clock_s": clock}, ranges


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--output", type=Path, default=Path("results/benchmarks/readme_joint"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    times = []
    for _ in range(options.runs):
        with tempfile.TemporaryDirectory() as folder:
            seconds, ranges = closed(Path(folder))
        times.append(seconds)
        print(f"{seconds['processor_s']:.1f} s of processor time, {seconds['clock_s']:.1f} s")
    write_csv(pd.DataFrame(times), options.output / "times.csv")
    table = pd.DataFrame(ranges)[["cycle", "quantity", *NUMBERS]]  # the results, and both ranges
    write_csv(table, options.output / "ranges.csv")
    write_origin(options.output, f"{options.runs} runs")


if __name__ == "__main__":
    main()
