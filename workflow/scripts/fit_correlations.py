"""Fit the correlations of mean and standard deviation, Eqs. (24) to (27)."""

from jointclosure.ensemble.aggregation import CURVES
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.studies.sensitivity.responses import correlation_table, max_closure_table


def main(study: str, correlations: str, closures: str, log: Logbook) -> None:
    """Write the table of coefficients and that of means and deviations."""
    dataset = read_netcdf(study, without=CURVES)
    write_csv(correlation_table(dataset), correlations)
    write_csv(max_closure_table(dataset), closures)
    log(f"wrote {correlations} and {closures}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input[0],
            snakemake.output.correlations,
            snakemake.output.closures,
            logbook,
        )
