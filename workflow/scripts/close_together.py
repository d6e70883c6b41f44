"""Close the joints of some rows of a design in which all inputs vary."""

from jointclosure.config.plain import from_plain
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.global_sensitivity.closing import close_rows
from jointclosure.studies.global_sensitivity.design import Design


def main(settings: dict, rock: str, output: str, log: Logbook) -> None:
    """Write what the joints of a rock's rows did."""
    design, rows = from_plain(Design, settings["design"]), range(*settings["rows"])
    write_netcdf(close_rows(design, settings["configuration"], rock, rows, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), snakemake.wildcards.rock, snakemake.output[0], logbook)
