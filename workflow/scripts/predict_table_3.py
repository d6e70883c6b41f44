"""Predict Table 3 in repetitions of the study, and test whether the paper's is one of them."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Statistics
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.predictive import (
    joint_table,
    lengths_dataset,
    predictive,
    predictive_table,
)
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(pool: str, paper: str, settings: dict, outputs: dict, log: Logbook) -> None:
    """Write the distribution of each entry, the joint tests, and all lengths drawn."""
    statistics = from_plain(Statistics, settings["statistics"])
    design = Design(draws=settings["realizations"], significance=statistics.significance)
    ensemble = read_netcdf(pool, without=CURVES)
    predicted = predictive(ensemble, design, statistics.repetitions, settings["root_seed"])
    published = read_csv(paper)
    write_csv(predictive_table(predicted, published), outputs["entries"])
    joint = joint_table(predicted, published)
    write_csv(joint, outputs["joint"])
    write_netcdf(lengths_dataset(predicted), outputs["lengths"])
    for row in joint.itertuples():
        log(f"{row.entries}: p = {row.p:.3g}, without any effect {row.null_p:.3g}")
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.pool,
            snakemake.input.paper,
            dict(snakemake.params),
            dict(snakemake.output),
            logbook,
        )
