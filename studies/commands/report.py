"""Writes report.html from the results of a study. They may be from another machine; nothing is
computed again. Every file must be as it was written.
"""

import argparse
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.storage.files import read_csv, read_text, write_text
from jointclosure.storage.netcdf import reading_netcdf
from studies.frame.configuration import model
from studies.frame.keys import json_schema
from studies.frame.seals import check_folder
from studies.frame.yaml_files import DEFAULT, PAPER_TABLE_3, read_plain

_NEEDED = ("configuration.json", "max_closure.csv", "checks.csv")


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    what = "file of the page (default: report.html in the folder)"
    command.add_argument("--output", type=Path, help=what)


def run(arguments: argparse.Namespace) -> int:
    """Write the page."""
    output = arguments.output or arguments.results / "report.html"
    page = report_page(arguments.results)
    write_text(page, output)
    print(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")
    return 0


def report_page(folder: Path) -> str:
    """Write the report as one page without further files."""
    with needs("report", "a report"):
        from studies.paper.report.content import Material, content
        from studies.paper.report.page import Picture, render
    sealed = check_folder(folder)
    for name in ("study.nc", *(f"tables/{name}" for name in _NEEDED)):
        if (path := folder / name) not in sealed:
            raise InputError(f"{path}: must exist with a seal; is the study finished?")
    tables = [path for path in sealed if path.parent == folder / "tables"]
    figures = [path for path in sealed if path.parent == folder / "figures"]
    stated = read_text(folder / "tables/configuration.json")
    with reading_netcdf(folder / "study.nc") as study:
        material = Material(
            study=study.assign_attrs(configuration=stated),
            tables={path.stem: read_csv(path) for path in tables if path.suffix == ".csv"},
            paper=read_csv(PAPER_TABLE_3),
            default=read_plain(DEFAULT),
            schema=json_schema(model()),
            pictures={f.stem: Picture(f.read_bytes()) for f in figures if f.suffix == ".png"},
        )
        return render(content(material))
