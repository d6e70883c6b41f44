"""Measure how many plain simulations one that is adjusted by covariates replaces."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.variance_reduction import variance_reduction
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(ensemble: str, covariates: str | None, settings: dict, output: str, log: Logbook) -> None:
    """Write a row for each rock, parameter, response and cycle."""
    table = variance_reduction(
        read_netcdf(ensemble, without=CURVES),
        from_dataset(read_netcdf(covariates)) if covariates else None,
        settings["realizations"],
        settings["significance"],
        settings["root_seed"],
    )
    write_csv(table, output)
    log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.ensemble,
            snakemake.input.get("covariates") or None,
            dict(snakemake.params),
            snakemake.output[0],
            logbook,
        )
