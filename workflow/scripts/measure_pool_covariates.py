"""Measure the covariates of the joints of the pool; their means are those of the study."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.covariates import Covariates, as_dataset, from_dataset, measure_covariates

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        grid, surface = snakemake.params.grid, snakemake.params.surface
        pool = read_checked(snakemake.input.study, snakemake.params.key, without=CURVES)
        means = from_dataset(read_checked(snakemake.input.means, snakemake.params.means_key)).known
        measured = Covariates(measure_covariates(pool, grid, surface), means)
        write_netcdf(as_dataset(measured, pool), snakemake.output[0])
