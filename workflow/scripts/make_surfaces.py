"""Make the random surfaces of a case from their seeds."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.settings import surfaces_dataset, walls_of

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        settings = snakemake.params.surfaces
        write_netcdf(surfaces_dataset(walls_of(settings), settings), snakemake.output[0])
