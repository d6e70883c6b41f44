"""`python -m studies report`: page on a finished study, without any computation."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr

from jointclosure.compilation.sources import ROOTS
from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_benchmarks, read_csv, read_text, write_text
from studies.commands import COMMANDS
from studies.frame.config.files import DEFAULT, MEASURED, PAPER_TABLE_3, read_plain
from studies.frame.config.model import model
from studies.frame.config.schema import json_schema
from studies.frame.jobs.seals import check_folder

if TYPE_CHECKING:  # not loaded by other commands
    from jointclosure.cli.page import Picture
    from studies.paper.report.content import Material

CAPTIONS = ROOTS["studies"] / "paper/report/texts"


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "report",
        help=COMMANDS["report"],
        description="Writes report.html from the results of a study. They may be from another "
        "machine; nothing is computed again. Every file must be as it was written.",
    )
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    command.add_argument(
        "--output", type=Path, help="file of the page (default: report.html in the folder)"
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Write the page."""
    output = arguments.output or arguments.results / "report.html"
    size = write_report(arguments.results, output)
    print(f"wrote {output}: {size / 1e6:.1f} MB")
    return 0


def write_report(folder: Path, output: Path) -> int:
    """Write a page with the results, figures and job times of a study; return its size in bytes."""
    with needs("report", "a report"):
        from studies.paper.report.content import content
        from studies.paper.report.page import render
    sealed = check_folder(folder)
    if folder / "study.nc" not in sealed:
        raise InputError(f"{folder / 'study.nc'}: must exist with a seal; is the study finished?")
    with reading_netcdf(folder / "study.nc") as study:
        page = render(content(_material(study, folder, sealed)))
    write_text(page, output)
    return len(page.encode())


def _material(study: xr.Dataset, folder: Path, sealed: list[Path]) -> "Material":
    """Collect the material of the page."""
    from studies.paper.report.content import Material

    stated = read_text(_sealed(folder / "tables/configuration.json", sealed))
    study, configuration = study.assign_attrs(configuration=stated), json.loads(stated)
    return Material(
        study=study,
        closures=_needed(folder / "tables/max_closure.csv", sealed),
        intervals=_table(folder / "tables/table_3_indifference.csv", sealed),
        claims=_table(folder / "tables/claims.csv", sealed),
        margins=_table(folder / "tables/claim_margins.csv", sealed),
        predictive=_table(folder / "tables/table_3_predictive.csv", sealed),
        joint=_table(folder / "tables/table_3_joint_tests.csv", sealed),
        elasticities=_table(folder / "tables/elasticities.csv", sealed),
        checks=_needed(folder / "tables/checks.csv", sealed),
        paper=read_csv(PAPER_TABLE_3),
        default=read_plain(DEFAULT),
        schema=json_schema(model()),
        pictures=_pictures(folder, sealed, configuration),
        benchmarks=read_benchmarks(folder / "benchmarks"),
        measured=_table(folder / "tables/measured_fit.csv", sealed),
        accuracy=_accuracy(folder.parent / "accuracy"),
        presets=read_csv(MEASURED),
        flow=_table(folder / "tables/hydraulic_aperture.csv", sealed),
        conclusions=_table(folder / "tables/conclusions.csv", sealed),
    )


def _pictures(folder: Path, sealed: list[Path], configuration: dict) -> "list[Picture]":
    """Return sealed figures that have a caption, in the order in which they were drawn."""
    from jointclosure.cli.page import Picture
    from studies.paper.report.page import read_caption

    figures = [path for path in sealed if path.parent == folder / "figures"]
    return [
        Picture(figure.stem, figure.read_bytes(), read_caption(text, configuration))
        for figure in figures
        if figure.suffix == ".png" and (caption := CAPTIONS / f"{figure.stem}.rst").is_file()
        for text in [caption.read_text(encoding="utf-8")]
    ]


def _accuracy(folder: Path) -> pd.DataFrame | None:
    """Return the measurements of `make accuracy`, if it was run beside this study."""
    return _table(folder / "tables/accuracy_cost.csv", check_folder(folder))


def _table(path: Path, sealed: list[Path]) -> pd.DataFrame | None:
    """Read a table that not every study has."""
    return read_csv(path) if path in sealed else None


def _needed(path: Path, sealed: list[Path]) -> pd.DataFrame:
    return read_csv(_sealed(path, sealed))


def _sealed(path: Path, sealed: list[Path]) -> Path:
    if path not in sealed:
        raise InputError(f"{path}: must exist with a seal; is the study finished?")
    return path
