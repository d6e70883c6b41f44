"""Correlations of mean and standard deviation, Eqs. (24) to (27)."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.closures import correlation_table, max_closure_table
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(study: str, covariates: str | None, outputs: dict, log: Logbook) -> None:
    """Write coefficients, means and deviations of the study."""
    known = from_dataset(read_netcdf(covariates)) if covariates else None
    dataset = read_netcdf(study, without=CURVES)
    write_csv(correlation_table(dataset), outputs["correlations"])
    write_csv(max_closure_table(dataset, known), outputs["closures"])
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        given = snakemake.input
        main(given.study, given.get("covariates"), dict(snakemake.output), logbook)
