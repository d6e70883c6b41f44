"""Hydraulic apertures of a study's cases as a table."""

from jointclosure.ensemble.flow_table import flow_table
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(study: str, output: str, log: Logbook) -> None:
    """Write means and deviations over realisations."""
    table = flow_table(read_netcdf(study))
    write_csv(table, output)
    log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input.study, snakemake.output[0], logbook)
