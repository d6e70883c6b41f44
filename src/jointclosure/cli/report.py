"""`jointclosure report`: page on a joint, from the folder of `jointclosure close`."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli import COMMANDS
from jointclosure.engine.budget import NOT_MODELLED, QUANTITIES
from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.joint.curves import KINDS, cycle_table, net_responses
from jointclosure.joint.laws import LAWS, fitted_laws, law_words
from jointclosure.joint.stiffness import stiffness_table
from jointclosure.storage.folders import add_file
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_text, write_text

with needs("report", "a page"):
    from jointclosure.cli.page import (
        Caption,
        Picture,
        Sheet,
        headings,
        number_text,
        provenance_rows,
        render,
        sheet,
    )

_PICTURES = {
    "engineering": ("Net closure, net stiffness and aperture", "Net closure since seating with "
                    "fitted laws, net normal stiffness and mean aperture against normal stress."),
    "range": ("Range of the net closure, and what it is due to", "Net closure of the first and the "
              "last cycle for each value of each source of uncertainty, and all together."),
    "closure": ("Gross and net closure since seating", "Normal stress "
                "against closure: loading in full lines, unloading dashed, a colour for each "
                "cycle."),
    "walls": ("Walls before closure", "Maps of both walls and of the aperture at first "
              "touch, a section there, correlation by wavelength and by orientation."),
    "snapshots": ("The joint under stress", "Maps of aperture, stress of contacts and change of "
                  "the walls' height at the requested stresses."),
}  # fmt: skip
"""Figures in a joint's folder: their titles, and text alternatives for screen readers."""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "report",
        help=COMMANDS["report"],
        description="Writes report.html from the folder of a joint that `jointclosure close` "
        "wrote. It may be from another machine; nothing is computed again.",
    )
    command.add_argument("folder", type=Path, help="folder that `jointclosure close` wrote")
    command.add_argument(
        "--output", type=Path, help="file of the page (default: report.html in the folder)"
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Write the page."""
    folder, output = arguments.folder, arguments.output or arguments.folder / "report.html"
    if not (folder / "joint.json").is_file():
        raise InputError(f"{folder}: must be a folder that `jointclosure close` wrote")
    record = json.loads(read_text(folder / "joint.json"))
    pictures = [
        Picture(name, (folder / f"{name}.png").read_bytes(), Caption(title, alternative, []))
        for name, (title, alternative) in _PICTURES.items()
        if (folder / f"{name}.png").is_file()
    ]
    with reading_netcdf(folder / "joint.nc") as history:
        page = render(joint_content(history.load(), record, pictures), "joint.html.j2")
    write_text(page, output)
    if output.parent == folder:  # the page belongs to the folder of the joint
        add_file(folder, "close", output.name)
    print(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")
    return 0


def joint_content(history: xr.Dataset, record: dict, pictures: list[Picture]) -> dict:
    """Return names and values for the template ``joint.html.j2``.

    ``history`` is that of `simulate`, ``record`` the contents of joint.json.
    """
    cycles, stiffness = cycle_table(history), stiffness_table(history)
    return {
        "title": record.get("title", "a rough joint"),
        "joint": record["joint"].strip("<>").removeprefix("ClosedJoint: "),
        "finding": joint_finding(cycles, history, record.get("range", [])),
        "warnings": record.get("warnings", []),
        "about_range": record.get("about_range", []),
        "found": record["found"],
        "status": record["status"],
        "sheets": {
            sheet.name: sheet
            for sheet in [
                *_sheets(cycles, stiffness, history),
                *_range_sheets(record.get("range", [])),
            ]
        },
        "pictures": pictures,
        "digests": record["sha256"],
        "provenance": provenance_rows(history.attrs),
    }


def joint_finding(cycles: pd.DataFrame, history: xr.Dataset, ranges: list[dict]) -> str:
    """Describe closure, residual closure and stiffness of the joint, with ranges if known."""
    texts = {(entry["cycle"], entry["quantity"]): entry["text"] for entry in ranges}
    largest = float(history.normal_stress.max())
    stiffness = 1e-9 * net_responses(history, largest)["stiffness_net"]
    known = cycles.assign(stiffness_net_MPa_per_mm=stiffness[cycles.cycle - 1]).set_index("cycle")

    def text(name: str, cycle: int = 1) -> str:
        return texts.get((cycle, name), number_text(known.loc[cycle, name], 3))

    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    words = (
        f"From {seating:g} MPa on the joint closes {text('max_closure_seated_net_mm')} mm in "
        "its first cycle"
    )
    stays = text("residual_closure_seated_net_mm")
    if np.isfinite(known.residual_closure_seated_net_mm[1]) and stays != NOT_MODELLED:
        words += f", of which {stays} mm stay"
    stiff = [
        f"{text('stiffness_net_MPa_per_mm', cycle)} MPa/mm in cycle {cycle}"
        for cycle in sorted({1, known.index[-1]})
        if np.isfinite(known.stiffness_net_MPa_per_mm[cycle])
    ]
    if stiff:
        words += (
            f"; its normal stiffness, the chord of loading above {0.5e-6 * largest:.3g} MPa, "
            f"is {' and '.join(stiff)}"
        )
    return (
        f"{words}. These are net; with the elastic indentation of the half-spaces, which is no "
        f"property of the joint, the first cycle closes {text('max_closure_seated_mm')} "
        "mm (gross)."
    )


def _by_stress(stiffness: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Arrange stiffness, net or gross, by stress (rows) and branch (columns)."""
    branch = "Cycle " + stiffness.cycle.astype(str) + ", " + stiffness.branch
    known = stiffness[f"normal_stiffness_{kind}_MPa_per_mm"].where(~stiffness.landing)
    columns = {name: known[branch == name].to_numpy() for name in branch.unique()}
    return pd.DataFrame({"Normal stress (MPa)": stiffness.normal_stress_MPa.unique()} | columns)


def _stiffness_sheet(stiffness: pd.DataFrame, kind: str) -> Sheet:
    by_stress = _by_stress(stiffness, kind)
    chord = float((stiffness.to_MPa - stiffness.from_MPa).iloc[0])
    return sheet(
        f"stiffness-{kind}",
        f"{kind.capitalize()} normal stiffness kn (MPa/mm) at the middle of chords between "
        f"stresses {chord:.2g} MPa apart (the section In short has a longer one); a dash near the "
        "maximum of loading, where small steps break less",
        by_stress,
        {name: name for name in by_stress},
    )


def _range_sheets(ranges: list[dict]) -> list[Sheet]:
    """Return the table of ranges, if the joint has them."""
    if not ranges:
        return []
    rows = pd.DataFrame(ranges)
    table = rows.pivot_table("text", "quantity", "cycle", "first").loc[list(QUANTITIES)]
    table.columns = [f"Cycle {cycle}" for cycle in table.columns]
    table.insert(0, "Quantity", [QUANTITIES[name] for name in table.index])
    caption = (
        "Best values (the median where the best value is outside) and their range over what the "
        "model leaves open; closures since seating"
    )
    return [sheet("range", caption, table, {name: name for name in table})]


def _sheets(cycles: pd.DataFrame, stiffness: pd.DataFrame, history: xr.Dataset) -> list[Sheet]:
    per_cycle = {
        "cycle": "Cycle",
        **headings("max_closure_seated_net_mm", "residual_closure_seated_net_mm"),
        "residual_share_net": "Its share of the closure",
        **headings(
            "max_closure_seated_mm", "max_closure_mm", "mean_aperture_at_max_mm", "contact_at_max"
        ),
    }
    of_law = {
        "cycle": "Cycle",
        "branch": "Branch",
        "law": "Law",
        "parameter": "Parameter",
        "value": "Value",
        "standard_error": "Standard error",
        "rms_mm": "Error (mm rms)",
        "holds_from_MPa": "Valid from (MPa)",
        "holds_to_MPa": "to (MPa)",
    }
    laws = fitted_laws(history)
    titles = {
        column: f"{title} ({unit})" if unit else title
        for law in LAWS.values()
        for column, (title, unit) in law.parameters.items()
    }
    laws["parameter"], laws["law"] = laws.parameter.map(titles), laws.law.map(law_words)
    return [
        sheet("cycles", "Closure by cycle", cycles, per_cycle),
        *(_stiffness_sheet(stiffness, kind) for kind in KINDS),
        sheet("laws", "Laws fitted to the net closure of each branch", laws, of_law),
    ]
