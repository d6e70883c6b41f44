"""Compare the selected effects with all effects at random conditions."""

from functools import partial
from pathlib import Path

import pandas as pd

from jointclosure.engine.cache import Entry, make_missing
from jointclosure.engine.points import as_table
from jointclosure.storage.figures import save_figures
from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from studies.effects.figures import choice_figure, region_figure
from studies.effects.validation import (
    ValidationSettings,
    validated_scene,
    validation_summary,
)
from studies.frame.jobs.job import compile_all, job

FIGURES = {"effects_auto": choice_figure, "effects_regions": region_figure}


def closed_scenes(
    settings: ValidationSettings, kernels: list, folder: Path, workers: int, log: Logbook
) -> pd.DataFrame:
    """Close the random conditions that are missing in a folder, and join their rows."""
    entries = [
        Entry(f"effects/random_scene_{number}", validated_scene, (settings, number))
        for number in range(settings.design.scenes)
    ]
    prepare = partial(compile_all, kernels, log)
    make_missing(entries, folder, workers, log.show, "random conditions closed", prepare)
    return as_table(*(read_netcdf(entry.file(folder)) for entry in entries))


if __name__ == "__main__":
    with job(snakemake) as logbook:
        params, outputs = snakemake.params, snakemake.output
        folder = Path(outputs.scenes).parents[1]
        scenes = closed_scenes(params.settings, params.kernels, folder, snakemake.threads, logbook)
        summary = validation_summary(scenes)
        write_csv(scenes, outputs.scenes)
        write_csv(summary, outputs.summary)
        logbook(summary.round(2).to_string(index=False))
        figures = {name: draw(scenes) for name, draw in FIGURES.items()}
        save_figures(figures, outputs.figures, logbook)
