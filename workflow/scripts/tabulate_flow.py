"""Tabulate mean and hydraulic apertures of all cases over stress."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.paper.apertures import flow_table

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        study = read_checked(snakemake.input.study, snakemake.params.key)
        write_csv(flow_table(study), snakemake.output[0])
