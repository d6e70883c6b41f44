"""Estimate what a study of mismatch takes, by one joint of its first rock at every condition."""

import sys

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.mismatch.closing import close_mismatched


def main(
    settings: dict[str, list[ClosureSettings]],
    rocks: int,
    output: str,
    log: Logbook,
) -> None:
    """Write seconds for each mismatch wavelength of a rock, and say the sum where it is seen."""
    rows = []
    for label, conditions in settings.items():
        surfaces = [each.surfaces._replace(realizations=1) for each in conditions]
        one = [each._replace(surfaces=few) for each, few in zip(conditions, surfaces, strict=True)]
        spent = close_mismatched(one).seconds
        seconds = float(spent.sum()) * conditions[0].surfaces.realizations
        rows.append({"wavelength": label, "seconds": seconds})
        log(f"{label}: about {seconds:.0f} s a rock")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    conditions = sum(len(each) for each in settings.values())
    minutes = table.seconds.sum() * rocks / 60
    said = (
        f"{conditions} conditions of {rocks} {'rock' if rocks == 1 else 'rocks'} will take about "
        f"{minutes:.0f} minutes on one core"
    )
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(dict[str, list[ClosureSettings]], snakemake.params.settings),
            snakemake.params.rocks,
            snakemake.output[0],
            logbook,
        )
