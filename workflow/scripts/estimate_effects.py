"""Estimate what a study of effects takes, by one joint of its first rock in every scene."""

import sys

import pandas as pd

from jointclosure.config.configuration import merged
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.studies.effects.ablation import SCENES, close_scene


def main(configuration: dict, output: str, log: Logbook) -> None:
    """Write seconds for each scene of a rock, and say the sum where the user sees it."""
    study = configuration["study"]
    one = merged(configuration, {"study": {"realizations": 1}})
    rows = []
    for scene, effects in SCENES.items():
        timing = close_scene(one, study["rocks"][0], effects).timing_simulation
        seconds = float(timing.sum()) * study["realizations"]
        rows.append({"scene": scene, "seconds": seconds})
        log(f"{scene}: about {seconds:.0f} s a rock")
    table = pd.DataFrame(rows)
    write_csv(table, output)
    hours = table.seconds.sum() * len(study["rocks"]) / 3600
    said = (
        f"{len(table)} scenes of {len(study['rocks'])} rocks will take about {hours:.1f} core-hours"
    )
    log(said)
    print(f"jointclosure: {said}", file=sys.__stderr__, flush=True)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.params.configuration, snakemake.output[0], logbook)
