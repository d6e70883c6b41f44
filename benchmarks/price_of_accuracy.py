"""What accuracy costs: errors of net closure and stiffness, and processor time, by tolerance.

Joints of four rocks, made from a JRC, two load cycles: `JOINTS` for each rock, of independent walls
and of walls that are mated beyond 3 mm; and pairs of scans, files ``*_upper.*`` and ``*_lower.*``
of the folders --scans (granite, 10 MPa). The stored run has README's pair and, of two published
scans, a foliation joint on itself turned by 180 degrees and mirrored (63 x 63 cells), and the
middle (64 x 64) of a fracture, as `scan_pairs.py` writes them. Strength is bounded, as that of
scanned joints is.

Each joint is closed by the paper's steps and by resolved breakage at several --tolerances, and once
at the --finest tolerance, from which errors are taken: its errors are in them. Times are processor
times over those of the paper's steps on the same joints, all in one process, so that other work on
the machine matters little. --output is a folder.

Another checkout of the project, with this script in its benchmarks/, is compared by --reference:
the joints.csv of this one. Errors are then taken from its finest tolerance, and times are stated
over those of its paper's steps.
"""

from collections.abc import Iterator
from pathlib import Path

import yardstick

# isort: split
import numpy as np
import pandas as pd
from strength_bound import MATED, NAMES, SPACING, joint_of

import jointclosure as jc
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.rocks import ROCKS
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.storage.provenance import write_origin

JOINTS = ((48, 7e6, None), (56, 15e6, None), (64, 30e6, None), (56, 10e6, 3e-3), (100, 20e6, None))
"""Cells along a side, largest stress [Pa], and wavelength [m] beyond which the walls are mated."""
FIRST_SEED = 9100
RESPONSES = {"closure": "max_closure_seated_net", "stiffness": "stiffness_net"}
NAMES_OF_RESPONSES = [f"{title} {cycle}" for title in RESPONSES for cycle in (1, 2)]
PAPER = "paper's steps"


def joints(scans: list[Path]) -> Iterator[tuple[str, tuple]]:
    """Generate names of joints, and their walls (y, x) [m], spacing [m], rock and stress [Pa]."""
    for at, rock in enumerate(NAMES):
        for number, (cells, stress, mated) in enumerate(JOINTS):
            seed = FIRST_SEED + 10 * at + number
            shape = (cells, cells)
            walls = jc.wall_pair(ROCKS[rock].jrc, shape, SPACING, seed, mismatch_wavelength=mated)
            yield f"{rock} {number}", (walls, SPACING, rock, stress)
    for file in sorted(file for folder in scans for file in folder.glob("*_upper.*")):
        yield f"scan {file.stem.removesuffix('_upper')}", joint_of(str(file))


def closed(name: str, given: tuple, numerics: jc.Numerics) -> dict:
    """Simulate a joint; return its net closures [m], stiffnesses [Pa/m] and processor time [s]."""
    walls, spacing, rock, stress = given
    seconds, joint = yardstick.timed(
        lambda: jc.simulate(
            *walls, spacing=spacing, rock=rock, max_normal_stress=stress, cycles=2,
            numerics=numerics,
        )
    )  # fmt: skip
    responses = net_responses(joint)
    row = {"joint": name, "seconds": seconds, "status": int(joint.status)}
    row["equilibria"] = int(joint.equilibria)
    for title, response in RESPONSES.items():
        for cycle in (1, 2):
            row[f"{title} {cycle}"] = responses[response][cycle - 1]
    return row


def summarised(table: pd.DataFrame, finest: pd.DataFrame, paper: pd.DataFrame) -> pd.DataFrame:
    """Tabulate errors [%] of means, with standard errors, and of single joints by setting.

    Errors are differences from the joints of the ``finest`` setting, and times are relative to
    those of the ``paper``'s steps.
    """
    of_joint = table.set_index(["setting", "joint"])
    reference = finest.set_index("joint")
    paper = paper.set_index("joint")
    rows = []
    for setting in table.setting.unique():
        joints = of_joint.loc[setting]
        row = {"setting": setting, "joints": len(joints), "seconds": joints.seconds.sum()}
        row["time over the paper's"] = joints.seconds.sum() / paper.seconds.sum()
        row["equilibria of a joint"] = joints.equilibria.mean()
        for name in NAMES_OF_RESPONSES:
            errors = 100.0 * (joints[name] / reference[name] - 1.0).to_numpy()
            mean, error = mean_of(errors)
            row |= {f"{name} mean %": mean, f"{name} standard error %": error}
            row[f"{name} rms %"] = float(np.sqrt(np.mean(errors**2)))
        rows.append(row)
    return pd.DataFrame(rows)


def main(
    tolerances: list[float],
    finest: float,
    scans: list[Path],
    output: Path | None,
    reference: Path | None,
) -> None:
    """Print machine and table, and write them."""
    print(yardstick.machine(), flush=True)
    settings = {PAPER: jc.Numerics()}
    for tolerance in sorted({*tolerances, *([] if reference else [finest])}, reverse=True):
        numerics = jc.Numerics(breakage="resolved", tolerance=tolerance)
        settings[f"tolerance {tolerance:g}"] = numerics
    for numerics in (jc.Numerics(), jc.Numerics(breakage="resolved", tolerance=0.05)):
        closed(*next(joints([])), numerics)  # to compile
    rows = [
        {"setting": setting} | closed(name, given, numerics)
        for setting, numerics in settings.items()
        for name, given in joints(scans)
    ]
    table = pd.DataFrame(rows)
    known = pd.read_csv(reference) if reference else table
    by_setting = dict(tuple(known.groupby("setting")))
    summary = summarised(table, by_setting[f"tolerance {finest:g}"], by_setting[PAPER])
    yardstick.show("errors from the finest tolerance, and times", summary, output, "price")
    if output:
        table.to_csv(output / "joints.csv", index=False)
        write_origin(output)


if __name__ == "__main__":
    given = {"tolerances": [0.04, 0.02, 0.01, 0.005], "finest": 0.00125, "scans": [MATED]}
    asked = yardstick.options(__doc__, **given, output=Path, reference=Path)
    main(asked.tolerances, asked.finest, asked.scans, asked.output, asked.reference)
