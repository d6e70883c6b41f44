"""Write the report: one page that holds all that it shows."""

from pathlib import Path

import pandas as pd
import xarray as xr

from jointclosure.config.configuration import resolved
from jointclosure.config.files import DEFAULT, MEASURED, read_plain
from jointclosure.config.keys import ConfigurationKeys
from jointclosure.config.schema import json_schema
from jointclosure.dataset import read_benchmarks, read_csv, reading_netcdf, write_text
from jointclosure.ensemble.checks import check_results
from jointclosure.logbook import Logbook, logging_to
from jointclosure.report.captions import read_caption
from jointclosure.report.content import Material, content
from jointclosure.report.page import Picture, render


def pictures(figures: list[str], captions: list[str], configuration: dict) -> list[Picture]:
    """Figures with their captions, which bear their names."""
    texts = {Path(path).stem: Path(path).read_text(encoding="utf-8") for path in captions}
    return [
        Picture(
            Path(path).stem,
            Path(path).read_bytes(),
            read_caption(texts[Path(path).stem], configuration),
        )
        for path in figures
    ]


def main(inputs: dict, settings: dict, output: str, log: Logbook) -> None:
    """Put the study's results, figures and job times into one page."""
    with reading_netcdf(inputs["study"]) as study:
        page = render(content(material_of(study, inputs, settings)))
    write_text(page, output)
    log(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")


def material_of(study: xr.Dataset, inputs: dict, settings: dict) -> Material:
    """All that the page is made from."""
    configuration = settings["configuration"]
    return Material(
        study=study,
        closures=read_csv(inputs["closures"]),
        intervals=where_there_is(inputs["intervals"]),
        claims=where_there_is(inputs["claims"]),
        predictive=where_there_is(inputs["predictive"]),
        joint=where_there_is(inputs["joint"]),
        elasticities=where_there_is(inputs["elasticities"]),
        # made again rather than read: where a check fails its table is not written
        checks=check_results(
            study,
            resolved(configuration).numerics,
            configuration["study"]["realizations"],
        ),
        paper=read_csv(inputs["paper"]),
        default=read_plain(DEFAULT),
        schema=json_schema(ConfigurationKeys),
        pictures=pictures(inputs["figures"], inputs["captions"], configuration),
        benchmarks=read_benchmarks(settings["benchmarks"]),
        measured=where_there_is(inputs["measured"]),
        accuracy=where_there_is(inputs["accuracy"]),
        presets=read_csv(MEASURED),
    )


def where_there_is(path: str) -> pd.DataFrame | None:
    """A table that not every study has; its input is empty where it has not."""
    return read_csv(path) if path else None


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(dict(snakemake.input), dict(snakemake.params), snakemake.output[0], logbook)
