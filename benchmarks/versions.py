"""How much faster the study's simulations are than those of another version of this project.

Takes the source of a revision from the repository's history (--against) and closes the study's own
walls of each rock's base case, both cycles, in two processes that take turns on each surface, each
by its own defaults, after one joint that is not timed. The least CPU time of all repetitions
counts, as others on the machine only add to it; FFT pairs are timed in between. The median of the
ratios of single surfaces has the interval that holds it in 95 % of samples. "identical" counts
surfaces of which every number is the same to the last bit. Differences are of means over the
surfaces, with errors by pairs. Both versions need the same packages, and `jointclosure.simulate`.
Run as `python benchmarks/versions.py`.
"""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple

import yardstick

# isort: split
import numpy as np
import pandas as pd
import scipy.stats

ROOT = Path(__file__).parents[1]
CLOSE = """
import hashlib, json, sys, time
import numpy as np
import jointclosure as jc
assert jc.__file__.startswith(sys.argv[1]), jc.__file__
for line in sys.stdin:
    request = json.loads(line)
    with np.load(request["walls"]) as walls:
        upper, lower = walls["upper"], walls["lower"]
    rock = jc.Rock(*request["rock"])
    start = time.process_time()
    bound = {"strength_bound": "none"} if "strength_bound" in jc.Choices._fields else {}
    closed = jc.simulate(upper, lower, spacing=request["spacing"], rock=rock,
                         max_normal_stress=request["stress"], choices=jc.Choices(**bound))
    seconds = time.process_time() - start
    digest = hashlib.sha256()
    for name in sorted(closed.data_vars):
        digest.update(name.encode() + closed[name].values.tobytes())
    print(json.dumps(dict(s=seconds, digest=digest.hexdigest(),
                          products=int(closed.solver_iterations),
                          steps=int(closed.breakage_steps),
                          closures=closed.max_closure.values.tolist())), flush=True)
"""


class Version(NamedTuple):
    """Requests and answers of a process that closes joints with the source of one version."""

    source: Path
    requests: IO[str]
    answers: IO[str]

    def close(self, request: dict) -> dict:
        """Seconds, counts and maximum closures of a simulation."""
        print(json.dumps(request), file=self.requests, flush=True)
        answer = self.answers.readline()
        if not answer:
            raise SystemExit(f"a simulation by the version in {self.source} failed")
        return json.loads(answer)


@contextlib.contextmanager
def running(source: Path) -> Iterator[Version]:
    """A version's process, which ends with the context."""
    command = [sys.executable, "-c", CLOSE, str(source)]
    environment = os.environ | {"PYTHONPATH": str(source)}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=environment) as process:
        try:
            yield Version(source, process.stdin, process.stdout)
        finally:
            process.kill()


def source_of(revision: str, folder: Path, *parts: str) -> Path:
    """The package's source of a revision, and other parts of the project, written into a folder."""
    archive = folder / "source.tar"
    command = ["git", "-C", str(ROOT), "archive", "--output", str(archive), revision, "src"]
    command += parts
    if subprocess.run(command).returncode:
        raise SystemExit(f"--against {revision}: give a revision that `git log` shows, here")
    subprocess.run(["tar", "-xf", str(archive), "-C", str(folder)], check=True)
    return folder / "src"


def joints(folder: Path, arguments) -> dict[str, list[dict]]:
    """Write the walls of each simulation to files, and return its request, by rock."""
    cells = {"grid": {"cells_x": arguments.cells, "cells_y": arguments.cells}}
    configuration, cases = yardstick.paper_study(cells, {"study": {"rocks": arguments.rocks}})
    requests: dict[str, list[dict]] = {}
    for case in cases:
        settings = yardstick.block_settings(
            configuration, {case.label: case}, case.label, range(arguments.surfaces)
        )
        conditions = settings.conditions()
        for number, (upper, lower) in enumerate(yardstick.walls_of(settings.surfaces)):
            walls = folder / f"{case.rock}_{number}.npz"
            np.savez(walls, upper=upper, lower=lower)
            about = {"walls": str(walls), "rock": list(conditions.rock)}
            about |= {"spacing": conditions.spacing, "stress": conditions.max_normal_stress}
            requests.setdefault(case.rock, []).append(about)
    return requests


def median_interval(values: np.ndarray) -> tuple[float, float]:
    """Return the ends of the interval of a median (95 %): the extremes of fewer than six values."""
    n = values.size
    k = max(int(scipy.stats.binom.ppf(0.025, n, 0.5)), 1)
    return float(np.sort(values)[k - 1]), float(np.sort(values)[n - k])


def compare(rock: str, surfaces: list[dict], versions: list[Version], repeats: int) -> dict:
    """One rock's base case by both versions, the other one first: a row."""
    pair = yardstick.Pair()
    least: dict = {}
    for version in versions:
        version.close(surfaces[0])  # compiled before anything is timed
    for repetition in range(repeats):
        for number, request in enumerate(surfaces):
            pair.sample()
            for which in (0, 1) if (repetition + number) % 2 else (1, 0):
                found = versions[which].close(request)
                before = least.get((which, number), found)
                least[which, number] = found | {"s": min(found["s"], before["s"])}
    runs = [[least[which, number] for number in range(len(surfaces))] for which in (0, 1)]
    seconds = np.array([[run["s"] for run in each] for each in runs])
    ratios = seconds[1] / seconds[0]
    row = {"rock": rock, "surfaces": len(surfaces)}
    row["time over"], row["time over +-"] = yardstick.ratio_of_sums(seconds[1], seconds[0])
    row["median ratio"] = float(np.median(ratios))
    row["from"], row["to"] = median_interval(ratios)
    row["identical"] = sum(
        one["digest"] == other["digest"] for one, other in zip(*runs, strict=True)
    )
    row |= {"least of a surface": ratios.min(), "largest of a surface": ratios.max()}
    for name, each, spent in zip(("before", "now"), runs, seconds, strict=True):
        row |= {f"ms {name}": 1e3 * spent.mean(), f"pairs {name}": spent.mean() / pair.seconds}
        row |= {f"products {name}": np.mean([run["products"] for run in each])}
        row |= {f"breakage steps {name}": np.mean([run["steps"] for run in each])}
    before, now = (np.array([run["closures"] for run in each]) for each in runs)
    for cycle, (change, error) in enumerate(
        zip(*yardstick.paired_change(now, before), strict=True), start=1
    ):
        row |= {f"cycle {cycle} %": change, f"cycle {cycle} +- %": error}
    return row | {"pair ms": 1e3 * pair.seconds}


def main(arguments) -> None:
    """Print the table."""
    print(yardstick.machine(), flush=True)
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name).resolve()
        sources = (source_of(arguments.against, folder), ROOT / "src")
        versions = [stack.enter_context(running(source)) for source in sources]
        rows = []
        for rock, surfaces in joints(folder, arguments).items():
            rows.append(compare(rock, surfaces, versions, arguments.repeats))
            title = f"This version over {arguments.against}"
            yardstick.show(title, pd.DataFrame(rows), arguments.output, "versions")


if __name__ == "__main__":
    rocks = yardstick.merged_study()["study"]["rocks"]
    counts = {"surfaces": 20, "cells": 100, "repeats": 3}
    main(yardstick.options(__doc__, against="108bd62", rocks=rocks, output=Path, **counts))
