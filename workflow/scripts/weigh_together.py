"""Find indices, elasticities and conclusions from the joints of a design."""

from pathlib import Path

import xarray as xr

from jointclosure.config.plain import from_plain
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.studies.global_sensitivity.conclusions import conclusion_tables
from jointclosure.studies.global_sensitivity.design import Design
from jointclosure.studies.global_sensitivity.table import elasticity_table, index_table


def main(settings: dict, files: list[str], outputs: list[str], log: Logbook) -> None:
    """Write the tables."""
    design, keys = from_plain(Design, settings["design"]), settings["configuration"]
    closed = {
        rock: xr.concat(
            [read_netcdf(file) for file in files if Path(file).stem.rpartition(".")[0] == rock],
            "row",
        )
        for rock in design.rocks
    }
    conclusions, margins = conclusion_tables(design, keys, closed)
    tables = {
        "indices": index_table(design, closed),
        "elasticities": elasticity_table(design, keys, closed),
        "conclusions": conclusions,
        "margins": margins,
    }
    for output in outputs:
        table = tables[Path(output).stem.removeprefix("global_")]
        write_csv(table, output)
        log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            dict(snakemake.params),
            list(snakemake.input.closed),
            list(snakemake.output.tables),
            logbook,
        )
