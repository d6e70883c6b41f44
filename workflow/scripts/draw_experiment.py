"""Draw the figures of an experiment from its tables."""

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path

from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv
from studies.frame.experiments import Experiment, experiment_named
from studies.frame.jobs.job import job, listed
from studies.frame.jobs.logbook import Logbook


def main(
    experiment: Experiment,
    parameters: Mapping,
    tables: Sequence[str],
    outputs: Sequence[str],
    log: Logbook,
) -> None:
    """Write each figure in the format of each of its files."""
    read = {Path(table).stem: read_csv(table) for table in tables if table.endswith(".csv")}
    for name, files in itertools.groupby(outputs, lambda output: Path(output).stem):
        figure = experiment.draw(name, read, parameters)
        for output in files:
            save_figure(figure, output)
            log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        params = snakemake.params
        main(
            experiment_named(params.experiment),
            params.parameters | {name: read_csv(file) for name, file in params.files.items()},
            listed(snakemake.input.tables),
            list(snakemake.output.figures),
            logbook,
        )
