"""Whether the first cycle has a limit: with and without a bound of strength, or a largest radius.

Joints of four rocks, 40 x 40 cells of 0.25 mm, every second one with waves of all lengths and the
others with a roll-off of 3 mm, closed to 30 MPa. The paper's steps over 64 and over 256 are
compared with resolved breakage at a tolerance of 0.002, by the net closure since 0.5 MPa of both
cycles on the same walls. Each resolved closure is the mean of three copies (as it is, last digits
changed, transposed), whose scatter is printed too. `python benchmarks/strength_bound.py` takes 40
core-minutes for 20 joints; --joints says how many a rock.
"""

import argparse
import itertools
import json
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pandas as pd

import jointclosure as jc
from jointclosure.engine.assess import resolved
from jointclosure.engine.joints import Reading, close_joint
from jointclosure.engine.walls import COPIES
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.rocks import ROCKS
from jointclosure.joint.warmup import compile_kernels
from jointclosure.statistics.standard_errors import mean_of, rounded
from jointclosure.storage.provenance import origin
from jointclosure.storage.text import write_text

RULES = {
    "none, as in the paper": jc.Choices(),
    "strength bounded by the base": jc.Choices(strength_bound="base"),
    "largest radius 20 mm": jc.Choices(largest_radius=20e-3),
}
SPACING, CLOSURE = 0.25e-3, "max_closure_seated_net"
NAMES = ("dolerite", "siltstone", "limestone", "slate")
COPIED = ("as it is", "last digits", "transposed")


def finer(part: float) -> jc.Numerics:
    """The paper's numerics with all steps over a number."""
    usual = jc.Numerics()
    steps = [name for name in jc.Numerics._fields if name.endswith("_step")]
    return usual._replace(**{name: getattr(usual, name) / part for name in steps})


SETTINGS = {"steps/64": finer(64.0), "steps/256": finer(256.0), "resolved": resolved(0.002)}


def closed(rock: str, seed: int, rule: str, setting: str, copy: str) -> dict:
    """Close a joint and return its row."""
    known = ROCKS[rock]
    roll_off = 3e-3 if seed % 2 else None
    walls = jc.wall_pair(known.jrc, (40, 40), SPACING, seed, roll_off=roll_off)
    conditions = Conditions(
        SPACING, rock, 30e6, choices=RULES[rule], numerics=SETTINGS[setting]
    ).checked()
    pair = tuple(COPIES[copy](wall) for wall in walls)
    row = close_joint(pair, Reading(conditions, (CLOSURE, "status", "timing_simulation")))
    about = {"rock": rock, "seed": seed, "rule": rule, "setting": setting, "copy": copy}
    cycles = {f"closure_{c}": value for c, value in enumerate(row.get(CLOSURE, ()), 1)}
    return about | cycles | {"status": row["status"], "seconds": row["timing_simulation"]}


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Means over joints of differences from resolved breakage, and of the scatter of its copies."""
    rows = []
    for rule, cycle in itertools.product(RULES, (1, 2)):
        part = table[table.rule == rule]
        by = part.pivot_table(
            index=["rock", "seed"], columns=["setting", "copy"], values=f"closure_{cycle}"
        ).dropna()
        fine = by["resolved"].mean(axis=1)
        row = {"rule": rule, "cycle": cycle, "joints": len(by)}
        for setting in ("steps/64", "steps/256"):
            apart = mean_of(100.0 * (by[setting, "as it is"] / fine - 1.0))
            row[f"{setting} from resolved (%)"] = rounded(*apart)
        scatter = 100.0 * by["resolved"].std(axis=1) / fine
        rows.append(row | {"scatter of copies (%)": rounded(*mean_of(scatter))})
    return pd.DataFrame(rows)


def main() -> None:
    """Close all joints and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=5)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/strength_bound"))
    asked = parser.parse_args()
    for breakage in ("fixed_step", "resolved"):
        for choices in RULES.values():
            compile_kernels(jc.Effects(), choices, "fast", breakage)
    tasks = [
        (rock, seed, rule, setting, copy)
        for rock, seed, rule in itertools.product(NAMES, range(asked.joints), RULES)
        for setting in SETTINGS
        for copy in (COPIED if setting == "resolved" else COPIED[:1])
    ]
    with ProcessPoolExecutor() as processes:
        table = pd.DataFrame(processes.map(closed, *zip(*tasks, strict=True)))
    asked.output.mkdir(parents=True, exist_ok=True)
    table.to_csv(asked.output / "closures.csv", index=False)
    summary(table).to_csv(asked.output / "summary.csv", index=False)
    made = origin()
    about = {"run": "strength_bound", "commit": made.pop("provenance_commit")} | made
    write_text(json.dumps(about, indent=1) + "\n", asked.output / "origin.json")
    print(summary(table).to_string(index=False))


if __name__ == "__main__":
    main()
