"""Selected effects at random conditions, judged on surfaces that the selection did not see.

Rock (E 5 to 80 GPa, strength 20 to 250 MPa), JRC 2 to 20, stress (0.001 to 0.5 of the strength),
size and roll-off are random; a third of the walls are mated beyond 1 to 10 mm. Effects are selected
for 20, 180 and 540 joints, by up to 20 pairs of walls, and judged on other surfaces, closed in
every scene that may be selected, and on more where these do not show whether interaction matters. A
change is true where it exceeds two standard errors, and beyond a tolerance where it exceeds this by
as much. True changes have an effectivity, the limit that the selection states over the change. The
best scene is the fastest that is not beyond the tolerance.

`python benchmarks/effects_auto.py` goes on with the scenes that its folder has. `--seed 1` has the
conditions of which the scatter about frozen walls (`PRIORS`) was estimated, which it prints.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import minimize

import jointclosure as jc
from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.assessment.effect_selection import (
    LONGER,
    MOST_PAIRS,
    Pilot,
    choose_among,
    possible_scenes,
)
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import scene_name
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.walls import Walls

SPACING, TOLERANCES, JOINTS = 0.25e-3, (0.05, 0.2), (20, 180, 540)
ALL, FEWER = jc.Effects(), jc.Effects(interaction=False)
MATED = 1.0 / 3.0
"""Share of conditions whose walls mate beyond a wavelength."""
BEYOND = 2.0
"""Number of standard errors beyond which a change is true."""
MOST = 100
"""Largest number of surfaces that are simulated to decide whether interaction matters."""
UNLIMITED = 1e9
"""Breakage steps over those with all effects, beyond which a joint is given up: no joint is."""
CLOSURES = [list(ASSESSED).index(name) for name in JUDGED]


def scene(seed: int, number: int, cells: tuple[int, int]) -> tuple[CheckedConditions, dict]:
    """Draw the conditions of a scene, and the arguments of `wall_pair`; ``cells`` are bounds."""
    random = generator(seed_of(seed, "conditions", number))
    modulus, strength = (
        np.exp(random.uniform(*np.log(ends))) for ends in ((5e9, 80e9), (20e6, 250e6))
    )
    rock = jc.Rock(float(modulus), float(random.uniform(0.1, 0.4)), float(strength))
    jrc = random.uniform(2.0, 20.0)
    share = np.exp(random.uniform(*np.log((1e-3, 0.5))))
    size = round(random.uniform(*cells))
    roll_off = None if random.uniform() < 0.5 else 3e-3
    walls = {"jrc": float(jrc), "shape": (size, size), "roll_off": roll_off}
    if random.uniform() < MATED:
        walls["mismatch_wavelength"] = float(np.exp(random.uniform(*np.log((1e-3, 1e-2)))))
    return Conditions(SPACING, rock, float(share * strength)).checked(), walls


class Surfaces(Pilot):
    """Pilot on new surfaces of a scene; copies of it share the joints that were simulated."""

    def __init__(self, asked, number: int, kind: str, count: int):
        conditions, walls = scene(asked.seed, number, asked.cells)
        seeds = (seed_of(asked.seed, kind, number, surface) for surface in range(count))
        pairs = [jc.wall_pair(spacing=SPACING, seed=each, **walls) for each in seeds]
        super().__init__(pairs, conditions, 20)
        self.known: dict[tuple, SimulatedJoint] = {}

    def for_joints(self, joints: int) -> "Surfaces":
        """Return a copy of the pilot for a number of joints, without its selected results."""
        pilot = copy.copy(self)
        pilot.joints = joints
        pilot.closed = {}
        pilot.frozen_seconds = 0.0
        return pilot

    def close(self, walls: Walls, effects: jc.Effects, **changes: Any) -> SimulatedJoint:
        """Close a pair of walls, or return the joint that a former pilot simulated."""
        key = walls[0].tobytes(), effects, *changes.items()
        if key not in self.known:
            self.known[key] = super().close(walls, effects, **changes)
        return self.known[key]


def true_change(
    truth: Surfaces, effects: jc.Effects, surfaces: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean change (quantity, cycle) with some effects, and its standard error.

    For all effects except interaction, surfaces are added until the change is decided against all
    tolerances. A scene whose first joint is given up cannot be selected: its change is infinite.
    """
    for count in (1, *range(surfaces, MOST + 1, surfaces)):
        truth.longer = LONGER if count == 1 else UNLIMITED
        changes = truth.changes(effects, count)
        if effects != ALL and np.isnan(changes[:, CLOSURES]).any():
            return np.full(changes.shape[1:], np.inf), np.zeros(changes.shape[1:])
        if count == 1:
            continue
        mean = np.nanmean(changes, axis=0)
        known = np.isfinite(changes).sum(axis=0)
        error = np.nanstd(changes, axis=0, ddof=1) / known**0.5
        low, high = (np.abs(mean) + sign * BEYOND * error for sign in (-1.0, 1.0))
        low, high = (np.nan_to_num(end, nan=0.0)[CLOSURES].max() for end in (low, high))
        if effects != FEWER or all(not low <= tolerance < high for tolerance in TOLERANCES):
            break
    return mean, error


