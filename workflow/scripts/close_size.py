"""Close the nested patches of a rock and a spectrum."""

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.size.closing import SizeSettings, close_nested


def main(settings: SizeSettings, output: str, log: Logbook) -> None:
    """Write what was read of each joint (patch, spacing, position, realization, cycle)."""
    write_netcdf(close_nested(settings, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(SizeSettings, snakemake.params.settings),
            snakemake.output[0],
            logbook,
        )
