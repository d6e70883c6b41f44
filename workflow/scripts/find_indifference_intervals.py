"""Find the indifference intervals, Eqs. (28) and (29), beside the paper's."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Statistics
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import from_dataset
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.intervals import indifference_table
from jointclosure.sensitivity.tables import with_paper
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(
    study: str, paper: str, covariates: str | None, settings: dict, output: str, log: Logbook
) -> None:
    """Write Table 3 as one row per rock, parameter and cycle."""
    intervals = indifference_table(
        read_netcdf(study, without=CURVES),
        from_plain(Statistics, settings["statistics"]),
        settings["root_seed"],
        from_dataset(read_netcdf(covariates)) if covariates else None,
    )
    write_csv(with_paper(intervals, read_csv(paper)), output)
    log(f"wrote {output}: {len(intervals)} intervals")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.study,
            snakemake.input.paper,
            snakemake.input.get("covariates") or None,
            dict(snakemake.params),
            snakemake.output[0],
            logbook,
        )
