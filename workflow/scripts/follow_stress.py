"""Tabulate elasticities and indifference intervals along the closure curve."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Statistics
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.along_curve import along_curve
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import write_csv


def main(pool: str, settings: dict, output: str, log: Logbook) -> None:
    """Write them at stresses from seating to the maximum."""
    statistics = from_plain(Statistics, settings["statistics"])
    design = Design(draws=settings["realizations"], significance=statistics.significance)
    with reading_netcdf(pool) as ensemble:
        table = along_curve(
            ensemble,
            settings["seating_stress"],
            design,
            statistics.repetitions,
            settings["root_seed"],
        )
    write_csv(table, output)
    log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input.pool, dict(snakemake.params), snakemake.output[0], logbook)
