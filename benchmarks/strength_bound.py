"""Whether closures and stiffnesses have a limit: with and without a bound of strength, other steps.

Joints of four rocks, 40 x 40 cells of 0.25 mm, every second one with waves of all lengths and the
others with a roll-off of 3 mm, at roughness and stress of `LOADS`; and pairs of scans, files
``*_upper.*`` and ``*_lower.*`` of folders (granite, 10 MPa). The stored run has README's pair and,
of two published scans, a foliation joint on itself turned by 180 degrees and mirrored (63 x 63
cells), and the middle (64 x 64) of a fracture. The paper's steps over 64, and of few
joints over 256, are compared with resolved breakage at a tolerance of 0.01, by the net closure
since seating of both cycles on the same walls. Resolved closures are means of copies of the walls
that must close alike (`jointclosure.uncertainty.variants.COPIES`). With a bound of strength
this, the default of scanned joints, is compared with an eighth of the tolerance, and that
difference with the numerical error that `jointclosure close` states, by twice the tolerance.
Closures that the output has are not computed again. 40 joints take an hour of a core.
"""

import argparse
import itertools
import math
from pathlib import Path

import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.ensembles.simulation import Reading, simulate_row
from jointclosure.joint.conditions import RESOLVED, Conditions
from jointclosure.joint.rocks import ROCKS
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.sources import coarser
from jointclosure.uncertainty.variants import COPIES
from jointclosure.walls.wall_files import registered_walls

NONE, BASE = "none, as in the paper", "strength bounded by the base"
RULES = {NONE: jc.Choices(strength_bound="none"), BASE: jc.Choices(strength_bound="base")}
NAMES = ("dolerite", "siltstone", "limestone", "slate")
LOADS = ((1.0, None), (0.5, 0.12), (1.5, 0.2), (2.0, 0.35), (1.0, 0.06))
"""JRC over that of the rock, and stress over its strength or None for 30 MPa, of two seeds each."""
FEW = 2
"""Number of joints of a rock that are also simulated by the finest steps."""
STEPPED = 5
"""Number of joints of a rock that are also simulated at an eighth of the tolerance."""
SPACING, CLOSURE, STIFFNESS = 0.25e-3, "max_closure_seated_net", "stiffness_net"
MATED = Path("config/walls")
"""Folder of scans that are simulated at their best fit; others are as they were scanned."""
KEYS = ["joint", "rule", "setting", "copy"]


def finer(part: float) -> jc.Numerics:
    """Return the paper's numerics with all steps divided by a number."""
    usual = jc.Numerics()
    steps = [name for name in jc.Numerics._fields if name.endswith("_step")]
    return usual._replace(**{name: getattr(usual, name) / part for name in steps})


SETTINGS = {"resolved": RESOLVED, "steps/64": finer(64.0), "steps/256": finer(256.0)}
EIGHTH, DOUBLED = "resolved, tolerance/8", "resolved, 2 tolerance"
SETTINGS |= {EIGHTH: coarser(RESOLVED, 1.0 / 8.0), DOUBLED: coarser(RESOLVED, 2.0)}


