"""Tabulate results by two levels, the study's numerics and the finest, and their errors."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.accuracy import describe_reached, reached_table

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        (accuracy,), keys = snakemake.params.accuracy, snakemake.params.key_of
        study, finest = (
            read_checked(snakemake.input[name], keys[name], without=CURVES)
            for name in ("study", "finest")
        )
        table = reached_table(study, finest, accuracy, snakemake.params.significance)
        log(describe_reached(table, accuracy))
        write_csv(table, snakemake.output[0])
