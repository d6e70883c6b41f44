"""Close the joints of one job of an experiment."""

from jointclosure.engine.points import Point, as_dataset, close_points, unpacked
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(points: list[Point], quantities: list[str], output: str, log: Logbook) -> None:
    """Write a table with a row a joint and cycle, as netCDF."""
    write_netcdf(as_dataset(close_points(points, quantities, log)), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            unpacked(snakemake.params.points),
            list(snakemake.params.quantities),
            snakemake.output[0],
            logbook,
        )