def joint_of(name: str) -> tuple:
    """Return walls (y, x) [m], spacing [m], rock and stress [Pa] of a joint by its name."""
    if "_upper" in name:
        pair = registered_walls(
            name, name.replace("_upper", "_lower"), {}, orientation="common_frame",
            shift="mated" if Path(name).parent == MATED else "scanned", unusual_values=True,
        )  # fmt: skip
        return (pair.upper, pair.lower), pair.spacing, "granite", 10e6
    rock, seed = name.split()
    rougher, share = LOADS[int(seed) // 2]
    roll_off = 3e-3 if int(seed) % 2 else None
    known = ROCKS[rock]
    walls = jc.wall_pair(rougher * known.jrc, (40, 40), SPACING, int(seed), roll_off=roll_off)
    stress = share * known.intact.compressive_strength if share else 30e6
    return walls, SPACING, rock, stress


def closed(name: str, rule: str, setting: str, copy: str) -> dict:
    """Simulate a copy of a joint by a rule and a setting; return its row."""
    walls, spacing, rock, stress = joint_of(name)
    made = {"choices": RULES[rule], "numerics": SETTINGS[setting]}
    conditions = Conditions(spacing, rock, stress, **made).checked()
    pair = tuple(COPIES[copy](wall) for wall in walls)
    row = simulate_row(
        pair, Reading(conditions, (CLOSURE, STIFFNESS, "status", "timing_simulation"))
    )
    cycles = {
        f"{name}_{cycle}": value
        for name, variable in (("closure", CLOSURE), ("stiffness", STIFFNESS))
        for cycle, value in enumerate(row.get(variable, (math.nan,) * 2), 1)
    }
    about = dict(zip(KEYS, (Path(name).name, rule, setting, copy), strict=True))
    return about | cycles | {"status": row["status"], "seconds": row["timing_simulation"]}


def tasks_of(joints: int, scans: list[Path]) -> list[tuple[str, str, str, str]]:
    """Return (joint, rule, setting, copy) of all simulations, joint by joint."""
    names = [f"{rock} {seed}" for seed in range(joints) for rock in NAMES]
    tasks = []
    for name in [*names, *(str(file) for folder in scans for file in folder.glob("*_upper.*"))]:
        few = "_upper" not in name and int(name.split()[1]) < FEW
        for rule, setting in itertools.product(RULES, SETTINGS):
            if setting in (EIGHTH, DOUBLED):
                wanted = rule == BASE and ("_upper" in name or int(name.split()[1]) < STEPPED)
            else:
                wanted = few or setting != "steps/256"
            if wanted:
                every = setting == "resolved" or (setting == EIGHTH and "_upper" in name)
                copies = COPIES if every else list(COPIES)[:1]
                tasks += [(name, rule, setting, copy) for copy in copies]
    return tasks


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate mean differences from resolved breakage, and the median spread of its copies."""
    rows = []
    for kind, rule, cycle in itertools.product(("made", "scanned"), RULES, (1, 2)):
        part = table[(table.rule == rule) & (table.kind == kind)]
        by = part.pivot_table(index="joint", columns=["setting", "copy"], values=f"closure_{cycle}")
        if by.empty:
            continue
        fine = by["resolved"].mean(axis=1)
        spread = by["resolved"].std(axis=1)
        row = {"walls": kind, "bound": rule, "cycle": cycle, "joints": len(by)}
        for setting in [name for name in ("steps/64", "steps/256") if name in by]:
            apart = (by[setting, "as it is"] - fine).dropna()
            row[f"{setting} (%)"] = rounded(*mean_of(100.0 * apart / fine[apart.index]))
            if setting == "steps/64":
                near = np.abs(apart) <= 2.0 * spread[apart.index]
                row["within twice the spread"] = f"{near.sum()} of {len(near)}"
        rows.append(
            row | {"median spread of copies (%)": f"{100.0 * (spread / fine).median():.2g}"}
        )
    return pd.DataFrame(rows)


def steps_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate differences of resolved breakage from an eighth of the tolerance, and times."""
    rows = []
    alike = table[(table["rule"] == BASE) & (table["copy"] == next(iter(COPIES)))]
    read = ["seconds", *alike.filter(like="ness_"), *alike.filter(like="sure_")]
    by = alike.pivot_table(index=["kind", "joint"], columns="setting", values=read)
    seconds = (by["seconds", "resolved"] / by["seconds", EIGHTH]).dropna()
    for name, cycle, kind in itertools.product(
        ("closure", "stiffness"), (1, 2), by.index.unique("kind")
    ):
        values = by.loc[kind][f"{name}_{cycle}"].dropna(subset=EIGHTH)
        apart = 100.0 * (values["resolved"] / values[EIGHTH] - 1.0)
        stated = 100.0 * (values[DOUBLED] / values["resolved"] - 1.0).abs()
        row = {"walls": kind, "quantity": name, "cycle": cycle, "joints": len(apart)}
        row["difference (%)"] = rounded(*mean_of(apart))
        row["root mean square (%)"] = f"{np.sqrt((apart**2).mean()):.2g}"
        row["largest (%)"] = f"{apart[apart.abs().idxmax()]:.2g}"
        row["within the stated error"] = f"{(apart.abs() <= stated).sum()} of {len(apart)}"
        row["within twice of it"] = f"{(apart.abs() <= 2.0 * stated).sum()} of {len(apart)}"
        row["within 3 %"] = f"{(apart.abs() <= 3.0).sum()} of {len(apart)}"
        rows.append(row | {"time, median ratio": f"{seconds.median():.2g}"})
    return pd.DataFrame(rows)


def main() -> None:
    """Close all joints and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=10, help="of each rock, up to 10")
    parser.add_argument("--scans", type=Path, nargs="*", default=[MATED])
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/strength_bound"))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    file = asked.output / "closures.csv"
    rows = pd.read_csv(file).to_dict("records") if file.exists() else []
    known = {tuple(row[key] for key in KEYS) for row in rows}
    for task in tasks_of(asked.joints, asked.scans):
        if (Path(task[0]).name, *task[1:]) not in known:
            rows.append(closed(*task))
            pd.DataFrame(rows).to_csv(file, index=False)
    closures = pd.DataFrame(rows)
    scanned = closures.joint.str.contains("_upper")
    closures["kind"] = np.where(scanned, "scanned", "made")
    for name, of in (("summary", summary), ("steps", steps_summary)):
        table = of(closures)
        table.to_csv(asked.output / f"{name}.csv", index=False)
        print(table.to_string(index=False))
    write_origin(asked.output)


if __name__ == "__main__":
    main()
