"""Cut the surface pairs of a case out of measured walls."""

from jointclosure.dataset import read_netcdf, write_netcdf_blocks
from jointclosure.logbook import Logbook, logging_to
from jointclosure.study.measured_walls import cut_surfaces, cutter_of


def main(walls: str, settings: dict, output: str, log: Logbook) -> None:
    """Write walls (realization, y, x) for the seeds."""
    shape = (settings["grid"]["cells_y"], settings["grid"]["cells_x"])
    cutter = cutter_of(read_netcdf(walls), shape, settings["order_seed"], settings["normalise"])
    log(f"{len(settings['seeds'])} of {len(cutter.windows)} windows of {shape} cells")
    write_netcdf_blocks(cut_surfaces(cutter, settings["seeds"]), "realization", output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input[0], dict(snakemake.params), snakemake.output[0], logbook)
