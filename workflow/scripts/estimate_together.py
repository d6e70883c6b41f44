"""Estimate what a study of global sensitivity takes, by the first points of its first rows."""

import sys

from jointclosure.config.plain import from_plain
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.global_sensitivity.closing import costs
from jointclosure.studies.global_sensitivity.design import Design


def main(settings: dict, output: str, log: Logbook) -> None:
    """Write core-minutes for each rock, and say the sum where the user sees it."""
    table = costs(from_plain(Design, settings["design"]), settings["configuration"])
    write_csv(table, output)
    total, error = table.core_minutes.sum(), float((table.error**2).sum() ** 0.5)
    said = f"{table.simulations.sum()} simulations, about {total:.0f} ± {error:.0f} core-minutes"
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), snakemake.output[0], logbook)
