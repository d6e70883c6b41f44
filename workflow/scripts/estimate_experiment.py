"""Estimate the time of the joints of a study or an experiment from a few of them."""

from itertools import islice

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.pilots import estimate_time
from studies.frame.settings import walls_in

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        read, params = snakemake.input, snakemake.params
        scanned = {
            rock: list(islice(walls_in([file], settings), 1))
            for (rock, settings), file in zip(params.scanned.items(), read.scanned, strict=True)
        }
        estimate = estimate_time(params.groups, log, scanned)
        write_csv(estimate, snakemake.output[0])
