"""Draw Table 3 as it is distributed over repetitions of the study, as PNG and PDF."""

from jointclosure.storage.files import read_csv
from jointclosure.storage.folders import write
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked, reading_checked
from studies.paper.figures import predictive_figure

if __name__ == "__main__":
    read, params = snakemake.input, snakemake.params
    with logging_to(snakemake.log[0]):
        with reading_checked(read.study, params.key) as study:
            realizations = study.sizes["realization"]
        lengths, paper = read_checked(read.lengths, params.key), read_csv(read.paper)
        figure = predictive_figure(lengths, paper, params.rocks, realizations)
        for path in snakemake.output:
            write(figure, path)
