"""Processor time of a study by part, and of a run with nothing to do, beside another version's.

python benchmarks/start_up.py --against 84c08da --config config/smoke.yaml --cells 24

Both versions run the study in folders of their own, by turns, with their kernels compiled before.
Times are user and system time of all processes, with half the range of the repeats. The parts are
of this version: closing (walls and closures) and analysing by the jobs' clocks, which begin behind
the imports that jobs share; a run with nothing to do; the rest is the start of jobs, imports and
their scheduling. The other version is taken to spend the same on analysing, and on closing the
time of this one over the ratio that benchmarks/versions.py measured (--closing-ratio).
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from versions import ROOT, source_of
from yardstick import machine, show

CLOSING = ("make_surfaces", "close_surfaces")
PARTS = ("workflow", "config", "Snakefile")


def project(source: Path, config: dict) -> Path:
    """Add a configuration to a copy of the project, and return the copy."""
    (source / "study.yaml").write_text(yaml.safe_dump(config))
    return source


def processor_time(folder: Path, *words: str) -> float:
    """Return user and system time [s] of a Python program and of all that it waits for."""
    with open(folder / "output.txt", "w") as output:
        environment = os.environ | {"CONFIG": "study.yaml", "PYTHONPATH": str(folder / "src")}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        process = subprocess.Popen(
            [sys.executable, *words], cwd=folder, env=environment, stdout=output, stderr=output
        )
        _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{folder}: {(folder / 'output.txt').read_text()}")
    return used.ru_utime + used.ru_stime


def run(folder: Path) -> dict[str, float]:
    """Run the study from nothing, and once more; return both times [s]."""
    for place in ("results", ".snakemake"):
        shutil.rmtree(folder / place, ignore_errors=True)
    command = ("workflow/scripts/run.py", "study")
    return {name: processor_time(folder, *command) for name in ("study", "again")}


def clocks(folder: Path) -> dict[str, float]:
    """Return processor time [s] of closing and of analysing, by the jobs' clocks."""
    spent = {"closing": 0.0, "analysing": 0.0}
    for file in folder.glob("results/*/benchmarks/**/*.tsv"):
        rule = file.relative_to(next(folder.glob("results/*/benchmarks"))).parts[0]
        part = "closing" if rule.removesuffix(".tsv") in CLOSING else "analysing"
        spent[part] += float(pd.read_csv(file, sep="\t").cpu_time.iloc[0])
    return spent


def with_range(values: list[float]) -> str:
    """Format a mean with half the range, which a single value does not have."""
    if len(values) == 1:
        return f"{values[0]:.3g}"
    return f"{np.mean(values):.3g} ± {0.5 * np.ptp(values):.1g}"


def measured(config: dict, arguments: argparse.Namespace) -> dict[str, list[dict[str, float]]]:
    """Return the times [s] of both versions, a dictionary a repeat."""
    rows: dict[str, list[dict[str, float]]] = {"before": [], "now": []}
    with tempfile.TemporaryDirectory() as name:
        sides = {}
        for side, revision in (("before", arguments.against), ("now", arguments.revision)):
            (folder := Path(name, side)).mkdir()
            source_of(revision, folder, *PARTS)
            sides[side] = project(folder, config)
            note = f"results/{config['study']['name']}/logs/kernels.txt"
            kernels = ("-m", "snakemake", "--cores", "1", "--configfile", "study.yaml", "--", note)
            processor_time(folder, *kernels)
        for repeat in range(arguments.repeats):
            for side in sorted(sides, reverse=bool(repeat % 2)):
                rows[side].append(run(sides[side]))
            work = clocks(sides["now"])
            for side, ratio in (("before", arguments.closing_ratio), ("now", 1.0)):
                row, parts = rows[side][-1], work | {"closing": work["closing"] / ratio}
                row |= parts | {"start": row["study"] - row["again"] - sum(parts.values())}
    return rows


def main(arguments: argparse.Namespace) -> None:
    """Print the table."""
    print(machine(), flush=True)
    config = yaml.safe_load(arguments.config.read_text())
    if arguments.cells:
        config["grid"] = {"cells_x": arguments.cells, "cells_y": arguments.cells}
    os.environ["CORES"] = str(arguments.cores)
    rows = measured(config, arguments)
    pairs = list(zip(rows["before"], rows["now"], strict=True))
    parts = list(pairs[0][0])
    table = pd.DataFrame(
        {side: {part: with_range([row[part] for row in of]) for part in parts}
         for side, of in rows.items()}
    )  # fmt: skip
    ratios = {
        part: with_range([now[part] / before[part] for before, now in pairs]) for part in parts
    }
    table["now over before"] = pd.Series(ratios)
    title = f"Processor time (s) of a study, {arguments.repeats} repeats"
    show(title, table.reset_index(names="part"), arguments.output, "start_up")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--against", default="84c08da", help="revision of the other version")
    parser.add_argument("--revision", default="HEAD", help="revision of this version")
    parser.add_argument(
        "--closing-ratio", type=float, default=1.0, help="time of a joint now over before"
    )
    parser.add_argument("--config", type=Path, default=ROOT / "config/smoke.yaml")
    parser.add_argument("--cells", type=int, default=24, help="along a wall")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--output", type=Path, help="folder for the table as CSV")
    main(parser.parse_args())
