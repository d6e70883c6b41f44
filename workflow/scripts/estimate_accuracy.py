"""Estimate what an accuracy study takes, by one joint at every setting."""

import sys

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.accuracy.runs import Run, close_run, one_joint


def main(runs: dict[str, Run], output: str, log: Logbook) -> None:
    """Write seconds for each run, and say the sum where the user sees it."""
    rows = []
    for name, run in runs.items():
        realizations = run.levels[0].surfaces.realizations
        seconds = float(close_run(one_joint(run)).timing_simulation.sum()) * realizations
        rows.append({"run": name, "realizations": realizations, "seconds": seconds})
        log(f"{name}: about {seconds:.0f} s")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    said = f"{len(table)} runs will take about {table.seconds.sum() / 3600:.1f} core-hours"
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(from_plain(dict[str, Run], snakemake.params.runs), snakemake.output[0], logbook)
