"""Find the indifference intervals, Eqs. (28) and (29), beside the paper's."""

from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.closure_tables import indifference_table
from studies.paper.covariates import read_covariates
from studies.paper.tables_1_to_3 import with_paper

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        (statistics,), root_seed = snakemake.params.statistics, snakemake.params.root_seed
        study = read_checked(snakemake.input.study, snakemake.params.key, without=CURVES)
        covariates = read_covariates(snakemake.input.covariates, study)
        intervals = indifference_table(study, statistics, root_seed, covariates)
        write_csv(with_paper(intervals, read_csv(snakemake.input.paper)), snakemake.output[0])
