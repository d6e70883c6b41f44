"""`jointclosure validate`: the model beside the published files of measured joints."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.cli import COMMANDS
from jointclosure.cli.options import add_keywords, keywords
from jointclosure.engine.measured_joints import JOINTS, measured
from jointclosure.engine.scanned_joint import close
from jointclosure.inputs import InputError
from jointclosure.joint.curves import cycle_table, net_responses
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.rocks import named_rock
from jointclosure.measured.published import film, later_loading, scans
from jointclosure.storage.text import write_csv

SPACING = 0.25e-3
"""Grid spacing [m], that of the synthetic walls of docs/measured.md."""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "validate",
        help=COMMANDS["validate"],
        description="Reads the later loadings, contact maps and scans of three granodiorite "
        "joints from clones of the repositories danielvogler/hm_coupled_fracture_response and "
        "danielvogler/contact_stress_evaluation, closes the scanned walls, and prints measured "
        "values beside those of the model (docs/measured.md).",
    )
    command.add_argument("folder", type=Path, help="folder that contains both clones")
    add_keywords(command, close, "units")
    command.add_argument("--output", type=Path, help="CSV file for the table")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print measured values beside those of the model."""
    folder = arguments.folder
    if not folder.is_dir():
        raise InputError(f"{folder}: must be a folder that contains both clones")
    walls = {joint: scans(folder, joint) for joint in JOINTS}
    rows, reasons = [], []
    for joint, pair in walls.items():
        read, missing = later_loading(folder, joint)
        reasons += missing
        read |= film(folder, joint)
        model = {} if pair is None else _modelled(pair, keywords(arguments, ["units"]))
        for name in dict.fromkeys([*read, *model]):
            stored = np.nan if name == "recovered_load" else measured(name, joint).value
            values = {"files": read.get(name, np.nan), "stored": stored}
            row = {"joint": joint, "quantity": name, **values, "model": model.get(name, np.nan)}
            rows.append(row)
    table = pd.DataFrame(rows)
    print(table.round(3).to_string(index=False, na_rep="–"))
    print("".join(f"{reason}\n" for reason in reasons), end="")
    if None in walls.values():
        print("No scans (*.stl) below the folder: the model was not run.")
    if arguments.output:
        write_csv(table, arguments.output)
    return 0


def _modelled(walls: tuple[Path, Path], units: dict[str, Any]) -> dict[str, float]:
    """Close scanned walls as the measured joints were loaded, and read the same quantities."""
    stress = 1e6 * measured("largest_stress").value
    rock = named_rock("granite")._replace(youngs_modulus=1e9 * measured("youngs_modulus").value)
    joint = close(
        *walls,
        **units,
        spacing=SPACING,
        rock=rock,
        max_normal_stress=stress,
        cycles=2,
        seating_stress=1e6 * measured("seating_stress").value,
        single=True,
    )
    history = joint.history
    if int(history.status) >= FAILURE:
        raise InputError(f"{walls[0]}: the joint could not be closed: status {int(history.status)}")
    net = net_responses(history, stress)
    closure, residual = net["max_closure_seated_net"], net["residual_closure_seated_net"]
    stiffness = 1e-9 * net["stiffness_net"]
    return {
        "first_closure": 1e3 * closure[0],
        "first_residual_share": 100.0 * residual[0] / closure[0],
        "later_closure": 1e3 * closure[1],
        "later_stiffness": stiffness[1],
        "stiffness_ratio": stiffness[1] / stiffness[0],
        "later_residual_share": 100.0 * residual[1] / closure[1],
        "contact_share": 100.0 * float(cycle_table(history).contact_at_max.iloc[-1]),
    }
