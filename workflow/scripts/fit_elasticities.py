"""Elasticities of the closure, of all surfaces of a study."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.closures import elasticity_table
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(ensemble: str, covariates: str | None, output: str, log: Logbook) -> None:
    """Write the elasticities of the model."""
    known = from_dataset(read_netcdf(covariates)) if covariates else None
    write_csv(elasticity_table(read_netcdf(ensemble, without=CURVES), known), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        given = snakemake.input
        main(given.ensemble, given.get("covariates"), snakemake.output[0], logbook)
