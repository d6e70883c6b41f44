"""Read the scanned walls of a rock, register them, and put them on the grid of its joints."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.scanned_walls import prepare_walls

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        walls = prepare_walls(**snakemake.params.settings, log=log, show=log.show)
        write_netcdf(walls.assign_attrs(key=snakemake.params.key), snakemake.output[0])
