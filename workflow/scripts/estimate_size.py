"""Estimate what a study of the scale effect takes, by a few joints of its first rock."""

import sys

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.size.closing import SizeSettings, costs


def main(settings: dict[str, SizeSettings], rocks: int, output: str, log: Logbook) -> None:
    """Write seconds for each spectrum of a rock, and say the sum where the user sees it."""
    table = costs(settings)
    write_csv(table, output)
    minutes = table.seconds.sum() * rocks / 60
    said = f"{rocks * table.joints.sum()} joints will take about {minutes:.0f} minutes on one core"
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(dict[str, SizeSettings], snakemake.params.settings),
            snakemake.params.rocks,
            snakemake.output[0],
            logbook,
        )
