"""Compute the effect of an uncertain JRC on Table 3 and on the findings of studies."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Statistics
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.claims import Evidence
from jointclosure.sensitivity.jrc_range import REPEATS, jrc_range_tables
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(inputs: dict, settings: dict, outputs: dict, log: Logbook) -> None:
    """Write both tables."""
    statistics = from_plain(Statistics, settings["statistics"])
    design = Design(draws=settings["realizations"], significance=statistics.significance)
    with reading_netcdf(inputs["study"]) as study, reading_netcdf(inputs["pool"]) as pool:
        # every half-width is drawn several times, with the usual number of repetitions in total
        repetitions = statistics.repetitions // REPEATS
        evidence = Evidence(study, pool, design, repetitions, settings["root_seed"])
        entries, claims = jrc_range_tables(
            evidence, statistics.jrc_half_widths, read_csv(inputs["paper"])
        )
    write_csv(entries, outputs["entries"])
    write_csv(claims, outputs["claims"])
    log(f"wrote {outputs['entries']}, {outputs['claims']}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), dict(snakemake.params), dict(snakemake.output), logbook)
