"""Writes report.html from the results of a study, which may be from another machine.

Nothing is computed again. The dataset must be as it was written; tables and figures are shown as
they are in their files, also where these were edited.
"""

import argparse
from collections.abc import Iterable
from pathlib import Path

import xarray as xr

from jointclosure.inputs.extras import needs
from jointclosure.storage.files import read_csv, read_text, write_text
from jointclosure.storage.netcdf import reading_netcdf
from studies.commands import existing, study_of
from studies.frame.configuration import model
from studies.frame.keys import json_schema
from studies.frame.yaml_files import DEFAULT, PAPER_TABLE_3, read_plain

_NEEDED = ("configuration.json", "max_closure.csv", "checks.csv")


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    what = "file of the page (default: report.html in the folder)"
    command.add_argument("--output", type=Path, help=what)


def run(arguments: argparse.Namespace) -> int:
    """Write the page of a study; raise `InputError` if one of its files is missing."""
    folder = arguments.results
    output = arguments.output or folder / "report.html"
    for name in _NEEDED:
        existing(folder / f"tables/{name}")
    tables, figures = (
        sorted(map(str, folder.glob(names))) for names in ("tables/*.*", "figures/*.png")
    )
    with reading_netcdf(study_of(folder)) as study:
        page = report_page(study, tables, figures)
    write_text(page, output)
    print(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")
    return 0


def report_page(study: xr.Dataset, tables: Iterable[str], figures: Iterable[str]) -> str:
    """Return the page of a study as HTML that needs no further file.

    ``tables`` and ``figures`` are paths of files; configuration.json must be among the tables.
    """
    with needs("report", "a report"):
        from jointclosure.cli.report import Picture
        from studies.paper.report.content import Material, content
        from studies.paper.report.page_rendering import render
    paths = {path.name: path for path in map(Path, tables)}
    stated = read_text(paths["configuration.json"])
    material = Material(
        study=study.assign_attrs(configuration=stated),
        tables={p.stem: read_csv(p) for p in paths.values() if p.suffix == ".csv"},
        paper=read_csv(PAPER_TABLE_3),
        default=read_plain(DEFAULT),
        schema=json_schema(model()),
        pictures={path.stem: Picture(path.read_bytes()) for path in map(Path, figures)},
    )
    return render(content(material))
