"""Estimate what a study of readings takes, by one joint in every reading and rock."""

import sys

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.experiments.readings.closing import close_block, one_simulation
from jointclosure.experiments.readings.cost import costs
from jointclosure.experiments.readings.design import AS_CONFIGURED, Design
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.text import write_csv


def main(design: Design, settings: dict, output: str, log: Logbook) -> None:
    """Write core-minutes for each round, and say the sum where the user sees it."""

    def seconds(name: str, each: tuple[ClosureSettings, ...]) -> float:
        time = float(close_block(one_simulation(each)).seconds.sum())
        log(f"{name}: {time:.2f} s a simulation")
        return time

    rocks = from_plain(dict[str, tuple[ClosureSettings, ...]], settings["rocks"])
    readings = from_plain(dict[str, tuple[ClosureSettings, ...]], settings["readings"])
    of_rocks = {rock: seconds(rock, each) for rock, each in rocks.items()}
    of_readings = {name: seconds(name, each) for name, each in readings.items()}
    cases = len(readings[AS_CONFIGURED])
    table = costs(design, cases, of_rocks, of_readings)
    write_csv(table, output)
    said = (
        f"{table.simulations.sum()} simulations at most, about {table.core_minutes.sum():.0f} "
        "core-minutes"
    )
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(Design, snakemake.params.design),
            dict(snakemake.params),
            snakemake.output[0],
            logbook,
        )
