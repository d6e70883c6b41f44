"""Close the walls of a rock at one mismatch wavelength, at all tilts and rotations."""

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.misalignment.closing import close_misaligned
from jointclosure.studies.misalignment.design import MisalignedSettings


def main(settings: MisalignedSettings, output: str, log: Logbook) -> None:
    """Write what was read of each joint (wavelength, condition, realization, cycle)."""
    write_netcdf(close_misaligned(settings, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(MisalignedSettings, snakemake.params.settings),
            snakemake.output[0],
            logbook,
        )
