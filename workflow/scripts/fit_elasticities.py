"""Fit the elasticities of the closure to the joints of the pool, or of the study without one."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.closure_tables import elasticity_table
from studies.paper.covariates import read_covariates

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        pool = read_checked(snakemake.input.pool, snakemake.params.key, without=CURVES)
        covariates = read_covariates(snakemake.input.covariates, pool)
        write_csv(elasticity_table(pool, covariates), snakemake.output[0])
