"""Join the joints of an experiment, and make its tables."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from jointclosure.engine.points import as_dataset, as_table
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import read_csv, write_csv, write_text
from studies.frame.experiments import Experiment, experiment_named
from studies.frame.jobs.job import job, listed
from studies.frame.jobs.logbook import Logbook


def main(
    experiment: Experiment,
    parameters: Mapping,
    joints: pd.DataFrame,
    configuration: dict,
    outputs: Mapping[str, Iterable[str]],
    log: Logbook,
) -> None:
    """Write the table of all joints as netCDF, and each table of the experiment."""
    for output in outputs["joints"]:
        write_netcdf(as_dataset(joints).assign_attrs(provenance(configuration)), output)
    tables = experiment.tabulate(joints, parameters)
    for output in outputs["tables"]:
        table = tables[Path(output).name.removesuffix(".csv")]
        write_text(table, output) if isinstance(table, str) else write_csv(table, output)
        log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        params, inputs, outputs = snakemake.params, snakemake.input, snakemake.output
        files = {name: read_csv(file) for name, file in params.files.items()}
        main(
            experiment_named(params.experiment),
            params.parameters | files,
            as_table(*map(read_netcdf, listed(inputs.joints))),
            snakemake.config,
            {name: listed(outputs[name]) for name in ("joints", "tables")},
            logbook,
        )
