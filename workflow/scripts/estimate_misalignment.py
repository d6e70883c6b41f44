"""Estimate what a study of misalignment takes, by one joint of each of its jobs, aligned."""

import sys

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.misalignment.closing import close_misaligned
from jointclosure.studies.misalignment.design import MisalignedSettings


def main(settings: dict[str, MisalignedSettings], output: str, log: Logbook) -> None:
    """Write the seconds of each job, and say the sum where it is seen."""
    rows = []
    for name, told in settings.items():
        one = told.closures.surfaces._replace(realizations=1)
        aligned = told._replace(
            closures=told.closures._replace(surfaces=one), conditions=told.conditions[:1]
        )
        joints = len(told.conditions) * told.closures.surfaces.realizations
        rows.append(
            {
                "job": name,
                "joints": joints,
                "seconds": joints * float(close_misaligned(aligned).seconds.sum()),
            }
        )
        log(f"{name}: about {rows[-1]['seconds']:.0f} s")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    said = (
        f"{table.joints.sum()} joints will take about {table.seconds.sum() / 60:.0f} minutes on "
        "one core"
    )
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(dict[str, MisalignedSettings], snakemake.params.settings),
            snakemake.output[0],
            logbook,
        )
