"""Rank the joints of a study by hardness."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.assessment.report_tables import hardness_table
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        study = read_checked(snakemake.input.study, snakemake.params.key, without=CURVES)
        write_csv(
            hardness_table(study, snakemake.params.within, snakemake.params.jumps),
            snakemake.output[0],
        )
