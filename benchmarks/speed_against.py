"""How fast joints of the paper's study close here against another clone, and how alike.

The base case of each rock, as the study closes it: the first --surfaces surfaces in turn by this
clone and by the --other one, each by the Python of its .venv in one process of its own, so that
other work on the machine disturbs both alike. Times are the smallest processor time of --repeats.
The first --joints surfaces of each rock are compared by maximum closures of both cycles: mean paired
changes with standard errors. --output is a folder.
Run as `python benchmarks/speed_against.py --other ../earlier`.
"""

import json
import subprocess
from pathlib import Path

import yardstick

# isort: split
import pandas as pd

from jointclosure.statistics.standard_errors import mean_of

CYCLES = (1, 2)
WORK = """
import json, sys
sys.path.insert(0, "benchmarks")
import yardstick
configuration, cases = yardstick.paper_study()
case_of = {case.rock: case for case in cases}
print(json.dumps(list(case_of)), flush=True)
for line in sys.stdin:
    rock, surface = json.loads(line)
    seconds, joint = yardstick.base_case(configuration, case_of[rock], surface)
    closures = [float(closure) for closure in joint["max_closure"]]
    counts = [int(joint[name]) for name in ("settled_states", "equilibria", "solver_iterations")]
    print(json.dumps([seconds, int(joint.status), *closures, *counts]), flush=True)
"""
"""Program for a clone's folder: simulates the joints that its standard input names."""
COLUMNS = ["seconds", "status", "closure 1", "closure 2", "settled", "equilibria", "products"]


class Clone:
    """Process in the folder of a clone, which simulates joints of the ``rocks`` of its study."""

    def __init__(self, folder: Path):
        python = folder.resolve() / ".venv" / "bin" / "python"
        self._process = subprocess.Popen(
            [python, "-c", WORK],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.rocks: list[str] = self._answer()

    def closed(self, rock: str, surface: int) -> dict:
        """Simulate a joint; return its values by `COLUMNS`."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps([rock, surface]) + "\n")
        self._process.stdin.flush()
        return dict(zip(COLUMNS, self._answer(), strict=True))

    def end(self) -> None:
        """End the process."""
        self._process.communicate()

    def _answer(self) -> list:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit(f"{self._process.args[0]}: ended without an answer")
        return json.loads(line)


def compared(arguments) -> pd.DataFrame:
    """Simulate all joints in both clones, timed ones several times; return a row for each."""
    clones = {"here": Clone(Path(__file__).parents[1]), "other": Clone(arguments.other)}
    rows = []
    for rock in clones["here"].rocks:
        clones["other"].closed(rock, 0)  # to load or compile
        clones["here"].closed(rock, 0)
        for surface in range(max(arguments.joints, arguments.surfaces)):
            timed = surface < arguments.surfaces
            tries = [
                {name: clone.closed(rock, surface) for name, clone in clones.items()}
                for _ in range(arguments.repeats if timed else 1)
            ]
            row = {"rock": rock, "surface": surface, "timed": timed}
            for name in clones:
                answer = tries[0][name]
                answer["seconds"] = min(some[name]["seconds"] for some in tries)
                row |= {f"{name} {column}": value for column, value in answer.items()}
            rows.append(row)
    for clone in clones.values():
        clone.end()
    return pd.DataFrame(rows)


def summarised(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate times, and changes [%] of mean net closures, by rock and of all rocks together."""
    rows = []
    for rock, joints in [*table.groupby("rock", sort=False), ("all", table)]:
        timed = joints[joints.timed]
        row = {"rock": rock, "timed joints": len(timed)}
        for name in ("here", "other"):
            row[f"{name} ms"] = 1e3 * timed[f"{name} seconds"].mean()
        row["ratio of times"] = timed["here seconds"].sum() / timed["other seconds"].sum()
        for column in ("settled", "equilibria", "products"):
            row[f"ratio of {column}"] = (
                joints[f"here {column}"].sum() / joints[f"other {column}"].sum()
            )
        row["joints"] = len(joints)
        for cycle in CYCLES:
            here, other = (joints[f"{name} closure {cycle}"] for name in ("here", "other"))
            # changes are relative to the mean of the rock, so that all rocks count alike
            means = joints.groupby("rock")[f"other closure {cycle}"].transform("mean")
            mean, error = mean_of(100.0 * ((here - other) / means).to_numpy())
            row |= {f"closure {cycle} change %": mean, f"closure {cycle} standard error %": error}
        row["worst status here"] = joints["here status"].max()
        row["worst status other"] = joints["other status"].max()
        rows.append(row)
    return pd.DataFrame(rows)


def main(arguments) -> None:
    """Print machine and table, and write them."""
    print(yardstick.machine(), flush=True)
    table = compared(arguments)
    yardstick.show("this clone against the other", summarised(table), arguments.output, "against")
    if arguments.output:
        table.to_csv(arguments.output / "joints.csv", index=False)


if __name__ == "__main__":
    given = {"other": Path, "surfaces": 5, "repeats": 5, "joints": 60, "output": Path}
    main(yardstick.options(__doc__, **given))
