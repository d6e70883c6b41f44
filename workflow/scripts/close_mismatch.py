"""Close the walls of a rock at one mismatch wavelength, at all shifts."""

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.mismatch.closing import close_mismatched


def main(settings: list[ClosureSettings], output: str, log: Logbook) -> None:
    """Write what was read of each joint (wavelength, shift, realization, cycle)."""
    write_netcdf(close_mismatched(settings, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(list[ClosureSettings], snakemake.params.settings),
            snakemake.output[0],
            logbook,
        )
