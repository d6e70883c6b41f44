"""Cut the joints of a case out of scanned walls."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.checked_files import read_checked
from studies.frame.scanned_walls import cut_walls
from studies.frame.settings import surfaces_dataset

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        settings = snakemake.params.windows
        walls = read_checked(snakemake.input.walls, snakemake.params.walls_key)
        pairs = cut_walls(walls, settings)
        write_netcdf(surfaces_dataset(pairs, settings), snakemake.output[0])
