"""Scans that are not what was measured: what is warned of, and how far closures are off.

Walls of known truth are damaged in ways of scanners and of their software. Undamaged walls have
Hurst exponents from 0.5 to 0.9, a roll-off, ordinary noise, missing heights or short waves that
appear as longer ones; a scan may be added by --scans. Warnings of undamaged walls are false alarms.

    .venv/bin/python -m benchmarks.scan_defects [--pairs 20] [--scans FILE ...] [--units mm]
    .venv/bin/python -m benchmarks.scan_defects --noise
    .venv/bin/python -m benchmarks.scan_defects --close --pairs 4

The second command states how often the interval of a scanner's noise contains the noise that was
added to walls, whose spectrum is whole or ends at a circle. The third one closes pairs of 64 cells
(granite, 10 MPa) with their range: closures over those of the undamaged walls, before (damaged
walls as they are) and after (best and range of `close`).
"""

import argparse
import math
import warnings
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

import jointclosure as jc
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.joint.result_tables import cycle_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.ranged_results import CLOSURE_NET
from jointclosure.walls.gridding import Cloud, Scan, point_distance, wall_on_grid
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.planes import detrended
from jointclosure.walls.registration import registered
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_quality import quality_of, quality_remarks
from jointclosure.walls.spectrum_end import spectrum_end

SPACING, CELLS = 0.25e-3, 64
Damage = Callable[[np.ndarray, np.random.Generator], np.ndarray]


class Defect(NamedTuple):
    """Damage of heights (y, x) [m], of both walls or of the upper one only."""

    damage: Damage
    both: bool = True


def _steps(wall: np.ndarray) -> float:
    """Return the rms height difference of neighbours [m]."""
    return float(np.sqrt(np.mean(np.diff(wall, axis=1) ** 2)))


def _refined(wall: np.ndarray, order: int) -> np.ndarray:
    """Return every second height, with heights between them by splines of an order."""
    y, x = np.indices(wall.shape) / 2.0
    return scipy.ndimage.map_coordinates(wall[::2, ::2], [y, x], order=order, mode="nearest")


