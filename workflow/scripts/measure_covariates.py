"""Measure the covariates of the study's surfaces, and their means on further surfaces."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.covariates import Covariates, as_dataset, known_covariates, measure_covariates

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        params = snakemake.params
        grid, surface = params.grid, params.surface
        study = read_checked(snakemake.input.study, params.key, without=CURVES)
        means = known_covariates(params.surfaces, params.root_seed, grid, surface)
        measured = Covariates(measure_covariates(study, grid, surface), means)
        write_netcdf(as_dataset(measured, study), snakemake.output[0])
