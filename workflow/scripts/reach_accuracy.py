"""Compare the accuracy of a study with the wanted accuracy."""

from jointclosure.config.files import METHODS
from jointclosure.config.plain import from_plain
from jointclosure.config.wanted import Wanted, preset_errors
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.reached import describe_reached, reached_table
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(study: str, covariates: str | None, settings: dict, output: str, log: Logbook) -> None:
    """Write a row for each mean or interval."""
    wanted = from_plain(Wanted, settings["wanted"])
    methods = read_csv(METHODS)
    errors = {
        rock: preset_errors(methods, settings["preset"], wanted.of, measured)
        for rock, measured in settings["rocks"].items()
    }
    table = reached_table(
        read_netcdf(study, without=CURVES),
        from_dataset(read_netcdf(covariates)) if covariates else None,
        wanted,
        errors,
        settings["significance"],
    )
    write_csv(table, output)
    log(describe_reached(table, wanted))


if __name__ == "__main__":
    with job(snakemake) as logbook:
        inputs = snakemake.input
        main(
            inputs.study,
            inputs.get("covariates") or None,
            dict(snakemake.params),
            snakemake.output[0],
            logbook,
        )
