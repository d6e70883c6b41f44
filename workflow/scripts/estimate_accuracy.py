"""Estimate what an accuracy study takes, by one joint at every setting."""

import sys

import pandas as pd

from jointclosure.config.configuration import merged
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.accuracy.design import Setting, close_at


def main(runs: list[list], parameter: str, output: str, log: Logbook) -> None:
    """Write seconds for each run, and say the sum where the user sees it."""
    rows = []
    for run in (Setting(*each) for each in runs):
        realizations = run.configuration["study"]["realizations"]
        one = merged(run.configuration, {"study": {"realizations": 1}})
        timing = close_at(run._replace(configuration=one), parameter).timing_simulation
        seconds = float(timing.sum()) * realizations
        rows.append({"run": run.run, "realizations": realizations, "seconds": seconds})
        log(f"{run.run}: about {seconds:.0f} s")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    said = f"{len(table)} runs will take about {table.seconds.sum() / 3600:.1f} core-hours"
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.params.runs, snakemake.params.parameter, snakemake.output[0], logbook)
