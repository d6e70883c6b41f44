"""Fit the correlations of mean and standard deviation, Eqs. (24) to (27)."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.closure_tables import correlation_table, max_closure_table
from studies.paper.covariates import read_covariates

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        study = read_checked(snakemake.input.study, snakemake.params.key, without=CURVES)
        covariates = read_covariates(snakemake.input.covariates, study)
        write_csv(correlation_table(study), snakemake.output.correlations)
        write_csv(max_closure_table(study, covariates), snakemake.output.closures)
