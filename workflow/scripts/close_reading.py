"""Close a block of surfaces at all cases of a rock, in one reading of the paper."""

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.experiments.readings.closing import close_block
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf


def main(settings: tuple[ClosureSettings, ...], output: str, log: Logbook) -> None:
    """Write closures (case, realization, cycle)."""
    write_netcdf(close_block(settings, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        settings = from_plain(tuple[ClosureSettings, ...], snakemake.params.settings)
        main(settings, snakemake.output[0], logbook)
