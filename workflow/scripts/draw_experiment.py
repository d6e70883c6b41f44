"""Draw a figure of the tables of an experiment, as PNG and PDF."""

from pathlib import Path

from jointclosure.storage.files import read_csv
from jointclosure.storage.folders import write
from jointclosure.storage.logs import logging_to
from studies.frame.experiments import experiment_named

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        figures = experiment_named(snakemake.params.experiment).figures
        tables = {Path(file).stem: read_csv(file) for file in snakemake.input}
        figure = figures[snakemake.wildcards.figure](tables, snakemake.params.settings)
        for path in snakemake.output:
            write(figure, path)
