"""Predict Table 3 in repetitions of the study, and test whether the paper's is one of them."""

from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.checked_files import read_checked, reading_checked
from studies.frame.datasets import CURVES
from studies.paper.predictive import joint_table, lengths_dataset, predictive, predictive_table

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        read, params, output = snakemake.input, snakemake.params, snakemake.output
        pool, paper = read_checked(read.pool, params.key_of["pool"], CURVES), read_csv(read.paper)
        with reading_checked(read.study, params.key_of["study"]) as study:
            design = Design(study.sizes["realization"], params.significance)
        lengths = predictive(pool, design, params.repetitions, params.root_seed)
        write_csv(predictive_table(lengths, paper), output.predictive)
        write_csv(joint_table(lengths, paper), output.tests)
        write_netcdf(
            lengths_dataset(lengths).assign_attrs(key=params.key_of["study"]), output.lengths
        )
