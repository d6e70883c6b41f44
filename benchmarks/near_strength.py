"""Time and status of joints whose largest stress is near the strength of the rock.

A joint of --cells along each side of each of four rocks, with waves of all lengths, is simulated
in two cycles with the numerics of `jointclosure close` to several --shares of the compressive
strength of its rock. Breakage steps are bounded by the default of `most_breakage_steps`. All cells
together carry a little less than the strength, with the bound of their strength: higher stresses
are refused. Times are processor times over that of the smallest share. --output is a folder.
"""

import math
from pathlib import Path

import yardstick

# isort: split
import numpy as np
import pandas as pd
from strength_bound import NAMES, SPACING

import jointclosure as jc
from jointclosure.inputs import InputError
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.rocks import ROCKS
from jointclosure.joint.simulation import Simulation
from jointclosure.joint.status import FLAGS
from jointclosure.parameters import RESOLVED
from jointclosure.storage.provenance import write_origin

SEED = 9300
REFUSED = "refused"


def closed(walls: tuple, conditions: CheckedConditions) -> dict:
    """Simulate a joint; return its processor time [s], effort, largest stress [Pa] and status."""
    try:
        seconds, joint = yardstick.timed(lambda: jc.simulate(*walls, conditions=conditions))
    except InputError:
        return {"seconds": math.nan, "breakage_steps": 0, "reached": 0.0, "status": REFUSED}
    flags = [name for bit, name in FLAGS.items() if int(joint.status) & bit]
    return {
        "seconds": seconds,
        "breakage_steps": int(joint.breakage_steps),
        "reached": float(joint.normal_stress.max()),
        "status": " ".join(flags) or "success",
    }


def rows_of(rock: str, cells: int, shares: list[float]) -> list[dict]:
    """Return the rows of the joint of a rock, one for each share of its strength."""
    known = ROCKS[rock]
    strength = known.intact.compressive_strength
    seed = SEED + NAMES.index(rock)
    walls = jc.wall_pair(known.jrc, (cells, cells), SPACING, seed, roll_off=None)
    rows = []
    for share in sorted(shares):
        conditions = Conditions(
            SPACING, rock, share * strength, numerics=RESOLVED, unusual_values=True
        ).checked()
        row = closed(walls, conditions)
        rows.append({
            "rock": rock,
            "strength_MPa": 1e-6 * strength,
            "share": share,
            "share_of_all_cells": Simulation(*walls, conditions).share_of_strength,
            "status": row["status"],
            "reached_share": row["reached"] / strength,
            "breakage_steps_per_cell": row["breakage_steps"] / cells**2,
            "seconds": row["seconds"],
            "time_ratio": row["seconds"] / rows[0]["seconds"] if rows else 1.0,
        })  # fmt: skip
        print(rows[-1], flush=True)
    return rows


def main(shares: list[float], cells: int, output: Path | None) -> None:
    """Print machine and table, and write them."""
    print(yardstick.machine(), flush=True)
    rows_of(NAMES[0], 8, shares[:1])  # to compile
    table = pd.DataFrame([row for rock in NAMES for row in rows_of(rock, cells, shares)])
    table["cells"] = np.int64(cells**2)
    yardstick.show("time and status near the strength", table, output, "near_strength")
    if output:
        write_origin(output)


if __name__ == "__main__":
    given = {"shares": [0.2, 0.5, 0.7, 0.8, 0.9], "cells": 24}
    asked = yardstick.options(__doc__, **given, output=Path)
    main(asked.shares, asked.cells, asked.output)
