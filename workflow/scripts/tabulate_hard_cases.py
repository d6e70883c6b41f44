"""Join the groups of hard cases in one table, and tabulate their errors and features."""

from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from studies.verification.hard_cases import present_hard_cases

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        groups = [read_csv(file) for file in snakemake.input]
        table, errors, features = present_hard_cases(groups, snakemake.params.order)
        log(f"{int(table.holds.sum())} of {len(table)} hold")
        write_csv(table, snakemake.output.cases)
        write_csv(errors, snakemake.output.errors)
        write_csv(features, snakemake.output.features, figures=4)
