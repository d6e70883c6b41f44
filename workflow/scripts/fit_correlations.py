"""Correlations of mean and standard deviation, Eqs. (24) to (27), and elasticities."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.studies.sensitivity.closures import (
    correlation_table,
    elasticity_table,
    max_closure_table,
)


def main(study: str, pool: str, outputs: dict, log: Logbook) -> None:
    """Write coefficients, means and deviations of the study, and elasticities of the model."""
    dataset = read_netcdf(study, without=CURVES)
    write_csv(correlation_table(dataset), outputs["correlations"])
    write_csv(max_closure_table(dataset), outputs["closures"])
    write_csv(elasticity_table(read_netcdf(pool, without=CURVES)), outputs["elasticities"])
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input.study, snakemake.input.pool, dict(snakemake.output), logbook)