def judged(number: int, asked: argparse.Namespace) -> tuple[list[dict], list[dict]]:
    """Return rows of the selections at a scene, and of frozen walls beside the true change."""
    truth = Surfaces(asked, number, "walls", MOST)
    pilots = Surfaces(asked, number, "pilot", MOST_PAIRS)
    scenes = possible_scenes(ALL)
    found = {effects: true_change(truth, effects, asked.surfaces) for effects in scenes}
    mean, error = ({effects: of[place] for effects, of in found.items()} for place in (0, 1))
    times = {effects: truth.seconds(effects) / truth.seconds(ALL) for effects in scenes}
    rows = []
    stress = truth.conditions.largest_stress
    strength = truth.conditions.rock[0][2]
    about = {"scene": number, "stress_over_strength": stress / strength}
    least = {effects: np.abs(of) - BEYOND * error[effects] for effects, of in mean.items()}
    beyond = {effects: np.nan_to_num(of, nan=0.0)[CLOSURES].max() for effects, of in least.items()}
    for joints in JOINTS:
        for tolerance in TOLERANCES:
            pilot = pilots.for_joints(joints)
            choice = choose_among(pilot, tolerance)
            chosen = choice.effects
            true = np.abs(mean[choice.effects])
            significant = true > BEYOND * error[chosen]
            best = min(time for effects, time in times.items() if beyond[effects] <= tolerance)
            # the lost time is relative to that of joints of the same pilot
            lost = choice.lost_seconds / pilot.seconds(ALL) / joints
            row = {"joints": joints, "tolerance": tolerance, "chosen": scene_name(chosen)}
            row |= {"true": true[CLOSURES].max(), "least": beyond[chosen], "stated": choice.error}
            row |= {"lost": lost, "saved": 1.0 - times[chosen] - lost, "best_saved": 1.0 - best}
            for place, name in enumerate(ASSESSED):
                limits = choice.changes.at_most.to_numpy().reshape(true.shape)[place]
                worst = np.argmax(np.where(significant[place], true[place], 0.0))
                ratio = limits[worst] / true[place, worst] if significant[place].any() else np.nan
                row[f"effectivity_{name}"] = ratio if chosen != ALL else np.nan
            rows.append(about | row)
    pilot = pilots.for_joints(1)
    pilot.values(ALL, 1)
    frozen = pilot.predicted(FEWER).mean
    columns = {"frozen": frozen, "change": mean[FEWER], "error": error[FEWER]}
    about |= {"broken": pilot.broken(), "largest": np.nanmax(np.abs(frozen[CLOSURES]))}
    places = np.ndindex(frozen.shape)
    return rows, [
        about
        | {"quantity": list(ASSESSED)[at[0]], "cycle": at[1] + 1}
        | {name: values[at] for name, values in columns.items()}
        for at in places
    ]


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Summarise judged selections by tolerance and number of joints."""
    rows = []
    for (tolerance, joints), part in table.groupby(["tolerance", "joints"]):
        changed = part[part.chosen != scene_name(ALL)]
        outside = changed[changed.least > tolerance]
        kept = np.where(part.index.isin(outside.index), -part.lost, part.saved)
        row = {
            "tolerance": tolerance,
            "joints": joints,
            "scenes": len(part),
            "left_out": len(changed),
            "share_of_saving_percent": 100.0 * kept.sum() / part.best_saved.sum(),
            "outside": len(outside),
            "largest_true_percent": 100.0 * outside.true.max() if len(outside) else 0.0,
            "largest_lost_percent": -100.0 * part.saved.min(),
        }
        for name in ASSESSED:
            ratios = changed[f"effectivity_{name}"].dropna()
            row[f"effectivity_{name}"] = ratios.median()
            row[f"good_{name}"] = int(ratios.between(1.0, 5.0).sum())
            row[f"of_{name}"] = len(ratios)
        rows.append(row)
    return pd.DataFrame(rows)


def scatter(table: pd.DataFrame) -> pd.DataFrame:
    """Estimate the likeliest scatter of true changes about those of frozen walls, as `PRIORS`."""
    rows = []
    for quantity, part in table.dropna().groupby("quantity"):
        part = part[part.error > 0.0]
        apart = part.change - part.frozen

        def surprise(logs, part=part, apart=apart):
            least, share, rare = np.exp(logs)
            variance = least**2 + (share * part.largest) ** 2 + rare**2 / part.broken.clip(1)
            variance = variance + part.error**2
            return 0.5 * float((np.log(variance) + apart**2 / variance).sum())

        starts = [(-4.0, -1.5, rare) for rare in (-6.0, -3.0)]
        fits = [minimize(surprise, start, method="Nelder-Mead") for start in starts]
        likeliest = np.exp(min(fits, key=lambda fit: fit.fun).x)
        rows.append((quantity, len(part), *likeliest.round(4)))
    return pd.DataFrame(rows, columns=["quantity", "n", "least", "share", "rare"])


def options(about: str, name: str, scenes: int) -> argparse.Namespace:
    """Read the options of a benchmark at random conditions from the command line."""
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=scenes)
    parser.add_argument("--surfaces", type=int, default=20)
    parser.add_argument("--cells", type=int, nargs=2, default=(48, 64))
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results") / name)
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    return asked


def continued(asked: argparse.Namespace, judged: Callable, names: list[str]) -> list[pd.DataFrame]:
    """Judge the conditions that are missing in the tables of the output; return and write these.

    ``judged`` returns rows for each of the tables ``names``, from a number of a condition and the
    options.
    """
    files = [asked.output / f"{name}.csv" for name in names]
    tables = [read_csv(file) if file.exists() else pd.DataFrame({"scene": []}) for file in files]
    for number in range(asked.scenes):
        if number not in set(tables[-1].scene):
            for place, (file, rows) in enumerate(zip(files, judged(number, asked), strict=True)):
                tables[place] = pd.concat([tables[place], pd.DataFrame(rows)], ignore_index=True)
                write_csv(tables[place], file)
            print(f"scene {number + 1} of {asked.scenes}", flush=True)
    return tables


def write_summary(table: pd.DataFrame, asked: argparse.Namespace) -> None:
    """Write a summary and its origin, and print it."""
    write_csv(table, asked.output / "summary.csv")
    cells = "{} {}".format(*asked.cells)
    note = (
        f"--scenes {asked.scenes} --surfaces {asked.surfaces} --cells {cells} --seed {asked.seed}"
    )
    write_origin(asked.output, note)
    print(table.round(3).T.to_string())


def main() -> None:
    """Judge the scenes that are missing, and write the tables."""
    asked = options(__doc__, "effects_auto", 60)
    selections, frozen = continued(asked, judged, ["selections", "frozen_walls"])
    write_summary(summary(selections), asked)
    print(scatter(frozen).to_string())


if __name__ == "__main__":
    main()
