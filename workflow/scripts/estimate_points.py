"""Estimate the time of an experiment, by one joint of each grid of each of its jobs."""

import sys

from jointclosure.ensemble.points import Jobs, estimated_time, unpacked
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.text import write_csv


def main(jobs: Jobs, output: str, log: Logbook) -> None:
    """Write the seconds of each job, and show their sum to the user."""
    table = estimated_time(jobs, log)
    write_csv(table, output)
    line = (
        f"{table.joints.sum()} joints will take about {table.seconds.sum() / 60:.0f} minutes on "
        "one core"
    )
    log(line)
    print(f"jointclosure: {line}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            {name: unpacked(points) for name, points in snakemake.params.jobs.items()},
            snakemake.output[0],
            logbook,
        )
