"""Correlations of mean and standard deviation, Eqs. (24) to (27), and elasticities."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.closures import (
    correlation_table,
    elasticity_table,
    max_closure_table,
)
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(study: str, pool: str, covariates: dict[str, str], outputs: dict, log: Logbook) -> None:
    """Write coefficients, means and deviations of the study, and elasticities of the model."""
    known = {name: from_dataset(read_netcdf(path)) for name, path in covariates.items()}
    dataset = read_netcdf(study, without=CURVES)
    write_csv(correlation_table(dataset), outputs["correlations"])
    write_csv(max_closure_table(dataset, known.get("study")), outputs["closures"])
    ensemble = read_netcdf(pool, without=CURVES)
    write_csv(elasticity_table(ensemble, known.get("pool")), outputs["elasticities"])
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        given = snakemake.input
        paths = {"study": given.get("covariates"), "pool": given.get("pool_covariates")}
        covariates = {name: path for name, path in paths.items() if path}
        main(given.study, given.pool, covariates, dict(snakemake.output), logbook)
