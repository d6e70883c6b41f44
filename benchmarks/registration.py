"""Registration of pairs of scans of known truth: errors of rotation, shift, and closure.

Each upper scan is rotated by up to 180 degrees and tilted by up to 5, has another origin, is
turned over or a cloud of points in some pairs; both scans have noise and missing heights.

    .venv/bin/python -m benchmarks.registration [--pairs 40] [--close] [--output FOLDER]

With --cells 64 --mating 3.5, for example, all walls have 64 x 64 cells of 0.25 mm and mate beyond
3.5 mm, and are scanned as grids. Pairs that are refused are printed, and left out of the tables.

Whether ranges contain closures of the true walls is measured by `benchmarks.range_coverage`.
"""

import argparse
import math
import time
from pathlib import Path

import numpy as np
import pandas as pd
import scipy

import jointclosure as jc
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.joint.result_tables import cycle_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.ranged_results import CLOSURE_NET
from jointclosure.walls.gridding import Cloud, Scan, points_of, usual_grid_spacing
from jointclosure.walls.planes import detrended
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration import registered

RATIOS = {
    "closure": "ratio",
    "noise_alone": "ratio_by_noise",
    "mirrored": "ratio_of_mirror",
}
"""Closures over that of the true walls: registered; in their true position with noise; mirrored."""
OVER = np.diag([1.0, -1.0, -1.0])


def rotation(about: str, degrees: float) -> np.ndarray:
    return scipy.spatial.transform.Rotation.from_euler(about, degrees, True).as_matrix()


