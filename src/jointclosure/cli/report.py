"""Writes report.html from the folder of a joint that `jointclosure close` wrote. It may be
from another machine; nothing is computed again.
"""

import argparse
import base64
import hashlib
import json
import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import pandas as pd
import xarray as xr

from jointclosure.cli.command_results import ENDED_WELL, with_bands
from jointclosure.ensembles.quantities import CURVES, HEADINGS
from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.joint.laws import LAWS, fitted_laws
from jointclosure.joint.status import LOADING, STATUSES
from jointclosure.statistics.number_texts import ABSENT, grid_text, number_text, percent_number
from jointclosure.storage.files import read_csv, read_text, write_text
from jointclosure.storage.folders import add_file
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.uncertainty.budget import NOT_MODELLED
from jointclosure.uncertainty.ranged_results import RANGED_RESULTS

with needs("report", "a page"):
    import jinja2

LIBRARY = "jointclosure.cli"
"""Package with the style and the frame of all pages, those of studies among them."""
_MODEL = (
    "no fluid pressure acts on the walls, and no shear; a cell of the grid is an asperity, so that "
    "another spacing gives another closure"
)

FILES = {
    "Barton-Bandis constants for UDEC and 3DEC": ["barton_bandis.dat"],
    "Stiffness and aperture tables for 3DEC": ["joint_stiffness.dat"],
    "Constants for PorePy": ["porepy*.json"],
    "Apertures and constants for GEOS (geos_gap.csv is the coordinate of the tables: no range)": [
        "geos*.xml",
        "geos*.csv",
    ],
    "Mesh of the joint with its apertures": ["fracture.vtu"],
    "Curves at round stresses, with ranges": ["answer.csv"],
    "Fitted laws": ["laws.csv"],
    "Every step, and every cycle": ["curves.csv", "cycles.csv"],
    "Results of each source of uncertainty": ["range.csv"],
    "All data": ["joint.json", "joint.nc"],
}
"""Names of the files that `jointclosure close` writes, by descriptions; those for other programs
come first."""

_TITLES = {
    **HEADINGS,
    "normal_stress_MPa": "normal stress (MPa)",
    "rms_mm": "error (mm rms)",
    "holds_from_MPa": "valid from (MPa)",
    "holds_to_MPa": "to (MPa)",
    **{name: title for name, (title, _) in CURVES.items()},
}


class Picture(NamedTuple):
    """A figure of a page, as PNG."""

    png: bytes

    @property
    def source(self) -> str:
        """Figure as a data URL."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the figure [pixels], from the first chunk of the PNG."""
        return int.from_bytes(self.png[16:20]), int.from_bytes(self.png[20:24])

    @property
    def readable(self) -> str:
        """Style (CSS) with the width at which the figure's letters are readable on a phone."""
        return f"--readable: {round(0.55 * self.size[0])}px"


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, help="folder that `jointclosure close` wrote")
    what = "file of the page (default: report.html in the folder)"
    command.add_argument("--output", type=Path, help=what)


