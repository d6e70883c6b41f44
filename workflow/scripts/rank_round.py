"""Rank the entrants of a round of an experiment."""

from collections.abc import Mapping

import pandas as pd

from jointclosure.ensemble.points import as_table
from jointclosure.experiments import Experiment, experiment_named
from jointclosure.jobs.job import job, listed
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(
    experiment: Experiment,
    parameters: Mapping,
    joints: pd.DataFrame,
    entry: tuple[int, list[str]],
    output: str,
    log: Logbook,
) -> None:
    """Write the ranking of a round, of its number and entrants."""
    assert experiment.rank is not None  # it has rounds
    table = experiment.rank(joints, parameters, *entry)
    write_csv(table, output)
    log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        params = snakemake.params
        main(
            experiment_named(snakemake.wildcards.experiment),
            params.parameters | {name: read_csv(file) for name, file in params.files.items()},
            as_table(*map(read_netcdf, listed(snakemake.input.get("joints", [])))),
            (params.number, params.entrants),
            snakemake.output[0],
            logbook,
        )
