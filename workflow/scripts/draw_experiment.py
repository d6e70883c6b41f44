"""Draw the figures of an experiment from its tables."""

import itertools
from pathlib import Path

from jointclosure.storage.files import read_csv, save_figure
from studies.frame.experiments import checked, experiment_named
from studies.frame.jobs import job, listed

if __name__ == "__main__":
    with job(snakemake) as logbook:
        experiment = experiment_named(snakemake.params.experiment)
        design = experiment.design(checked(snakemake.config))
        files = {name: read_csv(file) for name, file in design.files.items()}
        tables = [path for path in listed(snakemake.input.tables) if path.endswith(".csv")]
        read = {Path(table).stem: read_csv(table) for table in tables}
        figures = listed(snakemake.output.figures)
        for name, outputs in itertools.groupby(figures, lambda output: Path(output).stem):
            figure = experiment.draw(name, read, design.parameters | files)
            for output in outputs:
                save_figure(figure, output)
                logbook(f"drew {output}")
