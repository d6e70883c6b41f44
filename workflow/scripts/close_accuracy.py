"""Close the surfaces of one run of an accuracy study."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.accuracy.design import Setting, close_at


def main(setting: Setting, parameter: str, output: str, log: Logbook) -> None:
    """Write closures and times (level, realization, cycle)."""
    log(f"{setting.run}")
    write_netcdf(close_at(setting, parameter, log), output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            Setting(*snakemake.params.setting),
            snakemake.params.parameter,
            snakemake.output[0],
            logbook,
        )
