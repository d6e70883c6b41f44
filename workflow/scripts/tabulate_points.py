"""Put the joints of an experiment together, and make its tables."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from jointclosure.ensemble.points import as_dataset, as_table
from jointclosure.experiments import Experiment, experiment_named
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv


def main(
    experiment: Experiment,
    parameters: Mapping,
    files: list[str],
    configuration: dict,
    outputs: Mapping,
    log: Logbook,
) -> None:
    """Write the table of all joints as netCDF, and each table of the experiment."""
    joints = pd.concat([as_table(read_netcdf(file)) for file in files], ignore_index=True)
    write_netcdf(as_dataset(joints).assign_attrs(provenance(configuration)), outputs["joints"])
    tables = experiment.tabulate(joints, parameters)
    for output in outputs["tables"]:
        table = tables[Path(output).stem]
        write_csv(table, output)
        log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        tables = snakemake.output.tables
        main(
            experiment_named(snakemake.params.experiment),
            snakemake.params.parameters,
            list(snakemake.input.joints),
            snakemake.config,
            {
                "joints": snakemake.output.joints,
                "tables": [tables] if isinstance(tables, str) else list(tables),
            },
            logbook,
        )
