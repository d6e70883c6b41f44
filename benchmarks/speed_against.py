"""How fast joints of the paper's study close here against another clone, and how alike.

The base case of each rock, as the study closes it: the first --surfaces surfaces in turn by this
clone and by the --other one, each by the Python of its .venv in one process of its own, so that
other work on the machine disturbs both alike. Times are the smallest processor time of --repeats.
The first --joints surfaces of each rock are compared by maximum closures of both cycles: mean
paired changes with standard errors. --output is a folder.

Closure curves of 40 stresses without breakage follow: two pairs of walls of --elastic cells along a
side (0 leaves them out), which have several thousand contacts at 30 MPa. Both clones get the same
walls.
Run as `python benchmarks/speed_against.py --other ../earlier`.
"""

import json
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import yardstick

# isort: split
import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.statistics.standard_errors import mean_of

CYCLES = (1, 2)
WORK = """
import json, sys
sys.path.insert(0, "benchmarks")
import yardstick
import numpy as np
import jointclosure as jc
configuration, cases = yardstick.paper_study()
case_of = {case.rock: case for case in cases}
print(json.dumps(list(case_of)), flush=True)
for line in sys.stdin:
    rock, surface = json.loads(line)
    if rock in case_of:
        seconds, joint = yardstick.base_case(configuration, case_of[rock], surface)
    else:
        walls = np.load(surface)
        numerics = jc.Numerics(curve_points=40)
        seconds, joint = yardstick.timed(
            lambda: yardstick.close(walls, yardstick.ELASTIC, 30e6, numerics=numerics)
        )
    closures = [float(joint["max_closure"][cycle]) for cycle in (0, -1)]
    counts = [int(joint[name]) for name in ("settled_states", "equilibria", "solver_iterations")]
    print(json.dumps([seconds, int(joint.status), *closures, *counts]), flush=True)
"""
"""Program for a clone's folder: simulates the joints that its standard input names.

A joint is a rock of the study and the number of a surface, or a title and a file of walls.
"""
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


def elastic_walls(cells: int) -> dict[str, tuple]:
    """Return walls (y, x) [m] of the curves without breakage, by title."""
    shape = (cells, cells)
    smooth = jc.wall_pair(2.0, shape, yardstick.SPACING, 0)
    mated = jc.wall_pair(8.0, shape, yardstick.SPACING, 0, mismatch_wavelength=3e-3)
    return {"elastic, JRC 2": smooth, "elastic, mated beyond 3 mm": mated}


def joints(arguments, rocks: list[str], folder: Path) -> Iterator[tuple[str, object, int]]:
    """Generate joints as `WORK` reads them, and how often each is timed, 0 for not at all."""
    for rock in rocks:
        for surface in range(max(arguments.joints, arguments.surfaces)):
            yield rock, surface, arguments.repeats if surface < arguments.surfaces else 0
    if arguments.elastic:
        for title, walls in elastic_walls(arguments.elastic).items():
            file = folder / f"{title}.npy"
            np.save(file, np.array(walls))
            yield title, str(file), arguments.repeats


def compared(arguments) -> pd.DataFrame:
    """Simulate all joints in both clones, timed ones several times; return a row for each."""
    clones = {"here": Clone(Path(__file__).parents[1]), "other": Clone(arguments.other)}
    rows = []
    warm = set()
    with tempfile.TemporaryDirectory() as folder:
        for rock, surface, repeats in joints(arguments, clones["here"].rocks, Path(folder)):
            if rock not in warm:
                for clone in clones.values():
                    clone.closed(rock, surface)  # to load or compile
                warm.add(rock)
            tries = [
                {name: clone.closed(rock, surface) for name, clone in clones.items()}
                for _ in range(max(repeats, 1))
            ]
            row = {"rock": rock, "surface": surface, "timed": repeats > 0}
            for name in clones:
                answer = tries[0][name]
                answer["seconds"] = min(some[name]["seconds"] for some in tries)
                row |= {f"{name} {column}": value for column, value in answer.items()}
            rows.append(row)
    for clone in clones.values():
        clone.end()
    return pd.DataFrame(rows)


def summarised(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate times, and changes [%] of mean net closures, by rock and of all rocks together.

    Curves without breakage follow the rocks.
    """
    rows = []
    is_elastic = table.rock.str.startswith("elastic")
    of_study = table[~is_elastic]
    by_rock, elastic = (part.groupby("rock", sort=False) for part in (of_study, table[is_elastic]))
    for rock, joints in [*by_rock, ("all", of_study), *elastic]:
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
            changes = 100.0 * ((here - other) / means).to_numpy()
            mean, error = mean_of(changes) if changes.size > 1 else (changes.item(), np.nan)
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
    given = {
        "other": Path,
        "surfaces": 5,
        "repeats": 5,
        "joints": 60,
        "elastic": 512,
        "output": Path,
    }
    main(yardstick.options(__doc__, **given))
