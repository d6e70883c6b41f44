"""Show estimates of the time of experiments, also those that were made before."""

from jointclosure.storage.files import read_csv
from jointclosure.storage.logs import logging_to
from studies.frame.pilots import described_time

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        for table in snakemake.input:
            params = snakemake.params
            log.show(described_time(read_csv(table), params.notes, params.assessed))
