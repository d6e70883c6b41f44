"""Estimate what a study of effects takes, by one joint of its first rock in every scene."""

import sys

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Ablation
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.effects.ablation import SCENES, close_scene


def main(
    conditions: list[ClosureSettings], design: Ablation, rocks: int, output: str, log: Logbook
) -> None:
    """Write seconds for each scene of a rock, and say the sum where the user sees it."""
    realizations = conditions[0].surfaces.realizations
    one = [each._replace(surfaces=each.surfaces._replace(realizations=1)) for each in conditions]
    rows = []
    for scene, effects in SCENES.items():
        timing = close_scene(one, design, effects).timing_simulation
        seconds = float(timing.sum()) * realizations
        rows.append({"scene": scene, "seconds": seconds})
        log(f"{scene}: about {seconds:.0f} s a rock")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    hours = table.seconds.sum() * rocks / 3600
    said = f"{len(table)} scenes of {rocks} rocks will take about {hours:.1f} core-hours"
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(list[ClosureSettings], snakemake.params.conditions),
            from_plain(Ablation, snakemake.params.design),
            snakemake.params.rocks,
            snakemake.output[0],
            logbook,
        )
