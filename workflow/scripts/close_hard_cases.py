"""Simulate and judge the hard cases of a group."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.verification.hard_cases import close_hard_cases

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        rows = close_hard_cases(snakemake.params.cases, snakemake.wildcards.group, log)
        write_csv(rows, snakemake.output[0])