def _hole(wall: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return whether cells (y, x) are in one of six holes of 5 to 12 cells a side."""
    hole = np.zeros(wall.shape, bool)
    for _ in range(6):
        size = int(random.integers(5, 13))
        y, x = (int(random.integers(2, n - size - 2)) for n in wall.shape)
        hole[y : y + size, x : x + size] = True
    return hole


def _filled(how: str) -> Damage:
    def damage(wall: np.ndarray, random: np.random.Generator) -> np.ndarray:
        hole = _hole(wall, random)
        if how == "membrane":
            result = fill_missing(np.where(hole, np.nan, wall), "nearest", 1.0)
            for _ in range(400):
                result = np.where(hole, scipy.ndimage.uniform_filter(result, 3), result)
            return result
        return fill_missing(np.where(hole, np.nan, wall), how, 1.0)

    return damage


def _aside(which: str) -> Damage:
    def damage(wall: np.ndarray, random: np.random.Generator) -> np.ndarray:
        rows = random.choice(len(wall) - 2, len(wall) // 10, replace=False) + 1
        kept = {"some": rows, "every second": np.s_[1::2], "half": np.s_[len(wall) // 2 :]}
        result = wall.copy()
        result[kept[which]] = np.roll(wall[kept[which]], 1, axis=1)
        return result

    return damage


def _rim(wall: np.ndarray, width: int, height: float) -> np.ndarray:
    result = wall + height * _steps(wall)
    inner = np.s_[width:-width, width:-width]
    result[inner] = wall[inner]
    return result


def ended(wall: np.ndarray, radius: float) -> np.ndarray:
    """Return a wall without waves beyond a circle, over the largest wave number along an axis."""
    axes = tuple(slice(0.0, 1.0 - 1.0 / n, 1j * n) for n in wall.shape)
    inside = np.hypot(*np.ogrid[axes]) < radius
    return scipy.fft.idctn(scipy.fft.dctn(wall, norm="ortho") * inside, norm="ortho")


def _ended(radius: float, share: float = 0.0) -> Damage:
    """Return damage that ends a spectrum at a circle, and adds a share of a step of noise."""

    def damage(wall: np.ndarray, random: np.random.Generator) -> np.ndarray:
        result = ended(wall, radius)
        return result + share * _steps(wall) * random.standard_normal(wall.shape)

    return damage


def _turned(degrees: float) -> Damage:
    """Return damage that turns a grid, with heights interpolated by cubic splines."""
    return lambda wall, _: scipy.ndimage.rotate(
        wall, degrees, reshape=False, order=3, mode="mirror"
    )


DEFECTS = {
    "mean of 3 x 3": Defect(lambda w, r: scipy.ndimage.uniform_filter(w, 3)),
    "mean of 5 x 5": Defect(lambda w, r: scipy.ndimage.uniform_filter(w, 5)),
    "median of 3 x 3": Defect(lambda w, r: scipy.ndimage.median_filter(w, 3)),
    "median of 5 x 5": Defect(lambda w, r: scipy.ndimage.median_filter(w, 5)),
    "Gaussian of 0.7 cells": Defect(lambda w, r: scipy.ndimage.gaussian_filter(w, 0.7)),
    "Gaussian of 1 cell": Defect(lambda w, r: scipy.ndimage.gaussian_filter(w, 1.0)),
    "Gaussian of 2 cells": Defect(lambda w, r: scipy.ndimage.gaussian_filter(w, 2.0)),
    "Gaussian of 1 cell along x": Defect(lambda w, r: scipy.ndimage.gaussian_filter1d(w, 1.0)),
    "mean of 3 x 3, one wall": Defect(lambda w, r: scipy.ndimage.uniform_filter(w, 3), False),
    "mean of 3 x 3, rounded to 1 um": Defect(
        lambda w, r: np.round(scipy.ndimage.uniform_filter(w, 3), 6)
    ),
    "refined linearly": Defect(lambda w, r: _refined(w, 1)),
    "refined by cubic splines": Defect(lambda w, r: _refined(w, 3)),
    "rounded to 0.1 mm": Defect(lambda w, r: np.round(w, 4)),
    "holes filled linearly": Defect(_filled("linear")),
    "holes filled by a membrane": Defect(_filled("membrane")),
    "holes filled by the nearest": Defect(_filled("nearest")),
    "blocks of 2 x 2": Defect(lambda w, r: np.kron(w[::2, ::2], np.ones((2, 2)))),
    "a tenth of rows aside": Defect(_aside("some"), False),
    "every second row aside": Defect(_aside("every second"), False),
    "half of the rows aside": Defect(_aside("half"), False),
    "rim of 2 cells, 3 steps high": Defect(lambda w, r: _rim(w, 2, 3.0), False),
    "rim of 2 cells, 1 step high": Defect(lambda w, r: _rim(w, 2, 1.0), False),
    "spectrum to a circle of 1": Defect(_ended(1.0)),
    "spectrum to a circle of 0.8": Defect(_ended(0.8)),
    "circle of 1, noise of a tenth of a step": Defect(_ended(1.0, 0.1)),
    "circle of 0.8, noise of a tenth of a step": Defect(_ended(0.8, 0.1)),
    "circle of 1, noise of three tenths": Defect(_ended(1.0, 0.3)),
    "circle of 0.8, noise of three tenths": Defect(_ended(0.8, 0.3)),
    "turned by 7 degrees by cubic splines": Defect(_turned(7.0)),
    "turned by 45 degrees by cubic splines": Defect(_turned(45.0)),
    "upper wall times 1.1": Defect(lambda w, r: 1.1 * w, False),
    "upper wall times 1.03": Defect(lambda w, r: 1.03 * w, False),
}
_OF_PAIRS = "upper wall times"  # beginning of defects that only a pair shows


def undamaged() -> dict[str, Callable[[int], tuple[np.ndarray, np.ndarray]]]:
    """Return functions that make pairs of undamaged walls (y, x) [m] from a number."""
    kinds: dict[str, Callable[[int], tuple[np.ndarray, np.ndarray]]] = {}

    def pair(number: int, cells: int = CELLS, spacing: float = SPACING, **stated):
        mating = {"mismatch_wavelength": 1e-3 * 2.0 ** (number % 3)}
        options = {"roll_off": None, "unusual_values": True} | mating | stated
        return jc.wall_pair(8.0, (cells, cells), spacing, number, **options)

    def noisy(number: int, share: float):
        random = generator(seed_of(3, "noise", number))
        walls = pair(number)
        return tuple(w + share * _steps(w) * random.standard_normal(w.shape) for w in walls)

    for hurst in (0.5, 0.6, 0.7, 0.8, 0.9):
        kinds[f"H = {hurst:g}"] = lambda n, h=hurst: pair(n, hurst=h)
    kinds["roll-off of 3 mm"] = lambda n: pair(n, roll_off=3e-3)
    kinds["sampled"] = lambda n: tuple(w[::2, ::2] for w in pair(n, 2 * CELLS, SPACING / 2.0))
    kinds["noise of a tenth of a step"] = lambda n: noisy(n, 0.1)
    kinds["noise of three tenths"] = lambda n: noisy(n, 0.3)
    kinds["32 cells"] = lambda n: pair(n, 32)
    kinds["128 cells"] = lambda n: pair(n, 128)
    kinds["rounded to 1 um"] = lambda n: tuple(np.round(w, 6) for w in pair(n))
    return kinds


def scan_of(wall: np.ndarray) -> Scan:
    return Scan(wall, (SPACING, SPACING), (0.0, 0.0))


def warned(scan: Scan | Cloud) -> list[str]:
    """Return the warnings on one scan, without those of reading it."""
    kept = inspected(scan._replace(remarks=()))
    step = point_distance(kept)
    remarks = cautions(kept.remarks) + quality_remarks(
        quality_of(kept), wall_on_grid(kept, step), step
    )
    return [str(remark) for remark in remarks]


def pair_warned(upper: np.ndarray, lower: np.ndarray) -> list[str]:
    """Return the warnings on different scales of two walls."""
    pair = registered(scan_of(upper), scan_of(lower), orientation="towards", shift="scanned")
    return [line for line in pair.warnings if "calibrate" in line]


def judged(pairs: int, scans: dict[str, Scan | Cloud]) -> pd.DataFrame:
    """Count scans with a warning for each undamaged kind of walls and for each defect."""
    kinds = undamaged()
    rows = []

    def add(kind: str, damaged: bool, warnings_of: list[list[str]]) -> None:
        count = sum(map(bool, warnings_of))
        low, high = scipy.stats.binomtest(count, len(warnings_of)).proportion_ci(method="exact")
        first = next((lines[0] for lines in warnings_of if lines), "")
        row = {"walls": kind, "damaged": damaged, "scans": len(warnings_of), "warned": count}
        rows.append(row | {"share_low": low, "share_high": high, "first_warning": first})

    for kind, make in kinds.items():
        drawn = [make(number) for number in range(pairs)]
        add(kind, False, [warned(scan_of(wall)) for walls in drawn for wall in walls])
        add(f"{kind}, both walls", False, [pair_warned(*walls) for walls in drawn])
    for name, scan in scans.items():
        add(name, False, [warned(scan)])
    for name, defect in DEFECTS.items():
        found = []
        for number in range(pairs):
            random = generator(seed_of(2, "damage", number))
            walls = list(kinds["sampled"](number))
            walls[0] = defect.damage(walls[0], random)
            paired = name.startswith(_OF_PAIRS)
            found.append(pair_warned(*walls) if paired else warned(scan_of(walls[0])))
        add(name, True, found)
    return pd.DataFrame(rows)


def noise_held(pairs: int) -> pd.DataFrame:
    """Count intervals of a scanner's noise that contain the noise that was added to walls.

    Walls have waves to the corners of the square of wave numbers (radius 0), or to a circle.
    """
    rows = []
    for cells, radius, share in product((48, 64, 128), (0.0, 0.8, 0.9, 1.0), (0.1, 0.3, 0.6)):
        held = []
        ratios = []
        clear = []
        for number in range(pairs):
            random = generator(seed_of(4, "noise", number))
            shape = (2 * cells, 2 * cells)
            wall = jc.wall_pair(8.0, shape, SPACING, number, roll_off=None, unusual_values=True)[0]
            wall = (ended(wall, radius) if radius else wall)[:cells, :cells]
            noise = share * _steps(wall)
            scan = scan_of(wall + noise * random.standard_normal(wall.shape))
            low, high = quality_of(scan).noise
            held.append(low <= noise <= high)
            ratios.append(high / noise)
            end = spectrum_end(scan)
            clear.append(end is not None and end.clear)
        interval = scipy.stats.binomtest(sum(held), pairs).proportion_ci(method="exact")
        rows.append({
            "cells": cells, "radius": radius, "noise_in_steps": share, "scans": pairs,
            "warned": sum(clear), "held": sum(held), "held_low": interval.low,
            "held_high": interval.high, "high_end_over_noise": float(np.median(ratios)),
        })  # fmt: skip
    return pd.DataFrame(rows)


def closures(upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Simulate two walls (y, x) [m]; return the net closures (2,) [mm] of both cycles."""
    conditions = Conditions(SPACING, "granite", 10e6, 2, numerics=RESOLVED).checked()
    table = cycle_table(simulate_walls(detrended(upper), detrended(lower), conditions))
    return table[CLOSURE_NET].to_numpy()


def closed(pairs: int, defects: dict[str, Defect]) -> pd.DataFrame:
    """Simulate damaged pairs as they are, and by `close` with their range, beside the true pair."""
    rows = []
    for number in range(pairs):
        walls = undamaged()["sampled"](number)
        true = closures(*walls)
        for name, defect in ({"none": Defect(lambda w, r: w)} | defects).items():
            random = generator(seed_of(2, "damage", number))
            damaged = [
                defect.damage(wall, random) if defect.both or side == 0 else wall
                for side, wall in enumerate(walls)
            ]
            before = closures(*damaged)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                joint = jc.close(
                    scan_of(damaged[0]), scan_of(damaged[1]), rock="granite", workers=1,
                    max_normal_stress=10e6, orientation="towards", shift="scanned",
                )  # fmt: skip
            assert joint.budget is not None
            ranges = joint.budget.ranges.xs(CLOSURE_NET, level="quantity")
            for cycle in (1, 2):
                truth = float(true[cycle - 1])
                row = ranges.loc[cycle]
                rows.append({
                    "defect": name, "number": number, "cycle": cycle, "true_mm": truth,
                    "before": before[cycle - 1] / truth, "best": row.best / truth,
                    "low": row.low / truth, "high": row.high / truth,
                    "inside": row.low <= truth <= row.high,
                    "warnings": len(joint.pair.warnings),
                    "spacing_mm": 1e3 * joint.pair.spacing,
                })  # fmt: skip
            print(pd.DataFrame(rows[-2:]).round(3).to_string(header=len(rows) == 2), flush=True)
    return pd.DataFrame(rows)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate geometric means of closures over the true ones, and ranges that hold these."""
    ratios = ["before", "best", "low", "high"]
    logs = table.assign(**{name: np.log(table[name]) for name in ratios})
    by = logs.groupby(["defect", "cycle"], sort=False)
    result = np.exp(by[ratios].mean())
    result["best_factor"] = np.exp(by["best"].std() / math.sqrt(table.number.nunique()))
    return result.assign(inside=by["inside"].sum(), pairs=by.size()).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--close", action="store_true")
    parser.add_argument("--noise", action="store_true")
    parser.add_argument("--defects", nargs="*", default=list(DEFECTS), choices=list(DEFECTS))
    parser.add_argument("--scans", nargs="*", default=[], help="undamaged scans to be judged")
    parser.add_argument("--units", default=None)
    parser.add_argument("--scan-spacing", type=float, default=None, help="of their grids [m]")
    parser.add_argument("--variable", default=None)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/scan_defects"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    if options.close:
        table = closed(options.pairs, {name: DEFECTS[name] for name in options.defects})
        write_csv(table, options.output / "closures.csv")
        result = summary(table)
        write_csv(result, options.output / "summary.csv")
    elif options.noise:
        result = noise_held(options.pairs)
        write_csv(result, options.output / "noise.csv")
    else:
        stated = {"units": options.units, "variable": options.variable}
        scans = {
            Path(file).name: jc.read_scan(file, scan_spacing=options.scan_spacing, **stated)
            for file in options.scans
        }
        result = judged(options.pairs, scans)
        write_csv(result, options.output / "warnings.csv")
        result["first_warning"] = result.first_warning.str.slice(0, 60)
    write_origin(options.output, f"--pairs {options.pairs}{' --close' if options.close else ''}")
    print(result.round(3).to_string(index=False))


if __name__ == "__main__":
    main()
