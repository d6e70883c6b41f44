"""Close the surfaces of one run of an accuracy study."""

from jointclosure.config.plain import from_plain
from jointclosure.dataset import write_netcdf
from jointclosure.logbook import Logbook, logging_to
from jointclosure.studies.accuracy.runs import Run, close_run


def main(run: Run, output: str, log: Logbook) -> None:
    """Write closures and times (level, realization, cycle)."""
    write_netcdf(close_run(run, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(from_plain(Run, snakemake.params.run), snakemake.output[0], logbook)
