"""Weigh the error of every setting against its time."""

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.randomness import generator, seed_of
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.studies.accuracy.cost import Resampling, cost_table, order_table, source_table
from jointclosure.studies.accuracy.design import Setting
from jointclosure.studies.accuracy.presets_table import setting_table


def main(inputs: list[str], settings: dict, outputs: dict, log: Logbook) -> None:
    """Write costs, orders of convergence and sources of error."""
    design = settings["design"]
    runs = dict(zip(settings["runs"], map(read_netcdf, inputs), strict=True))
    turned = from_plain(list[Setting], settings["settings"])
    costs = cost_table(
        turned,
        runs,
        {name: scene["finest"] for name, scene in design["scenes"].items()},
        generator(seed_of(settings["root_seed"], "accuracy")),
        design["resamples"],
        design["confidence"],
        settings["significance"],
    )
    write_csv(costs, outputs["costs"])
    write_csv(order_table(costs), outputs["orders"])
    drawn = Resampling(
        generator(seed_of(settings["root_seed"], "accuracy", "sources")),
        design["resamples"],
        design["confidence"],
    )
    sources = pd.concat(
        [
            source_table(costs, runs, scene, settings["realizations"], drawn)
            for scene in design["scenes"]
        ]
    )
    write_csv(sources, outputs["sources"])
    write_csv(
        setting_table(costs, turned, design["scenes"], design["presets"]), outputs["settings"]
    )
    log(f"{len(costs)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(list(snakemake.input.runs), dict(snakemake.params), dict(snakemake.output), logbook)
