"""Make a table of the joints of an experiment."""

from jointclosure.storage.folders import write
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.experiments import experiment_named
from studies.frame.joint_tables import as_table

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        tables = experiment_named(snakemake.params.experiment).tables
        keys = zip(snakemake.input, snakemake.params.keys_of_jobs, strict=True)
        joints = as_table(read_checked(file, key) for file, key in keys)
        table = tables[snakemake.wildcards.table](joints, snakemake.params.settings)
        write(table, snakemake.output[0])
