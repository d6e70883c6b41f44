"""Measure the covariates of closed joints, and their means on further surfaces."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Grid, Surface
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import (
    Covariates,
    as_dataset,
    from_dataset,
    known_covariates,
    measure_covariates,
)
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf


def main(ensemble: str, known: str | None, settings: dict, output: str, log: Logbook) -> None:
    """Write the covariates of an ensemble; their means are those of the file ``known``, if any."""
    grid, surface = from_plain(Grid, settings["grid"]), from_plain(Surface, settings["surface"])
    if known:
        means = from_dataset(read_netcdf(known)).known
    else:
        means = known_covariates(settings["surfaces"], settings["root_seed"], grid, surface)
    study = read_netcdf(ensemble, without=CURVES)
    covariates = Covariates(measure_covariates(study, grid, surface), means)
    write_netcdf(as_dataset(covariates, study), output)
    log(f"wrote {output}: means from {means.surfaces} surfaces")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.ensemble,
            snakemake.input.get("known"),
            dict(snakemake.params),
            snakemake.output[0],
            logbook,
        )
