"""Reads the later loadings, contact maps and scans of three granodiorite joints from clones of
the repositories danielvogler/hm_coupled_fracture_response and
danielvogler/contact_stress_evaluation, closes the scanned walls, and prints measured values
beside those of the model (docs/measured.md).
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.cli import options, results
from jointclosure.engine.measured_joints import JOINTS, measured
from jointclosure.engine.scanned_joint import close
from jointclosure.inputs import InputError
from jointclosure.joint.curves import cycle_table, net_responses
from jointclosure.joint.rocks import named_rock
from studies.measured_joints.published import film, later_loading, scans

SPACING = 0.25e-3
"""Grid spacing [m], that of the synthetic walls of docs/measured.md."""


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, help="folder that contains both clones")
    options.add_keywords(command, close, "units")
    options.add_file(command, "--output", "CSV file for the table", ".csv")


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
        model = _modelled(pair, options.given(arguments, ["units"])) if pair else {}
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
        results.write(table, arguments.output)
    return 0


def _modelled(walls: tuple[Path, Path], units: dict[str, Any]) -> dict[str, float]:
    """Close scanned walls as the measured joints were loaded, and read the same quantities."""
    stress = 1e6 * measured("largest_stress").value
    history = close(
        *walls,
        **units,
        spacing=SPACING,
        rock=named_rock("granite")._replace(youngs_modulus=1e9 * measured("youngs_modulus").value),
        max_normal_stress=stress,
        cycles=2,
        seating_stress=1e6 * measured("seating_stress").value,
        single=True,
    ).history
    if results.failed(history):
        status = results.status_text(history)
        raise InputError(f"{walls[0]}: the joint could not be closed: {status}")
    net = net_responses(history)
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