def run(arguments: argparse.Namespace) -> int:
    """Write the page about a joint; it becomes a file of the joint's folder if it lies there."""
    folder = arguments.folder
    output = arguments.output or arguments.folder / "report.html"
    if not (folder / "joint.json").is_file():
        raise InputError(f"{folder}: must be a folder that `jointclosure close` wrote")
    record = json.loads(read_text(folder / "joint.json"))
    with reading_netcdf(folder / "joint.nc") as history:
        content = joint_content(history.load(), read_csv(folder / "answer.csv"), record)
    pictures = {file.stem: Picture(file.read_bytes()) for file in folder.glob("*.png")}
    files = files_of(folder, output.parent)
    page = render(content | {"pictures": pictures, "files": files}, "joint.html.j2")
    write_text(page, output)
    if output.parent == folder:  # the page belongs to the folder of the joint
        add_file(folder, "close", output.name)
    print(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")
    return 0


def files_of(folder: Path, start: Path) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the description of each group of a joint's files, and (name, address) of its files.

    Addresses are relative to the folder ``start`` of the page, and "" if no path leads from there
    to the ``folder`` of the joint. Groups without a file are left out.
    """
    try:
        way = Path(os.path.relpath(folder.resolve(), start.resolve())).as_posix()
    except ValueError:  # on another drive
        way = ""
    found = []
    for about, patterns in FILES.items():
        names = [file.name for pattern in patterns for file in sorted(folder.glob(pattern))]
        if names:
            found.append((about, [(name, way and quote(f"{way}/{name}")) for name in names]))
    return found


def joint_content(history: xr.Dataset, curves: pd.DataFrame, record: dict) -> dict:
    """Return what the template joint.html.j2 needs besides ``pictures`` and ``files``.

    It has all of ``record``, tables as HTML, and the functions ``text`` and ``with_choices`` of a
    result and a cycle. Laws are fitted here. ``history`` is joint.nc, ``curves`` answer.csv and
    ``record`` joint.json, as `close` writes them. Raise `KeyError` if an entry is missing.
    """
    laws = fitted_laws(history)
    about = {column: about for law in LAWS.values() for column, about in law.parameters.items()}
    laws["parameter"] = [", ".join(filter(None, about[name])) for name in laws.parameter]
    laws["law"] = laws.law.str.replace("_", "-")
    first = pd.DataFrame(record["table"])

    wider = pd.DataFrame(record.get("with_other_choices") or {})

    def text(name: str, cycle: int = 1) -> str:
        """Return a result of a cycle for the HTML page, with its range if that is known.

        ``name`` is a column of `RANGED_RESULTS`. The text is "" if the result is missing.
        """
        return first.loc[RANGED_RESULTS[name], f"cycle {cycle}"].removeprefix(ABSENT)

    def with_choices(name: str, cycle: int = 1) -> str:
        """Return the range of a result with other choices of the model, for the HTML page.

        ``name`` is a column of `RANGED_RESULTS`. The text is "" if no such range is known.
        """
        return "" if wider.empty else wider.loc[RANGED_RESULTS[name], f"cycle {cycle}"]

    loading = curves[curves.branch == LOADING]
    bands = {name: with_bands(loading, name, 3) for name in CURVES if name in loading}
    tables = {
        "results": first.rename_axis("result").reset_index(),
        "curves": loading[["cycle", "normal_stress_MPa"]].assign(**bands),
        "laws": laws[["cycle", "branch", "law", "parameter", "value", "standard_error", "rms_mm",
                      "holds_from_MPa", "holds_to_MPa"]],
    }  # fmt: skip
    if record.get("at"):
        tables["named"] = pd.DataFrame(record["at"])
    if record.get("at_with_other_choices"):
        tables["named_choices"] = pd.DataFrame(record["at_with_other_choices"])
    if len(wider):
        tables["choices"] = wider.rename_axis("result").reset_index()
    return record | {
        "notes": _notes(record),
        "size": size_text(tuple(record["cells_y_x"]), 1e-3 * record["spacing_mm"]),
        "text": text,
        "with_choices": with_choices,
        "not_modelled": NOT_MODELLED,
        "ends": sorted({1, int(history.load_cycle.max())}),
        "seating": 1e-6 * float(history.attrs["seating_stress_Pa"]),
        "half": 0.5e-6 * float(history.normal_stress.max()),
        "tables": {name: _html(table) for name, table in tables.items()},
        "provenance": provenance_rows(history.attrs),
    }


def size_text(shape: tuple[int, int], spacing: float) -> str:
    """Return the size of a joint as text, x before y: "24 x 20 mm (96 x 80 cells of 0.25 mm)".

    ``shape`` (ny, nx) are the numbers of cells, ``spacing`` [m] is that of the grid.
    """
    ny, nx = shape
    size = 1e3 * spacing
    return f"{nx * size:.4g} x {ny * size:.4g} mm ({grid_text(shape, spacing)})"


def _notes(record: dict) -> list[str]:
    """Return the sentences that stand before the first numbers of the page.

    They are on the joint, its status, its cautions, and the limits of the model. A joint without
    flags is called a success only if there are no cautions.
    """
    word, _, names = record["status"].partition(": ")
    flags = [flag for flag in STATUSES.values() if flag.name in names.split(", ")]
    remarks = "; ".join(f"{flag.words}; {flag.meaning}" for flag in flags) or names
    ended = f"{word if word == 'failed' else ENDED_WELL}: {remarks}"
    if word != "failed" and not names:
        ended = "" if record["warnings"] else record["status"]
    about = record.get("description") or record["joint"].strip("<>").removeprefix("ClosedJoint: ")
    notes = [about, ended, *record["warnings"], _MODEL]
    return [sentence(note) for note in notes if note]


def sentence(text: str) -> str:
    """Return a text with a capital letter at its beginning and one mark at its end."""
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?", "!")) else ".")


def _html(table: pd.DataFrame) -> str:
    """Return a table as HTML, with four digits and the titles of its columns."""
    titles = {name: _TITLES.get(name, str(name).replace("_", " ")) for name in table}
    shown = table.rename(
        columns={name: text[0].upper() + text[1:] for name, text in titles.items()}
    )
    return shown.to_html(index=False, border=0, na_rep=ABSENT, float_format=number_text)


def render(content: dict, template: str, package: str = LIBRARY) -> str:
    """Render a page as HTML from its content and a template of the library or of a package."""
    loaders = [jinja2.PackageLoader(name) for name in dict.fromkeys((package, LIBRARY))]
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(loaders), undefined=jinja2.StrictUndefined,
        autoescape=True, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    style = resources.files(LIBRARY).joinpath("templates/style.css").read_text(encoding="utf-8")
    environment.filters["percent_number"] = percent_number
    return environment.get_template(template).render(content, style=style)


def provenance_rows(about: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the rows (term, value) on the provenance of results.

    ``about`` are the attributes of their dataset. Terms that it does not have are left out.
    """
    settings = about["configuration" if "configuration" in about else "settings"]
    digest = hashlib.sha256(settings.encode()).hexdigest()[:16]
    named = {
        "Model": about.get("references"),
        "Sources, commit": about["provenance_commit"],
        "Sources, digest": about["source_digest"],
        "Configuration, digest (SHA-256, first 16 digits)": digest,
        "Root seed, from which every random number follows": about.get("root_seed"),
        "Machine": about["provenance_machine"],
    }
    versions = json.loads(about["provenance_versions"])
    rows = [(term, value) for term, value in named.items() if value is not None]
    return rows + [(f"Version of {name}", version) for name, version in versions.items()]
