"""Close the surfaces of one run of an accuracy study."""

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.accuracy.runs import Run, close_run


def main(run: Run, output: str, log: Logbook) -> None:
    """Write closures and times (level, realization, cycle)."""
    write_netcdf(close_run(run, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(from_plain(Run, snakemake.params.run), snakemake.output[0], logbook)
