"""Tabulate the evidence for each conclusion of the paper."""

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.conclusions import conclusion_table
from jointclosure.storage.text import read_csv, write_csv

BESIDE = ("jrc_range", "readings", "choices", "margins")
"""Tables of other studies."""


def main(inputs: dict, outputs: dict, log: Logbook) -> None:
    """Write the table, with empty columns for studies that were not run."""
    beside = {name: read_csv(inputs[name]) for name in BESIDE if inputs[name]}
    table = conclusion_table(read_csv(inputs["claims"]), **beside)
    write_csv(table, outputs["table"])
    for name in BESIDE:
        log(f"{name}: {inputs[name] or 'of the default study only; the columns are empty'}")
    log(f"wrote {outputs['table']}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), dict(snakemake.output), logbook)
