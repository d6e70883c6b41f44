"""Generate the surface pairs of a case."""

from jointclosure.dataset import write_netcdf_blocks
from jointclosure.logbook import Logbook, logging_to
from jointclosure.parameters import to_si
from jointclosure.study.ensemble import make_surfaces


def main(seeds: list[int], jrc: float, grid: dict, surface: dict, output: str, log: Logbook):
    """Write walls (realization, y, x) for the seeds."""
    grid = to_si(grid)
    shape = (grid["cells_y"], grid["cells_x"])
    log(f"{len(seeds)} pairs of {shape} cells, JRC {jrc:g}")
    surfaces = make_surfaces(seeds, jrc, shape, grid["spacing"], surface)
    write_netcdf_blocks(surfaces, "realization", output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(
            snakemake.params.seeds,
            snakemake.params.jrc,
            snakemake.params.grid,
            snakemake.params.surface,
            snakemake.output[0],
            logbook,
        )
