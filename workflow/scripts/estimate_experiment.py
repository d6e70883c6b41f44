"""Estimate the time of an experiment from a few of its joints."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.pilots import described_time, estimate_time

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        estimate = estimate_time(snakemake.params.groups, log)
        log.show(described_time(estimate))
        write_csv(estimate, snakemake.output[0])