class Truth:
    """Walls without noise, z upwards, and scans of them; ``stated`` values are not drawn."""

    def __init__(self, number: int, **stated: float) -> None:
        random = generator(seed_of(1, "registration", number))
        drawn = {
            "cell": 1e-3 * random.choice([0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5]),
            "rotation": random.uniform(0.0, 180.0),
            "tilt": random.uniform(0.0, 5.0),
            "noise": 1e-6 * random.uniform(0.0, 15.0),
            "mating": 1e-3 * 10.0 ** random.uniform(math.log10(0.5), math.log10(5.0)),
            "jrc": random.uniform(6.0, 14.0),
            "over": number % 3 == 1,
            "cloud": number % 5 == 4,
            "cells": int(random.integers(140, 240)),
        }
        self.about = drawn | stated
        self.lower_cell = self.about.get("lower_cell", self.about["cell"])
        self.cell, cells = self.about["cell"], int(self.about["cells"])
        fine = self.cell / 2.0
        shape = (2 * cells, 2 * cells)
        walls = jc.wall_pair(
            self.about["jrc"], shape, fine, number, roll_off=None,
            mismatch_wavelength=self.about["mating"], unusual_values=True,
        )  # fmt: skip
        steepness = self.about.get("steepness", 1.0)
        self.fine = fine
        self.upper = -walls[0] * steepness
        self.lower = walls[1] * steepness
        middle = 0.5 * fine * (np.array([shape[1], shape[0], 0]) - 1.0)
        tilt_axis = rotation("z", random.uniform(0.0, 360.0))
        tilt = tilt_axis @ rotation("x", self.about["tilt"]) @ tilt_axis.T
        turn = rotation("z", self.about["rotation"])
        self.rotation = turn @ (OVER if self.about["over"] else np.eye(3)) @ tilt
        self.middle = middle
        self.own = np.array([*random.uniform(-0.05, 0.05, 2), 0.0])
        self.random = random

    def scans(self) -> tuple[Scan | Cloud, Scan | Cloud]:
        """Return the scans, the upper one in its frame p = rotation^T (q - middle) + own."""
        half = math.hypot(*self.middle[:2]) if self.about["rotation"] else max(self.middle)
        count = int(2 * half / self.cell)
        along = self.cell * (np.arange(count) - 0.5 * (count - 1) + self.random.uniform())
        x, y = np.meshgrid(along, along)
        points = np.stack([x, y, np.zeros_like(x)], axis=-1)
        spline = scipy.ndimage.spline_filter(self.upper)
        heights = None
        for _ in range(40):
            at = points @ self.rotation.T + self.middle
            places = np.moveaxis(at[..., 1::-1] / self.fine, -1, 0)
            heights = scipy.ndimage.map_coordinates(spline, places, prefilter=False, mode="mirror")
            last = np.reshape(self.upper.shape, (2, 1, 1)) - 1.0
            heights[((places < 0.0) | (places > last)).any(axis=0)] = np.nan
            step = (np.nan_to_num(heights) - at[..., 2]) / self.rotation[2, 2]
            points[..., 2] += 0.9 * step
        upper = np.where(np.isfinite(heights), points[..., 2], np.nan)
        kept = np.isfinite(upper)
        rows, columns = (np.flatnonzero(kept.any(axis=axis)) for axis in (1, 0))
        part = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        origin = (
            float(along[rows[0]] + self.own[1]), float(along[columns[0]] + self.own[0])
        )  # fmt: skip
        above = Scan(self._damaged(upper[part]), (self.cell,) * 2, origin)
        below = Scan(self._damaged(self._lower_nodes()), (self.lower_cell,) * 2, (0.0, 0.0))
        if not self.about["cloud"]:
            return above, below
        scattered = points_of(above)
        return Cloud(self.random.permutation(scattered)), below

    def _lower_nodes(self) -> np.ndarray:
        """Return the lower wall (y, x) [m] at the nodes of its scan."""
        if self.lower_cell == self.cell:
            return self.lower[::2, ::2].copy()
        ends = [(side - 1) * self.fine for side in self.lower.shape]
        places = (np.arange(0.0, end, self.lower_cell) / self.fine for end in ends)
        nodes = np.meshgrid(*places, indexing="ij")
        return scipy.ndimage.map_coordinates(self.lower, nodes, mode="mirror")

    def _damaged(self, wall: np.ndarray) -> np.ndarray:
        """Add noise and leave out 5 % of the heights, half of them in holes."""
        wall = wall + self.about["noise"] * self.random.standard_normal(wall.shape)
        wall[self.random.random(wall.shape) < 0.025] = np.nan
        for _ in range(max(int(0.025 * wall.size / 25), 0)):
            y, x = (self.random.integers(n) for n in wall.shape)
            wall[y : y + 5, x : x + 5] = np.nan
        return wall

    def errors(self, motion) -> tuple[float, float, np.ndarray]:
        """Return the errors of a motion: angle [degrees], shift [cells], and (angle, x, y) [SI]."""
        apart = motion.rotation @ self.rotation.T
        vector = scipy.spatial.transform.Rotation.from_matrix(apart).as_rotvec()
        place = self.rotation @ (motion.middle - self.own) + self.middle
        shift = motion.place - place
        errors = np.array([vector[2], *shift[:2]])
        return math.degrees(vector[2]), float(np.hypot(*shift[:2])) / self.cell, errors

    def walls(self, pair: RegisteredPair) -> tuple[np.ndarray, np.ndarray]:
        """Return the walls of a registered pair without noise and missing heights."""
        step = round(pair.spacing / self.fine)
        x, y = np.rint(pair.first / self.fine).astype(int)
        ny, nx = pair.upper.shape
        part = np.s_[y : y + ny * step : step, x : x + nx * step : step]
        return detrended(-self.upper[part]), detrended(self.lower[part])


def closure(upper: np.ndarray, lower: np.ndarray, spacing: float) -> float:
    """Simulate two walls (y, x) [m]; return the net closure of the cycle [mm]."""
    conditions = Conditions(spacing, "granite", 10e6, 1, numerics=RESOLVED).checked()
    return float(cycle_table(simulate_walls(upper, lower, conditions))[CLOSURE_NET].iloc[0])


