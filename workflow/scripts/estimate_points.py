"""Estimate the time of an experiment from a few of its joints."""

import math
import sys

from jointclosure.engine.points import Sample, Samples, estimated_time, unpacked
from jointclosure.storage.text import write_csv
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(samples: Samples, output: str, log: Logbook) -> None:
    """Write the seconds of each job, and show their sum to the user."""
    table = estimated_time(samples, log)
    write_csv(table, output)
    minutes, error = table.seconds.sum() / 60, math.hypot(*table.error) / 60
    known = f" ± {error:.0f}" if math.isfinite(error) else ""
    line = f"{table.joints.sum()} joints will take about {minutes:.0f}{known} minutes on one core"
    log(line)
    print(f"jointclosure: {line}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            {
                name: [Sample(unpacked(points), joints) for points, joints in samples]
                for name, samples in snakemake.params.samples.items()
            },
            snakemake.output[0],
            logbook,
        )
