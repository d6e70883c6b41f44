"""Measure the covariates of closed joints, and their means on further surfaces."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Grid, Surface
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.covariates import (
    Covariates,
    as_dataset,
    known_covariates,
    measure_covariates,
)
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf


def main(ensembles: dict[str, str], settings: dict, log: Logbook) -> None:
    """Write the covariates of each ensemble: files of covariates by files of closures."""
    grid, surface = from_plain(Grid, settings["grid"]), from_plain(Surface, settings["surface"])
    known = known_covariates(settings["surfaces"], settings["root_seed"], grid, surface)
    for closures, output in ensembles.items():
        study = read_netcdf(closures, without=CURVES)
        covariates = Covariates(measure_covariates(study, grid, surface), known)
        write_netcdf(as_dataset(covariates, study), output)
        log(f"wrote {output}: means from {known.surfaces} surfaces")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        outputs = snakemake.output
        main(
            dict(zip(snakemake.input.ensembles, outputs.covariates, strict=True)),
            dict(snakemake.params),
            logbook,
        )