def compared(number: int, close: bool, **stated: float) -> dict[str, float]:
    """Register a pair and return its errors; with ``close`` also its closures and the true one."""
    truth = Truth(number, **stated)
    scans = truth.scans()
    start = time.process_time()
    pair = registered(*scans, usual_grid_spacing(truth.cell))
    seconds = time.process_time() - start
    assert pair.mated is not None
    angle, shift, errors = truth.errors(pair.mated)
    scores = errors / np.sqrt(np.diag(pair.mated.covariance))
    row = truth.about | {"angle": angle, "shift_in_cells": shift, "seconds": seconds}
    row |= dict(zip(("z_angle", "z_x", "z_y"), scores, strict=True)) | {"share": pair.overlap}
    row["error_factor"] = pair.error_factor
    if close:
        row["closure_mm"] = closure(pair.upper, pair.lower, pair.spacing)
        row["true_mm"] = closure(*truth.walls(pair), pair.spacing)
        row["ratio"] = row["closure_mm"] / row["true_mm"]
        noisy = (
            wall + truth.about["noise"] * truth.random.standard_normal(wall.shape)
            for wall in truth.walls(pair)
        )
        row["ratio_by_noise"] = closure(*noisy, pair.spacing) / row["true_mm"]
        mirrored = (np.ascontiguousarray(wall[:, ::-1]) for wall in truth.walls(pair))
        row["ratio_of_mirror"] = closure(*mirrored, pair.spacing) / row["true_mm"]
    return row


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Count pairs within the aims: 0.02 degrees, a tenth of a cell, and 5 % of the closure."""
    scores = np.sqrt((table[["z_angle", "z_x", "z_y"]] ** 2).mean())
    errors = {"degrees": table.angle.abs(), "cells": table.shift_in_cells}
    aims = {"degrees": 0.02, "cells": 0.1}
    if "ratio" in table:
        for name, ratio in RATIOS.items():
            errors[name] = (table[ratio] - 1.0).abs()
            aims[name] = 0.05
    row = {"pairs": len(table), "rms_degrees": float((table.angle**2).mean() ** 0.5)}
    row |= {f"rms_{name}": value for name, value in scores.items()}
    stated = table[[*scores.index]].div(table.error_factor, axis=0)
    row |= {f"stated_rms_{name}": (stated[name] ** 2).mean() ** 0.5 for name in stated}
    for name, error in errors.items():
        row |= {f"{name}_within": int((error <= aims[name]).sum()), f"{name}_aim": aims[name]}
        row |= {f"{name}_median": error.median(), f"{name}_largest": error.max()}
    return pd.DataFrame([row])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--close", action="store_true")
    parser.add_argument("--cells", type=int, help="cells of 0.25 mm along a side of all walls")
    parser.add_argument("--mating", type=float, help="mismatch wavelength of all walls [mm]")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    stated: dict[str, float] = {}
    if options.cells:
        stated |= {"cells": options.cells, "cell": 0.25e-3, "cloud": False}
    if options.mating:
        stated["mating"] = 1e-3 * options.mating
    output = options.output or Path("benchmarks/results/registration")
    output.mkdir(parents=True, exist_ok=True)
    rows = []
    for number in range(options.first, options.first + options.pairs):
        try:
            rows.append(compared(number, options.close, **stated))
        except jc.InputError as error:
            print(number, error, flush=True)
            continue
        print(pd.DataFrame(rows[-1:]).round(4).to_string(header=number == 0), flush=True)
    table = pd.DataFrame(rows)
    result = summary(table)
    write_csv(table, output / "registration.csv")
    write_csv(result, output / "summary.csv")
    words = f"--first {options.first} --pairs {options.pairs}"
    given = {"cells": options.cells, "mating": options.mating}
    words += "".join(f" --{name} {value:g}" for name, value in given.items() if value)
    write_origin(output, words + (" --close" if options.close else ""))
    print(result.T.to_string(header=False))


if __name__ == "__main__":
    main()
