"""Writes report.html from the folder of a joint that `jointclosure close` wrote. It may be
from another machine; nothing is computed again.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.budget import NOT_MODELLED, QUANTITIES
from jointclosure.engine.quantities import HEADINGS
from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.joint.curves import KINDS, cycle_table, net_responses, stiffness_table
from jointclosure.joint.laws import LAWS, fitted_laws, law_words
from jointclosure.storage.folders import add_file
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_text, write_text

with needs("report", "a page"):
    from jointclosure.cli.page import ABSENT, number_text, provenance_rows, render, source

_CYCLES = ("max_closure_seated_net_mm", "residual_closure_seated_net_mm", "residual_share_net",
           "max_closure_seated_mm", "max_closure_mm", "mean_aperture_at_max_mm",
           "contact_at_max")  # fmt: skip
_TITLES = HEADINGS | {
    "residual_share_net": "its share of the closure",
    "normal_stress_MPa": "normal stress (MPa)",
    "rms_mm": "error (mm rms)",
    "holds_from_MPa": "valid from (MPa)",
    "holds_to_MPa": "to (MPa)",
}


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, help="folder that `jointclosure close` wrote")
    what = "file of the page (default: report.html in the folder)"
    command.add_argument("--output", type=Path, help=what)


def run(arguments: argparse.Namespace) -> int:
    """Write the page."""
    folder, output = arguments.folder, arguments.output or arguments.folder / "report.html"
    if not (folder / "joint.json").is_file():
        raise InputError(f"{folder}: must be a folder that `jointclosure close` wrote")
    record = json.loads(read_text(folder / "joint.json"))
    with reading_netcdf(folder / "joint.nc") as history:
        content = joint_content(history.load(), record)
    sources = {file.stem: source(file.read_bytes()) for file in folder.glob("*.png")}
    page = render(content | {"sources": sources}, "joint.html.j2")
    write_text(page, output)
    if output.parent == folder:  # the page belongs to the folder of the joint
        add_file(folder, "close", output.name)
    print(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")
    return 0


def joint_content(history: xr.Dataset, record: dict) -> dict:
    """Return names and values for the template, from joint.nc and joint.json."""
    cycles, stiffness, laws = cycle_table(history), stiffness_table(history), fitted_laws(history)
    about = {column: about for law in LAWS.values() for column, about in law.parameters.items()}
    laws["parameter"] = [", ".join(filter(None, about[name])) for name in laws.parameter]
    laws["law"] = laws.law.map(law_words)
    branches = "cycle " + stiffness.cycle.astype(str) + ", " + stiffness.branch
    known = stiffness.assign(branch=branches)[~stiffness.landing]
    tables = {
        "cycles": cycles[["cycle", *_CYCLES]],
        "laws": laws[["cycle", "branch", "law", "parameter", "value", "standard_error", "rms_mm",
                      "holds_from_MPa", "holds_to_MPa"]],
    }  # fmt: skip
    for kind in KINDS:
        column = f"normal_stiffness_{kind}_MPa_per_mm"
        tables[f"stiffness_{kind}"] = _over(known, "normal_stress_MPa", "branch", column)
    if record["range"]:
        rows = pd.DataFrame(record["range"]).replace({"quantity": QUANTITIES})
        rows["cycle"] = "cycle " + rows.cycle.astype(str)
        tables["range"] = _over(rows, "quantity", "cycle", "text")
    largest = float(history.normal_stress.max())
    stiff = 1e-9 * net_responses(history, largest)["stiffness_net"][cycles.cycle - 1]
    results = cycles.assign(stiffness_net_MPa_per_mm=stiff).set_index("cycle")
    texts = {(entry["cycle"], entry["quantity"]): entry["text"] for entry in record["range"]}

    def text(name: str, cycle: int = 1) -> str:
        """Return a result with its range, if that is known; "" if there is none."""
        value = results.loc[cycle, name]
        return texts.get((cycle, name)) or (number_text(value, 3) if np.isfinite(value) else "")

    return record | {
        "joint": record["joint"].strip("<>").removeprefix("ClosedJoint: "),
        "text": text,
        "not_modelled": NOT_MODELLED,
        "ends": sorted({1, int(cycles.cycle.iloc[-1])}),
        "seating": 1e-6 * float(history.attrs["seating_stress_Pa"]),
        "half": 0.5e-6 * largest,
        "chord": float((stiffness.to_MPa - stiffness.from_MPa).iloc[0]),
        "tables": {name: _html(table) for name, table in tables.items()},
        "provenance": provenance_rows(history.attrs),
    }


def _over(rows: pd.DataFrame, index: str, columns: str, values: str) -> pd.DataFrame:
    """Arrange values of rows by one column along rows and by another along columns."""
    form = {"index": index, "columns": columns, "values": values}
    table = rows.pivot_table(**form, aggfunc="first", dropna=False, sort=False)
    return table.reset_index().rename_axis(columns=None)


def _html(table: pd.DataFrame) -> str:
    """Return a table as HTML, with four digits and the titles of its columns."""
    titles = {name: _TITLES.get(name, str(name).replace("_", " ")) for name in table}
    shown = table.rename(
        columns={name: text[0].upper() + text[1:] for name, text in titles.items()}
    )
    return shown.to_html(index=False, border=0, na_rep=ABSENT, float_format=number_text)
