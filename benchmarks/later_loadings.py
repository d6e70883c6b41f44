"""What a second and a third loading of a joint do by each mechanism of the loop of later loadings.

Joints of `studies/measured_joints` with rock of 60 MPa are loaded three times: with crushed rock as
strong as the rock or 0.8 times, left in their place; and reseated before each later loading, the
upper wall another cell along x. Without opening the joint, walls cannot be reseated, so that those
with rock of full strength are its prediction for loadings that follow without opening; strength of
crushed rock does not depend on opening. Reseated walls lose a rim, which a control loses too. What
breaks is counted in cells of both walls that are lower after a loading than before, and in the
volume by which they are. `python -m benchmarks.later_loadings` takes five minutes
of a core.
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import chain, islice
from pathlib import Path

import numpy as np
import pandas as pd

from jointclosure.engine.joints import closed_walls, read_joint
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.walls.pairs import CrushedWalls, Walls
from studies.frame.configuration import configured, merged_study
from studies.frame.settings import ClosureSettings, walls_of
from studies.measured_joints.study import EXPERIMENT

STUDY = Path("studies/measured_joints/measured_joints.yaml")
ROCK, RATIO = "strength 60 MPa", 0.8
MECHANISMS = {
    "left in place": (1.0, 0, 0),
    f"crushed rock {RATIO:g} as strong": (RATIO, 0, 0),
    "reseated, a cell off": (1.0, 1, 0),
    "in place, rim cut as by reseating": (1.0, 1, 1),
}
"""Strength of crushed rock over that of the rock, and cells along x that the upper and the lower
wall lose at their start before each later loading."""
LATER = (2, 3)
WAVELENGTHS = ("3000um", "6000um", "12000um")
"""Jobs of the study next to the wavelengths that are fitted to the three measured joints."""
NAMES = ("max_closure_seated_net", "residual_closure_seated_net", "stiffness_net", "broken_share")
KEYS = ["wavelength_mm", "mechanism", "loading"]


def shifted(pair: Walls, upper: int, lower: int) -> Walls:
    """Shift walls (y, x) along x by numbers of cells; both keep the cells that meet."""
    width = pair[0].shape[1] - max(upper, lower)
    return pair[0][:, upper : upper + width], pair[1][:, lower : lower + width]


def loadings(pristine: Walls, settings: ClosureSettings) -> Iterator[dict]:
    """Generate a row of each later loading by each mechanism."""
    once = settings.conditions._replace(cycles=1)
    first, crushed = loaded(pristine, pristine, once)
    for mechanism, (ratio, *shift) in MECHANISMS.items():
        weaker = once._replace(choices=once.choices._replace(crushed_strength_ratio=ratio))
        pair, intact = crushed, pristine
        for loading in LATER:
            pair, intact = shifted(pair, *shift), shifted(intact, *shift)
            later, pair = loaded(pair, intact, weaker)
            yield {
                "mechanism": mechanism,
                "loading": loading,
                "closure_mm": 1e3 * later["max_closure_seated_net"],
                "stays_percent": 100.0 * later["stays"],
                "stiffness_over_first": later["stiffness_net"] / first["stiffness_net"],
                "cells_over_first": later["broken_share"] / first["broken_share"],
                "volume_over_first": later["volume"] / first["volume"],
            }


def loaded(pair: Walls, pristine: Walls, once: Conditions) -> tuple[dict[str, float], Walls]:
    """Load walls (y, x) [m] once, and return quantities and the walls that are left."""
    joint = closed_walls(CrushedWalls(pair, pristine), once)
    if joint.closed.status >= FAILURE:
        raise RuntimeError(f"a loading failed with status {int(joint.closed.status)}")
    row, left = read_joint(joint, NAMES), joint.final
    read = {name: float(np.ravel(row[name])[0]) for name in NAMES}
    read["stays"] = read["residual_closure_seated_net"] / read["max_closure_seated_net"]
    read["volume"] = float(np.maximum(np.array(pair) - left, 0.0).mean())  # over the area
    return read, left


def joint_rows(label: str, joint: int) -> list[dict]:
    """Load one joint of a job by all mechanisms, and return its rows."""
    jobs = EXPERIMENT.design(configured(merged_study(STUDY))).jobs()
    point = next(p for p in jobs[label] if p.coordinates["variant"] == ROCK)
    at = {"wavelength_mm": 1e3 * point.coordinates["wavelength"]}
    pair = next(islice(walls_of(point.settings), joint, None))
    return [at | row for row in loadings(pair, point.settings)]


def main() -> None:
    """Load all joints and write means over them with standard errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=10, help="of each wavelength, up to 12")
    parser.add_argument("--wavelengths", nargs="+", default=WAVELENGTHS, help="jobs of the study")
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/later_loadings"))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    tasks = [(label, joint) for label in asked.wavelengths for joint in range(asked.joints)]
    with ProcessPoolExecutor(2) as workers:
        rows = list(chain(*workers.map(joint_rows, *zip(*tasks, strict=True))))
    summary = []
    for at, part in pd.DataFrame(rows).groupby(KEYS, sort=False):
        row = dict(zip(KEYS, at, strict=True)) | {"joints": len(part)}
        for name in part.columns.drop(KEYS):
            row[name], row[f"{name}_error"] = mean_of(part[name])
        summary.append(row)
    table = pd.DataFrame(summary)
    write_csv(table, asked.output / "later_loadings.csv")
    print(table.to_string(index=False))
    write_origin(asked.output)


if __name__ == "__main__":
    main()
