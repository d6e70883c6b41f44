"""Judge the paper's claims by the model and by the study."""

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Statistics
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.claims import Evidence, judge_claims
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(inputs: dict, settings: dict, outputs: dict, log: Logbook) -> None:
    """Write each claim with the paper's figures and both answers, and the margins that decide."""
    statistics = from_plain(Statistics, settings["statistics"])
    design = Design(draws=settings["realizations"], significance=statistics.significance)
    with reading_netcdf(inputs["study"]) as study, reading_netcdf(inputs["pool"]) as pool:
        evidence = Evidence(study, pool, design, statistics.repetitions, settings["root_seed"])
        claims, margins = judge_claims(evidence, read_csv(inputs["paper"]))
    write_csv(claims, outputs["claims"])
    write_csv(margins, outputs["margins"])
    for row in claims.itertuples():
        often = "" if pd.isna(row.found_share) else f"; found by {row.found_share:.0%} of studies"
        log(f"{row.number}: {row.claim}: {row.verdict}{often}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), dict(snakemake.params), dict(snakemake.output), logbook)
